"""What is known of a registered id: its environment, made with default arguments, and the notes on it."""

import inspect
from dataclasses import dataclass
from typing import Any

import gymnasium as gym

from grind_env.envs.actions import ACTIONS, ActionCodec
from grind_env.envs.env import GrindEnv
from grind_env.envs.job.env import EXAMPLE
from grind_env.envs.names import environment_id
from grind_env.envs.observations import Reading
from grind_env.envs.reciprocation.env import ReciprocationEnv
from grind_env.envs.stroke.env import StrokeEnv
from grind_env.envs.tasks import Task
from grind_env.errors import did_you_mean, quoted
from grind_env.pages.notes import Note, PageError, note_of
from grind_env.pages.rewards import Span, cost_spans, infeed_times, reward_span, single_stroke_times, stroke_times


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """What a page is made of.

    Attributes:
        id: the id.
        note: the notes on it.
        env: an environment of that id, before its first step.
        readings: entries of the observation.
        full: entries of the observation with the hidden state; as `readings` where it cannot be asked for.
        task: its task, if a step is a block of one.
        codec: its actions; None where they are not E and D.
        costs: cost of a step in $ by term, if they can be worked out.
        reference_cost: what a reward of -1 stands for, $; 0 where that is not told.
        reward: lowest and highest reward of a step, minus infinity where no lower bound is known.
    """

    id: str
    note: Note
    env: gym.Env[Any, Any]
    readings: tuple[Reading, ...]
    full: tuple[Reading, ...]
    task: Task | None
    codec: ActionCodec | None
    costs: dict[str, Span]
    reference_cost: float
    reward: Span

    @property
    def title(self) -> str:
        """The job in a few words."""
        return self.task.title if self.task else (type(self.env).__doc__ or "").partition("\n")[0].rstrip(".")

    @property
    def steps(self) -> int:
        """Steps of an episode; 0 where they are not fixed."""
        return self.task.blocks if self.task else self.note.blocks

    @property
    def forms(self) -> tuple[str, ...]:
        """Forms of the action."""
        return ("box",) if self.codec is None else ACTIONS


def page_ids() -> list[str]:
    """The registered ids, the flagship first."""
    ids = [name for name, spec in gym.registry.items() if spec.namespace == "grind"]
    return sorted(ids, key=lambda name: (name != "grind/PowerLimited-v0", name.lower()))


def sheet(name: str) -> Sheet:
    """What is known of an id.

    Args:
        name: the id, or the name of its task.

    Raises:
        PageError: if the id is not registered or has no notes, or if nothing is known of its reward.
    """
    known = page_ids()
    env_id = name if name in known else environment_id(name)
    if env_id not in known:
        raise PageError(
            f"there is no environment {quoted(name)}{did_you_mean(name, known, 0.5)}; the ids are {', '.join(known)}"
        )
    note = note_of(env_id)
    arguments: dict[str, Any] = {"program": str(EXAMPLE.with_name(note.program))} if note.program else {}
    env: Any = gym.make(env_id, **arguments).unwrapped
    readings: tuple[Reading, ...] = env.observation_info()
    full = readings
    if "observation" in inspect.signature(type(env)).parameters:
        oracle: Any = gym.make(env_id, observation="full", **arguments).unwrapped
        full = oracle.observation_info()
    priced: Task | None = env.task if isinstance(env, GrindEnv) else None
    task = None if isinstance(env, StrokeEnv) else priced
    costs = {} if priced is None else cost_spans(priced, _times(env))
    return Sheet(
        id=env_id,
        note=note,
        env=env,
        readings=readings,
        full=full,
        task=task,
        codec=getattr(env, "codec", None),
        costs=costs,
        reference_cost=0.0 if priced is None else priced.reference_cost,
        reward=_noted(env_id, note) if priced is None else reward_span(priced, costs),
    )


def _times(env: GrindEnv) -> dict[str, Span]:
    """Seconds of a step without its dresses, by kind."""
    if isinstance(env, StrokeEnv):
        return single_stroke_times(env.task)
    return infeed_times(env.task) if isinstance(env, ReciprocationEnv) else stroke_times(env.task)


def _noted(env_id: str, note: Note) -> Span:
    if note.reward is None:
        raise PageError(f"the reward of {env_id} has no range: give its notes a reward")
    return Span(*note.reward)
