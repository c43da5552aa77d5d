"""Observations, rewards and infos of fixed actions, for every environment id and every form of the action.

There is one table for each form, recorded from a vector of two environments with all observations. Single
environments have the same bits; `observation="measured"` returns some of the columns.
"""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from grind_env.envs.actions import ACTIONS, ActionError
from grind_env.envs.infos import READINGS
from tests.behaviour.tables import Table, Tables, flat, table
from tests.envs.harness import Array, native, reward_terms_of, row_of, rows_of

COUNT = 2  #: environments in the vector

SEED = 11

BRIEF = 8  #: steps with each form of the action other than the box; the decisions are the same in every form

LEAST, AFTER = 24, 3  #: with a box action: the least number of steps, and the steps after every first episode has ended

EXAMPLES = Path(__file__).parents[2] / "grind_env" / "examples"
PROGRAMS = Path(__file__).with_name("programs")

#: programs with which `grind/Job-v0` is recorded besides its own example
JOBS = {
    **{name: EXAMPLES / f"{name}.nc" for name in ("keyway_g81", "rail_g83")},
    **{name: PROGRAMS / f"{name}.nc" for name in ("stages", "lots")},
}

#: arguments that put the text of the blocks, probabilities and true ratios into the info
SHOWN: dict[str, Any] = {"show_block": True, "info": "full"}

Kinds = dict[str, dict[str, Any]]


def kinds_of(env_id: str) -> Kinds:
    """Return the arguments for every form of the action that an environment accepts, by name."""
    kinds: Kinds = {}
    for form, predress in itertools.product(ACTIONS, (False, True)):
        kind = {"action": form, "predress": predress}
        try:
            gym.make(env_id, **kind)
        except ActionError:
            continue
        kinds[f"{form} with pre-dress" if predress else form] = kind
    if env_id == "grind/Job-v0":
        kinds |= {f"box, {name}": {"action": "box", "program": str(path)} for name, path in JOBS.items()}
    return kinds


def recorded(env_id: str) -> Tables:
    """Play an environment; return a table for every form of the action, and the part program."""
    tables: Tables = {}
    for name, kind in kinds_of(env_id).items():
        steps = None if kind["action"] == "box" else BRIEF
        tables[name] = vector_play(env_id, steps, observation="full", **kind)
    return tables | {"part program": part_program(env_id)}


def columns(env_id: str, *, observation: str, **kwargs: Any) -> list[str]:
    """Return a column name for every entry of the observation, in order; `hidden` if it is not measured."""

    def entries(observation: str) -> list[str]:
        return [each.name for each in gym.make(env_id, observation=observation, **kwargs).unwrapped.observation_info()]

    measured = set(entries("measured"))
    return [f"{'observation' if name in measured else 'hidden'}.{name}" for name in entries(observation)]


def part_program(env_id: str) -> Table:
    """Return the part program of the first steps, line by line; no rows if the environment writes none."""
    env = gym.make(env_id).unwrapped
    env.reset(seed=SEED)
    for batch in itertools.islice(actions(env.action_space), BRIEF):
        if env.step(rows_of(batch, COUNT)[0])[2]:
            break
    lines = env.part_program().splitlines() if hasattr(env, "part_program") else []
    return table({"line": number, "text": line} for number, line in enumerate(lines, 1))


def vector_play(env_id: str, steps: int | None, **kwargs: Any) -> Table:
    """Play the native vector environment; `steps` of None plays all first episodes and a little of the next."""
    env = native(env_id, COUNT, **SHOWN, **kwargs)
    names = columns(env_id, **kwargs)
    observations, _ = env.reset(seed=SEED)
    rows = [row(0, i, names, observations[i]) for i in range(COUNT)]
    over, ended = np.zeros(COUNT, bool), np.zeros(COUNT, bool)
    for step, batch in enumerate(actions(env.unwrapped.single_action_space), 1):
        resetting = over
        stepped = env.step(batch)
        over = stepped[2] | stepped[3]
        for i in range(COUNT):
            observation, *rest = (stepped[0][i],) if resetting[i] else row_of(stepped, i)
            rows.append(row(step, i, names, observation, *rest))
        if steps is None and (ended := ended | over).all():
            steps = max(step + AFTER, LEAST)
        if step == steps:
            break
    return table(rows)


def row(
    step: int,
    env: int,
    names: list[str],
    observation: Array,
    reward: float | None = None,
    terminated: bool | None = None,
    truncated: bool | None = None,
    info: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Return a row of the table; a reset has only an observation."""
    seen = dict(zip(names, observation.tolist(), strict=True))
    extra = {name: value for name, value in (info or {}).items() if name not in READINGS}  # readings are observed
    if terms := reward_terms_of(extra):  # recorded under their former name
        extra = {"reward_terms": terms} | {name: value for name, value in extra.items() if name[7:] not in terms}
    outcome = {"reward": reward, "terminated": terminated, "truncated": truncated}
    return {"step": step, "env": env, **seen, **outcome, **dict(flat("info", extra))}


def actions(space: spaces.Space[Any]) -> Iterator[Any]:
    """Yield batches of actions of a single action space, the same ones in every call."""
    rng = np.random.default_rng(5)
    while True:
        yield drawn(space, rng)


def drawn(space: spaces.Space[Any], rng: np.random.Generator) -> Any:
    """Return `COUNT` actions: the first is uniform, the second mostly slow with few dresses.

    Gymnasium's own samples could change with its version.
    """
    if isinstance(space, spaces.Dict):
        return {name: drawn(each, rng) for name, each in space.items()}
    uniform = rng.random((COUNT, *(space.shape or ())))
    uniform[1] *= uniform[1] * uniform[1]
    if isinstance(space, spaces.Box):
        return (space.low + (space.high - space.low) * uniform).astype(space.dtype)
    choices = space.nvec if isinstance(space, spaces.MultiDiscrete) else space.n
    return (uniform * choices).astype(np.int64)
