"""What an adapter of the track is: a policy that may have a method `learn(shift)`; see `grind_env.policies.track`."""

from grind_env.policies.track import Learner, TrackShift

__all__ = ["Learner", "TrackShift"]
