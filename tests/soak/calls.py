"""Hostile calls of an environment: a call that is refused with an error sentence changes nothing.

Accepted calls are repeated on a twin and have to give the same result. Now and then one of the two is replaced by a
deep copy of the other, and a third environment of the same id is stepped in between.
"""

import inspect
import random
import warnings
from copy import deepcopy
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import load_env_creator

from grind_env.errors import GrindError
from tests.envs.harness import FORMS, MODES, assert_same, every_id
from tests.soak.part import Part, Tried, broken, fallen, refused

CALLS = 40
REFUSALS = GrindError, gym.error.Error
NUMBERS: tuple[Any, ...] = (
    *(0, 1, -1, 0.5, 1e30, -1e308, 10**400, float("nan"), float("inf"), -0.0, 5e-324, 2**63, -(2**63), 1 + 1e-7),
    *(True, None, "0", b"0", "", "\x1b[31m", 1j, [], {}, (), object(), np.datetime64("nat"), np.float16("inf")),
)
#: numbers of environments; large ones are left out, because they only need memory
SMALL = 0, -1, 1, 2.5, "2", None, True, [2], float("nan")
MADE = 0.3  #: share of cases that make an environment with odd arguments
SEEDS: tuple[Any, ...] = (-1, 0.5, "one", True, 2**40, 10**30, [], [1], [1, -1], {}, np.array(3), np.array([1.5]), 7, 8)
SPLITS: tuple[Any, ...] = ("all", "inner", "interpolation", "extrapolation", "exam", "", None, 3, ["all"])


def attempt(seed: int) -> Tried:
    """Make hostile calls of the environment of a seed."""
    ids, rng = every_id(), random.Random(seed)
    env_id = ids[seed % len(ids)]
    if rng.random() < MADE:
        return _made(env_id, rng)
    words = {"action": rng.choice(FORMS)}
    if rng.random() < 0.5:
        count, mode = rng.choice((1, 2, 3, 17)), rng.choice(MODES)
        made = [gym.make_vec(env_id, count, autoreset_mode=mode, **words) for _ in range(3)]
    else:
        count = 0
        made = [gym.make(env_id, disable_env_checker=True, **words) for _ in range(3)]
    return _Play(rng, env_id, count, *made).run()


def _made(env_id: str, rng: random.Random) -> Tried:
    """Make an environment with arguments that are usually wrong."""
    spec, vector = gym.spec(env_id), rng.random() < 0.5
    create = load_env_creator(spec.vector_entry_point if vector else spec.entry_point)
    names = list(inspect.signature(load_env_creator(spec.entry_point)).parameters)
    words = {rng.choice([*names, "no_such"]): rng.choice((*NUMBERS, *SPLITS)) for _ in range(rng.choice((1, 1, 3)))}
    if vector and rng.random() < 0.5:
        words[rng.choice(("num_envs", "autoreset_mode"))] = rng.choice((*SMALL, *MODES))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            create(**{"num_envs": 2, **words} if vector else words).reset(seed=0)
    except GrindError as error:
        return refused(error)
    except REFUSALS:
        return Tried("refused", sums={"refused by gymnasium": 1})
    except Exception as error:
        if isinstance(error, TypeError) and "unexpected keyword argument" in str(error):
            return Tried("refused", sums={"refused by Python": 1})
        return fallen(error, f"{env_id} {words}")
    return Tried("accepted", sums={"made of odd arguments": 1})


class _Play:
    """Hostile calls of an environment, with its twin and a third environment."""

    def __init__(self, rng: random.Random, env_id: str, count: int, env: Any, twin: Any, stranger: Any) -> None:
        self.rng, self.id, self.count = rng, env_id, count
        self.env, self.twin, self.stranger = env, twin, stranger
        self.sums = {f"calls of {env_id}": CALLS, "refused": 0, "let through": 0, "deep copies": 0}
        for each in (env, twin, stranger):
            each.action_space.seed(rng.randrange(1 << 30))

    def run(self) -> Tried:
        start = self.rng.randrange(1 << 30)
        for each in (self.env, self.twin, self.stranger):
            each.reset(seed=start)
        for number in range(CALLS):
            name, arguments, keywords = self._drawn()
            try:
                self._do(name, arguments, keywords)
            except AssertionError as error:
                return broken(f"{self.id}: the twin differs", f"call {number}, {name}: {error}")
            except Exception as error:
                return fallen(error, f"{self.id}, {self.count} at a time, call {number}: {name}{arguments}{keywords}")
        return Tried("accepted", sums=self.sums)

    def _do(self, name: str, arguments: tuple[Any, ...], keywords: dict[str, Any]) -> None:
        if self.rng.random() < 0.3:
            with_stranger = self.stranger.action_space.sample()
            try:
                self.stranger.step(with_stranger)
            except REFUSALS:  # its episode is over
                self.stranger.reset()
        if name == "copy":
            self.sums["deep copies"] += 1
            self.env, self.twin = (deepcopy(self.twin), self.twin) if arguments[0] else (self.env, deepcopy(self.env))
            return
        try:
            found = getattr(self.env, name)(*arguments, **keywords)
        except REFUSALS as error:
            if not str(error) or not str(error).isprintable():
                raise ValueError(f"no sentence: {str(error)!r}") from error
            self.sums["refused"] += 1
            return
        self.sums["let through"] += 1
        assert_same(found, getattr(self.twin, name)(*arguments, **keywords))

    def _drawn(self) -> tuple[str, tuple[Any, ...], dict[str, Any]]:
        """Draw a call; return its method and arguments."""
        rng = self.rng
        kind = rng.random()
        if kind < 0.4:
            return "step", (self.env.action_space.sample(),), {}
        if kind < 0.65:
            return "step", (self._hostile(self.env.action_space.sample()),), {}
        if kind < 0.7:
            return "copy", (rng.random() < 0.5,), {}
        if kind < 0.8:
            return "reset", (), {"seed": rng.randrange(1 << 30)}
        if kind < 0.9:
            return "reset", (), {"seed": rng.choice(SEEDS), "options": self._options()}
        return "reset", (), {"options": self._options()}

    def _hostile(self, action: Any) -> Any:
        """Return an action that is usually invalid."""
        rng = self.rng
        kind = rng.random()
        if kind < 0.2:
            return rng.choice(NUMBERS)
        if isinstance(action, dict):
            names = list(action)
            changed = {**action, rng.choice([*names, "X"]): rng.choice(NUMBERS)}
            return changed if kind < 0.8 else {name: action[name] for name in names[1:]}
        flat = np.asarray(action).ravel().tolist()
        if kind < 0.7:
            flat[rng.randrange(len(flat))] = rng.choice(NUMBERS)
            return flat if np.ndim(action) < 2 else [flat[k : k + 2] for k in range(0, len(flat), 2)]
        array = np.asarray(action)
        return rng.choice((array[None], array[..., None], array.astype(object), array.astype("U"), array * 1e9, flat))

    def _options(self) -> Any:
        rng = self.rng
        value = rng.choice(NUMBERS)
        return rng.choice(
            (
                *(value, {}, None, {"split": rng.choice(SPLITS)}, {"context": value}, {"context": {"E": value}}),
                *({"context": {"wear": value, "\x1b": 1}}, {"no such": value}, {7: 8}, {"plant": value}),
                *({"reset_mask": value}, {"reset_mask": np.ones(max(self.count, 1), bool)}),
                *({"reset_mask": np.zeros(max(self.count, 1), bool)}, {"reset_mask": np.arange(self.count) == 0}),
            )
        )


PART = Part(name="calls", attempt=attempt, share=2.0, growth=50.0)
