"""What is known of a registered id: its environment, made with default arguments, and the notes on it."""

import difflib
import inspect
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym

from grind_env.envs.actions import ACTIONS
from grind_env.envs.env import GrindEnv
from grind_env.envs.observations import Reading
from grind_env.envs.pages.notes import Note, PageError, note_of
from grind_env.envs.pages.rewards import Span, cost_spans, infeed_times, reward_span, stroke_times
from grind_env.envs.reciprocation_env import ReciprocationEnv
from grind_env.envs.tasks import Task

EXAMPLES = Path(__file__).parents[2] / "examples"
"""Part programs of the package."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """What a page is made of.

    Attributes:
        id: the id.
        note: the notes on it.
        env: an environment of that id, never reset.
        readings: entries of the observation.
        full: entries of the observation with the hidden state; as `readings` where it cannot be asked for.
        task: its task, if it has one.
        costs: cost of a step in $ by term, if it has a task.
        reward: lowest and highest reward of a step, if they can be told.
    """

    id: str
    note: Note
    env: gym.Env[Any, Any]
    readings: tuple[Reading, ...]
    full: tuple[Reading, ...]
    task: Task | None
    costs: dict[str, Span]
    reward: Span | None

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
        return ACTIONS if "action" in inspect.signature(type(self.env)).parameters else ("box",)


def page_ids() -> list[str]:
    """The registered ids, the flagship first."""
    ids = [name for name, spec in gym.registry.items() if spec.namespace == "grind"]
    return sorted(ids, key=lambda name: (name != "grind/PowerLimited-v0", name.lower()))


def sheet(env_id: str) -> Sheet:
    """What is known of an id.

    Raises:
        PageError: if the id is not registered or has no notes.
    """
    if env_id not in page_ids():
        close = difflib.get_close_matches(env_id, page_ids(), 1, 0.5)
        hint = f" (did you mean {close[0]}?)" if close else ""
        raise PageError(f"there is no environment {env_id!r}{hint}; the ids are {', '.join(page_ids())}")
    note = note_of(env_id)
    arguments: dict[str, Any] = {"program": str(EXAMPLES / note.program)} if note.program else {}
    env: Any = gym.make(env_id, **arguments).unwrapped
    readings: tuple[Reading, ...] = env.observation_info()
    full = readings
    if "observation" in inspect.signature(type(env)).parameters:
        oracle: Any = gym.make(env_id, observation="full", **arguments).unwrapped
        full = oracle.observation_info()
    task: Task | None = env.task if isinstance(env, GrindEnv) else None
    costs, reward = {}, None if note.reward is None else Span(*note.reward)
    if task is not None:
        times = infeed_times(task) if isinstance(env, ReciprocationEnv) else stroke_times(task)
        costs = cost_spans(task, times)
        reward = reward_span(task, costs)
    return Sheet(id=env_id, note=note, env=env, readings=readings, full=full, task=task, costs=costs, reward=reward)
