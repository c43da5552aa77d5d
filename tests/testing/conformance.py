"""Does a vector environment keep the contract of `gymnasium.vector.VectorEnv`?

Gymnasium's `check_env` checks single environments only. `check_vector_env` checks any vector environment through
its public methods: nothing here knows what the environment is about, and nothing but Gymnasium and NumPy is needed.
The contract is that of Gymnasium 1.4, with `SyncVectorEnv` as the reference where its documentation is silent.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

from tests.testing.conformance_play import (
    AnyVectorEnv,
    Event,
    Plan,
    Subject,
    VectorConformanceError,
    at_the_end,
    check_info,
    dtypes,
    episodes,
    first_end,
    made,
    outside,
    play,
    raises,
    rows,
    spoil,
)

__all__ = ["VectorConformanceError", "check_vector_env"]

FLAGS = {2: "terminations", 3: "truncations"}
"""Place in the result of `step()` of the two arrays of flags."""


def check_vector_env(
    make: Callable[[AutoresetMode], AnyVectorEnv],
    *,
    single: Callable[[], gym.Env[Any, Any]] | None = None,
    modes: Sequence[AutoresetMode] = tuple(AutoresetMode),
    steps: int = 200,
    seed: int = 0,
    seeds_each: bool = True,
    copies: bool = True,
    strict_actions: bool = True,
) -> None:
    """Check a vector environment.

    Args:
        make: makes it, with two or more sub-environments, in the autoreset mode that it is given.
        single: makes the single environment, if the vector environment claims to be `SyncVectorEnv` of it.
        modes: the autoreset modes that it knows.
        steps: steps to play; every sub-environment must end an episode within them.
        seed: first seed.
        seeds_each: whether every sub-environment has random numbers of its own, so that `reset` takes a list of
            seeds, an int meaning `seed, seed + 1, ...`, and `options["reset_mask"]`.
        copies: whether the caller owns what is returned; False if buffers are handed out on purpose.
        strict_actions: whether actions outside the action space have to be refused, not only wrong batch sizes.

    Raises:
        VectorConformanceError: at the first breach.
    """
    for mode in modes:
        subject = Subject(make, single, tuple(modes), mode, steps, seed, seeds_each, copies, strict_actions)
        for check in CHECKS:
            check(subject)


# --- the checks ----------------------------------------------------------------------------------------------


def check_spaces(subject: Subject) -> None:
    """Spaces are batches of the single ones, and those of the single environment."""
    env = made(subject)
    subject.require(isinstance(env, VectorEnv), f"{type(env).__name__} is no VectorEnv")
    subject.require(
        isinstance(env.num_envs, int) and env.num_envs >= 2, f"num_envs is {env.num_envs!r}, but must be 2 or more here"
    )
    for name in ("observation_space", "action_space"):
        one, batch = getattr(env, f"single_{name}"), getattr(env, name)
        expected = batch_space(one, env.num_envs)
        subject.require(batch == expected, f"{name} is {batch}, but must be batch_space(single_{name}, num_envs)")
        if subject.single is not None:
            alone = getattr(subject.single(), name)
            subject.require(one == alone, f"single_{name} is {one}, but the single environment has {alone}")


def check_metadata(subject: Subject) -> None:
    """`metadata["autoreset_mode"]` is the mode asked for, and stays so when another environment is made."""
    env = made(subject)
    for other in subject.modes:
        subject.make(other)
        found = env.metadata.get("autoreset_mode")
        subject.require(
            found is subject.mode,
            f'metadata["autoreset_mode"] is {found!r} once an environment in mode {other.value} has been made, but '
            f"must be AutoresetMode.{subject.mode.name}: set it on the instance",
        )


def check_results(subject: Subject) -> None:
    """Results have the right types, shapes and dtypes, always the same ones, and observations lie in their space."""
    env = made(subject)
    kinds: dict[str, np.dtype[Any]] = {}
    for event in play(subject, env):
        shape, size = (env.num_envs,), 2 if event.call == "reset()" else 5
        place = f"of {event.call}"
        subject.require(
            isinstance(event.result, tuple) and len(event.result) == size,
            f"the result {place} must be a tuple of {size}",
        )
        observations, info = event.result[0], event.result[-1]
        subject.require(
            env.observation_space.contains(observations),
            f"observations {place} are not in observation_space: look at bounds, shape and dtype",
        )
        check_info(subject, info, env.num_envs, place)
        for path, kind in dtypes(info):
            before = kinds.setdefault(path, kind)
            subject.require(kind == before, f"{path} {place} has dtype {kind}, but had {before} before")
        if event.call == "reset()":
            continue
        rewards = event.result[1]
        subject.require(
            isinstance(rewards, np.ndarray) and rewards.shape == shape and np.issubdtype(rewards.dtype, np.floating),
            f"rewards {place} must be a float array of shape {shape}",
        )
        subject.require(np.isfinite(rewards).all(), f"rewards {place} must be finite")
        for k, name in FLAGS.items():
            flags = event.result[k]
            subject.require(
                isinstance(flags, np.ndarray) and flags.shape == shape and flags.dtype == bool,
                f"{name} {place} must be a bool array of shape {shape}",
            )


def check_seeds(subject: Subject) -> None:
    """The same seed starts the same episodes, and no seed goes on with the random numbers at hand."""
    env, seed = made(subject), subject.seed
    first = deepcopy(env.reset(seed=seed)), deepcopy(env.reset())
    again = deepcopy(env.reset(seed=seed)), deepcopy(env.reset())
    subject.require_same(first[0], again[0], f"two results of reset(seed={seed})")
    subject.require_same(first[1], again[1], f"two results of reset() after reset(seed={seed})")
    if not subject.seeds_each:
        return
    n = env.num_envs
    each: Any = [seed + i for i in range(n)]
    listed = deepcopy(env.reset(seed=each))
    subject.require_same(first[0], listed, f"the results of reset with seed {seed} and with {seed}, {seed + 1}, ...")
    others: Any = [seed, *(seed + 1000 + i for i in range(1, n))]
    row = rows(env, env.reset(seed=others)[0])[0]
    subject.require_same(rows(env, listed[0])[0], row, "first observations of one seed with other seeds beside it")
    many: Any = [seed] * (n + 1)
    subject.require(raises(partial(env.reset, seed=many)), f"reset() takes {n + 1} seeds for {n} sub-environments")


def check_reproducible(subject: Subject) -> None:
    """Two environments with the same seed and actions give the same results."""
    for event, twin in zip(play(subject, made(subject)), play(subject, made(subject)), strict=True):
        subject.require_same(event, twin, f"results of {event.call} from two environments with the same seed and plan")


def check_autoreset(subject: Subject) -> None:
    """What the autoreset mode promises for sub-environments whose episode has ended."""
    env, twin = made(subject), made(subject)
    over = np.zeros(env.num_envs, bool)
    last: list[Any] = []
    # the twin is given other actions in those rows whose actions do not count
    for event, other in zip(play(subject, env), play(subject, twin, twist=True), strict=True):
        if event.call == "reset()":
            for i in np.flatnonzero(~event.rows):
                now = rows(env, event.result[0])[i]
                subject.require_same(last[i], now, f"observation {i} before and after a reset whose mask leaves it out")
            last = rows(env, deepcopy(event.result[0]))
            continue
        observations, rewards, terminations, truncations, info = event.result
        ended = terminations | truncations
        if subject.mode is AutoresetMode.NEXT_STEP:
            quiet = (rewards[over] == 0.0).all() and not ended[over].any()
            subject.require(quiet, "the step after an end must give reward 0 and no flags there")
            subject.require_same(event, other, "results of the step after an end, which must ignore the action there,")
        if subject.mode is AutoresetMode.SAME_STEP and ended.any():
            for name in ("final_obs", "final_info"):
                mask = info.get(f"_{name}")
                subject.require(
                    name in info and mask is not None and (np.asarray(mask) == ended).all(),
                    f"an end must come with info['{name}'], and info['_{name}'] must mark the ended sub-environments",
                )
            for i in np.flatnonzero(ended):
                inside = env.single_observation_space.contains(info["final_obs"][i])
                subject.require(inside, f"info['final_obs'][{i}] is not in single_observation_space")
        over, last = ended.copy(), rows(env, deepcopy(observations))


def check_modes_agree(subject: Subject) -> None:
    """Episodes with the same seeds and actions are the same in every mode, transition by transition."""
    if not subject.seeds_each:
        return
    reference, here = (episodes(subject, mode) for mode in (subject.modes[0], subject.mode))
    for i, (expected, found) in enumerate(zip(reference, here, strict=True)):
        for k, (a, b) in enumerate(zip(expected, found, strict=False)):
            where = f"event {k} of sub-environment {i}"
            subject.require_same(a, b, f"{where} here and in autoreset mode {subject.modes[0].value}")


def check_reset_mask(subject: Subject) -> None:
    """A masked reset with a seed starts the episode of that seed, in the masked sub-environments only."""
    if not subject.seeds_each:
        return
    env = made(subject)
    plan = Plan(env, subject)
    env.reset(seed=subject.seed)
    before = rows(env, deepcopy(env.step(plan.actions(np.zeros(env.num_envs, int)))[0]))
    fresh = rows(env, deepcopy(made(subject).reset(seed=subject.seed + 7)[0]))
    mask = np.arange(env.num_envs) == env.num_envs - 1
    observations, info = env.reset(seed=subject.seed + 7, options={"reset_mask": mask})
    for i, row in enumerate(rows(env, observations)):
        expected = fresh[i] if mask[i] else before[i]
        what = "the seeded first observation" if mask[i] else "the one before the reset, whose mask leaves it out,"
        subject.require_same(expected, row, f"observation {i} after a masked reset and {what}")
    for name, marks in info.items():
        marked = name.startswith("_") and np.any(np.asarray(marks) & ~mask)
        subject.require(not marked, f"info['{name}'] marks sub-environments that options['reset_mask'] leaves out")


def check_reset_after_end(subject: Subject) -> None:
    """A reset by the caller after an end is the one that was due: no other one follows."""
    seed = subject.seed + 7
    for masked in (False, True) if subject.seeds_each else (False,):
        env, fresh = made(subject), made(subject)
        over = first_end(subject, env)
        chosen = over.copy() if masked else np.ones(env.num_envs, bool)
        actions = Plan(env, subject).actions(np.zeros(env.num_envs, int))
        fresh.reset(seed=seed)
        env.reset(seed=seed, options={"reset_mask": chosen.copy()} if masked else None)
        expected, found = fresh.step(deepcopy(actions)), env.step(deepcopy(actions))
        for i in np.flatnonzero(chosen):
            a, b = ((rows(env, each[0])[i], *(part[i] for part in each[1:4])) for each in (expected, found))
            where = f"results {i} of the first step after reset(seed={seed}) at the start and after an end"
            subject.require_same(a, b, where)


def check_ownership(subject: Subject) -> None:
    """Nobody but the caller changes a result, and nothing that the caller does to it comes back."""
    if not subject.copies:
        return
    kept: list[tuple[Event, Event]] = []
    for event, spoilt in zip(play(subject, made(subject)), play(subject, made(subject)), strict=True):
        subject.require_same(event, spoilt, f"results of {event.call} with and without writing into earlier results")
        kept.append((event, deepcopy(event)))
        spoil(spoilt.result)
    for event, copy in kept:
        subject.require_same(event, copy, f"the result of {event.call} and the same after later calls")


def check_actions(subject: Subject) -> None:
    """Actions are not changed; wrong batch sizes and, if strict, actions outside the space are refused."""
    env = made(subject)
    plan = Plan(env, subject)
    start = np.zeros(env.num_envs, int)
    env.reset(seed=subject.seed)
    actions = plan.actions(start)
    copy = deepcopy(actions)
    env.step(actions)
    subject.require_same(copy, actions, "the actions before and after step()")
    if not isinstance(actions, np.ndarray):
        return
    bad = {f"{env.num_envs - 1} rows": actions[:-1], f"{env.num_envs + 1} rows": actions[[*range(env.num_envs), 0]]}
    if subject.strict_actions:
        bad[f"shape {(*actions.shape, 2)}"] = np.stack([actions, actions], axis=-1)
        bad |= {f"{value!r} in the last row": at_the_end(actions, value) for value in outside(env.single_action_space)}
    for name, value in bad.items():
        env = made(subject)
        env.reset(seed=subject.seed)
        subject.require(raises(partial(env.step, value)), f"step() takes actions with {name}")


def check_close(subject: Subject) -> None:
    """Closing twice is closing once."""
    env = made(subject)
    env.reset(seed=subject.seed)
    env.close()
    subject.require(not raises(env.close), "close() fails when it is called again")


def check_parity(subject: Subject) -> None:
    """The environment gives what `SyncVectorEnv` of the single environment gives, infos included."""
    if subject.single is None:
        return
    env = made(subject)
    sync = SyncVectorEnv([subject.single] * env.num_envs, autoreset_mode=subject.mode)
    for event, expected in zip(play(subject, env), play(subject, sync), strict=True):
        subject.require_same(expected, event, f"results of {event.call} here and of SyncVectorEnv")


CHECKS: tuple[Callable[[Subject], None], ...] = (
    check_spaces,
    check_metadata,
    check_results,
    check_seeds,
    check_reproducible,
    check_autoreset,
    check_modes_agree,
    check_reset_mask,
    check_reset_after_end,
    check_ownership,
    check_actions,
    check_close,
    check_parity,
)
