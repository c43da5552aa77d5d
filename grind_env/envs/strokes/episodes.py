"""The state of episodes of `grind/Stroke-v0`."""

from dataclasses import dataclass

from grind_env.arrays import Numbers, Table
from grind_env.envs.episodes import Episodes, EpisodesT


@dataclass(slots=True)
class StrokeEpisodes(Episodes):
    """The state of N episodes; the arrays are those of `step.StrokeArrays`, `block` counts finished parts."""

    strokes: Table
    paces: Table
    plunges: Table
    parameters: Table

    def window(self: EpisodesT, tape: Table, owner: Numbers, first: int, blocks: int) -> EpisodesT:
        """The branches as they are: their tapes have a row a part, and each of them is somewhere on one."""
        return self
