"""Data of a registered id: its environment with default arguments, and its notes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import load_env_creator

from grind_env.envs.job.loading import EXAMPLE
from grind_env.envs.observations import Reading
from grind_env.envs.task_names import environment_id
from grind_env.envs.tasks import Task
from grind_env.message_text import did_you_mean, quoted
from grind_env.pages.reward_bounds import RewardSpan, cost_spans, infeed_times, reward_span, stroke_times
from grind_env.pages.task_notes import PageError, PageNote, note_of


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSheet:
    """Data of a task page; `full` has the readings with the hidden state, `reward` may have no lower bound."""

    id: str
    note: PageNote
    make: Callable[..., Any]
    env: Any
    readings: tuple[Reading, ...]
    full: tuple[Reading, ...]
    task: Task | None
    costs: dict[str, RewardSpan]
    reward: RewardSpan

    @property
    def title(self) -> str:
        return self.task.title if self.task else (self.make.__doc__ or "").partition("\n")[0].rstrip(".")

    @property
    def steps(self) -> int:
        """Number of steps of an episode; 0 if it is not fixed."""
        return self.task.blocks if self.task else 0


def page_ids() -> list[str]:
    """Return the registered ids, the flagship first."""
    ids = [name for name, spec in gym.registry.items() if spec.namespace == "grind"]
    return sorted(ids, key=lambda name: (name != "grind/PowerLimited-v0", name.lower()))


def sheet(name: str) -> TaskSheet:
    """Return the data of a registered id, or of the id of a task.

    Raises:
        PageError: the id is not registered or has no notes.
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
    oracle: Any = gym.make(env_id, observation="full", **arguments).unwrapped
    # a part program has no task from which the reward could be computed
    task = env.task if note.reward is None else None
    costs = {} if task is None else cost_spans(task, (infeed_times if task.infeed > 0.0 else stroke_times)(task))
    return TaskSheet(
        id=env_id,
        note=note,
        make=load_env_creator(str(gym.spec(env_id).entry_point)),
        env=env,
        readings=env.observation_info(),
        full=oracle.observation_info(),
        task=task,
        costs=costs,
        reward=RewardSpan(*note.reward) if note.reward else reward_span(env.task, costs),
    )
