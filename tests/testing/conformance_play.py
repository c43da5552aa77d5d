"""Playing a vector environment through its public methods, for `conformance.py`: plans, plays and comparison."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import concatenate, create_empty_array, iterate
from numpy.typing import NDArray

Flags = NDArray[np.bool_]
AnyVectorEnv = VectorEnv[Any, Any, Any]


class VectorConformanceError(AssertionError):
    """A vector environment breaks the contract. The message is one sentence that names mode, call and place."""


@dataclass(frozen=True, slots=True)
class Subject:
    """What is checked, in one autoreset mode, and how; see `conformance.check_vector_env`."""

    make: Callable[[AutoresetMode], AnyVectorEnv]
    single: Callable[[], gym.Env[Any, Any]] | None
    modes: tuple[AutoresetMode, ...]
    mode: AutoresetMode
    steps: int
    seed: int
    seeds_each: bool
    copies: bool
    strict_actions: bool

    def require(self, condition: object, sentence: str) -> None:
        """Raise `VectorConformanceError` unless the condition holds."""
        if not condition:
            raise VectorConformanceError(f"in autoreset mode {self.mode.value}, {sentence}")

    def require_same(self, a: Any, b: Any, sentence: str) -> None:
        """Raise `VectorConformanceError` unless a and b are the same in every type, shape, dtype and value."""
        where = difference(a, b)
        self.require(where is None, f"{sentence} differ in {where}")


class Event(NamedTuple):
    """One call of a play."""

    call: str
    rows: Flags
    """The sub-environments that the call resets, or whose actions count in a step; shape (num_envs,)."""
    result: Any


class Plan:
    """A stream of actions for each sub-environment, which it gets in its own time, whatever the autoreset mode."""

    def __init__(self, env: AnyVectorEnv, subject: Subject) -> None:
        self.space = deepcopy(env.single_action_space)
        self.streams: list[list[Any]] = []
        for i in range(env.num_envs):
            self.space.seed(subject.seed + i)
            self.streams.append([self.space.sample() for _ in range(subject.steps + 1)])

    def actions(self, done: NDArray[np.int64], others: Flags | None = None) -> Any:
        """The batch of actions for sub-environments that have made `done` steps; `others` get different ones."""
        chosen = [
            stream[-1 - k] if others is not None and others[i] else stream[k]
            for i, (stream, k) in enumerate(zip(self.streams, done.tolist(), strict=True))
        ]
        batch: Any = create_empty_array(self.space, len(chosen))
        return concatenate(self.space, chosen, batch)


def made(subject: Subject) -> AnyVectorEnv:
    """A new environment."""
    return subject.make(subject.mode)


def play(subject: Subject, env: AnyVectorEnv, *, twist: bool = False) -> Iterator[Event]:
    """Reset, then step; in DISABLED mode with a masked reset after every end.

    Args:
        subject: what is checked.
        env: the environment.
        twist: give other actions where the autoreset mode says that actions do not count.

    Raises:
        VectorConformanceError: if a sub-environment ends no episode.
    """
    plan = Plan(env, subject)
    over, ever = np.zeros(env.num_envs, bool), np.zeros(env.num_envs, bool)
    done = np.zeros(env.num_envs, np.int64)
    yield Event("reset()", ~over, env.reset(seed=subject.seed))
    for _ in range(subject.steps):
        if subject.mode is AutoresetMode.DISABLED and over.any():
            yield Event("reset()", over, env.reset(options={"reset_mask": over.copy()}))
        idle = over & (subject.mode is AutoresetMode.NEXT_STEP)
        event = Event("step()", ~idle, env.step(plan.actions(done, idle if twist else None)))
        # the flags are copied before the caller of this play can write into them
        flags = [np.array(each, bool) for each in event.result[2:4]]
        yield event
        done += event.rows
        over = flags[0] | flags[1]
        ever |= over
    missing = np.flatnonzero(~ever)
    subject.require(
        missing.size == 0,
        f"sub-environment {missing.tolist()[:1]} ended no episode within {subject.steps} steps: raise `steps`",
    )


def episodes(subject: Subject, mode: AutoresetMode) -> list[list[tuple[Any, ...]]]:
    """What each sub-environment goes through in a mode: how its episodes begin, and every step of theirs."""
    subject = replace(subject, mode=mode)
    env = made(subject)
    found: list[list[tuple[Any, ...]]] = [[] for _ in range(env.num_envs)]
    for event in play(subject, env):
        seen = rows(env, deepcopy(event.result[0]))
        for i in range(env.num_envs):
            told = info_row(event.result[-1], i)
            if event.call == "reset()":
                if event.rows[i]:
                    found[i].append(("begin", seen[i], told))
                continue
            if not event.rows[i]:
                found[i].append(("begin", seen[i], told))
                continue
            _, rewards, terminations, truncations, _ = event.result
            flags = bool(terminations[i]), bool(truncations[i])
            if mode is AutoresetMode.SAME_STEP and any(flags):
                last, final = told.pop("final_obs"), told.pop("final_info")
                found[i].append(("step", last, float(rewards[i]), *flags, final))
                found[i].append(("begin", seen[i], told))
            else:
                found[i].append(("step", seen[i], float(rewards[i]), *flags, told))
    return found


def first_end(subject: Subject, env: AnyVectorEnv) -> Flags:
    """Play an environment until an episode ends; which sub-environments have then ended one, shape (num_envs,).

    Raises:
        VectorConformanceError: if none does.
    """
    flags = (event.result[2] | event.result[3] for event in play(subject, env) if event.call == "step()")
    return np.asarray(next(over for over in flags if over.any()))


def info_row(info: dict[str, Any], i: int) -> dict[str, Any]:
    """What a vector info tells of sub-environment i, copied."""
    found: dict[str, Any] = {}
    for key, value in info.items():
        if (key.startswith("_") and key[1:] in info) or not info.get(f"_{key}", np.ones(i + 1, bool))[i]:
            continue
        found[key] = info_row(value, i) if isinstance(value, dict) else deepcopy(value[i])
    return found


def dtypes(info: dict[str, Any], place: str = "info") -> Iterator[tuple[str, np.dtype[Any]]]:
    """The dtype of every array of a vector info, with the place where it stands."""
    for key, value in info.items():
        if isinstance(value, dict):
            yield from dtypes(value, f"{place}[{key!r}]")
        else:
            yield f"{place}[{key!r}]", value.dtype


def check_info(subject: Subject, info: Any, num_envs: int, place: str, *, nested: bool = False) -> None:
    """A vector info: under each key an array with one entry a sub-environment, or a dict of such, and its mask.

    Masks within a nested dict may be missing: the mask of the dict covers them.
    """
    subject.require(isinstance(info, dict), f"the info {place} must be a dict")
    for key, value in info.items():
        if key.startswith("_") and key[1:] in info:
            continue
        name = f"info[{key!r}] {place}"
        mask = info.get(f"_{key}", np.ones(num_envs, bool) if nested else None)
        subject.require(
            isinstance(mask, np.ndarray) and mask.dtype == bool and mask.shape == (num_envs,),
            f"{name} needs a mask beside it, info['_{key}'], a bool array of shape ({num_envs},)",
        )
        if isinstance(value, dict):
            check_info(subject, value, num_envs, f"within {name}", nested=True)
            continue
        subject.require(
            isinstance(value, np.ndarray) and len(value) == num_envs,
            f"{name} must be an array with {num_envs} entries, one a sub-environment",
        )
        if value.dtype == object:
            empty = all(each is None for each in value[~mask])
            subject.require(empty, f"{name} must be None where info['_{key}'] is False")


def rows(env: AnyVectorEnv, observations: Any) -> list[Any]:
    """A batch of observations, one by one."""
    return list(iterate(env.observation_space, observations))


def raises(call: Callable[[], object]) -> bool:
    """Whether a call raises an exception."""
    try:
        call()
    except Exception:
        return True
    return False


def outside(space: spaces.Space[Any]) -> list[float]:
    """Numbers that no entry of the actions in a space may have."""
    if isinstance(space, spaces.Box) and space.dtype.kind == "f":
        return [float("nan"), float("inf")]  # numbers beyond a bound may be clipped
    if isinstance(space, spaces.Discrete):
        return [float(space.start + space.n)]
    if isinstance(space, spaces.MultiDiscrete):
        return [float(space.start.flat[0] + space.nvec.flat[0])]
    return []


def at_the_end(actions: NDArray[Any], value: float) -> NDArray[Any]:
    """Actions with another first number in the last row."""
    changed = actions.copy()
    changed.reshape(len(changed), -1)[-1, 0] = value
    return changed


def difference(a: Any, b: Any, place: str = "the result") -> str | None:
    """Where a and b differ in type, keys, shape, dtype or value; None if they are the same."""
    if type(a) is not type(b):
        return f"the type of {place}"
    if isinstance(a, dict):
        if a.keys() != b.keys():
            return f"the keys of {place}"
        return first(difference(a[key], b[key], f"{place}[{key!r}]") for key in a)
    if isinstance(a, tuple | list):
        if len(a) != len(b):
            return f"the length of {place}"
        return first(difference(x, y, f"{place}[{k}]") for k, (x, y) in enumerate(zip(a, b, strict=True)))
    if isinstance(a, np.ndarray):
        if (a.dtype, a.shape) != (b.dtype, b.shape):
            return f"dtype or shape of {place}"
        if a.dtype == object:
            return difference(a.tolist(), b.tolist(), place)
        equal = np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    else:
        equal = bool(a == b)
    return None if equal else place


def first(found: Iterator[str | None]) -> str | None:
    """The first that is not None."""
    return next((each for each in found if each is not None), None)


def spoil(value: Any) -> None:
    """Overwrite everything in a result, as a careless caller may."""
    if isinstance(value, dict):
        for each in value.values():
            spoil(each)
    elif isinstance(value, tuple | list):
        for each in value:
            spoil(each)
    elif isinstance(value, np.ndarray) and value.flags.writeable:
        if value.dtype == object:
            for each in value:
                spoil(each)
            value[...] = None
        else:
            value[...] = value == 0
