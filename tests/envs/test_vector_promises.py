"""What vector environments of other steps than blocks of tasks promise as the others do."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.arrays import Array
from grind_env.envs.contexts import ContextError
from grind_env.envs.job.loading import EXAMPLE
from grind_env.machine.part.part import PartRun
from grind_env.machine.run import GrindingError
from tests.envs.harness import assert_same, native

ID = "grind/Job-v0"


@pytest.mark.parametrize(
    "options",
    [
        {"split": ["inner", "nowhere"]},
        {"split": ["inner"]},
        {"split": "interpolation", "context": [None, {"ka": 1.0}]},
        {"context": [{}, {}, {}]},
    ],
)
def test_a_list_that_does_not_fit_moves_no_env(options: dict[str, Any]) -> None:
    env, twin = native(ID, 2, "Disabled"), native(ID, 2, "Disabled")
    for each in (env, twin):
        each.reset(seed=1)
    for mask in (True, False):
        with pytest.raises(ContextError):
            env.reset(seed=5, options=options | {"reset_mask": np.array([True, mask])})
    assert_same(env.step(np.zeros((2, 2), np.float32)), twin.step(np.zeros((2, 2), np.float32)))
    assert_same(env.reset(), twin.reset())


def test_an_option_that_is_refused_ends_no_wait_for_a_reset() -> None:
    env = native(ID, 2, "Disabled", max_episode_steps=2)
    env.reset(seed=0)
    env.step(np.zeros((2, 2), np.float32))
    env.reset(options={"reset_mask": np.array([True, False])})
    assert env.step(np.zeros((2, 2), np.float32))[3].tolist() == [False, True]
    with pytest.raises(ContextError):
        env.reset(options={"weather": "fine"})
    with pytest.raises(gym.error.ResetNeeded, match="episode 1 is over"):
        env.step(np.zeros((2, 2), np.float32))


FAILS = np.array([-1.0, 1.0], np.float32)
SPARES = np.array([1.0, -1.0], np.float32)


GROOVE = "G71 G94 G90 G18\nG00 X1. Z0\nG77 X-1. Z-50. I.7 K40. D0 F6.\nM00\n"
"""Before the plate: there is no script of such a program, and the control executes it."""


def grooved(folder: Path) -> str:
    """The plate behind a groove."""
    program = folder / "grooved.nc"
    program.write_text(EXAMPLE.read_text().replace("N10 ", GROOVE + "N10 ", 1))
    program.with_suffix(".toml").write_text(EXAMPLE.with_suffix(".toml").read_text())
    return str(program)


@pytest.fixture
def hard_job(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """The plate behind a groove, of which no lot but the nominal one can be ground at the lowest E."""
    grind = PartRun.grind

    def picky(part: PartRun, rows: Array, *way: Any) -> Any:
        if rows["E"][0] < 3300.0 and part.conditions.factors:
            raise GrindingError("no finite numbers")
        return grind(part, rows, *way)

    monkeypatch.setattr(PartRun, "grind", picky)
    return {"spread": 2.0, "program": grooved(tmp_path)}


def test_a_step_that_fails_leaves_a_job_where_it_was(hard_job: dict[str, Any]) -> None:
    env, twin = (gym.make(ID, **hard_job) for _ in range(2))
    for each in (env, twin):
        each.reset(seed=2)
        each.step(SPARES)
    for _ in range(2):
        with pytest.raises(GrindingError, match="no finite numbers"):
            env.step(FAILS)
        assert env.unwrapped.part_program() == twin.unwrapped.part_program()
    assert_same(env.step(SPARES), twin.step(SPARES))
    assert_same(env.unwrapped.record().strokes, twin.unwrapped.record().strokes)
    assert_same(env.reset(), twin.reset())


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_no_job_moves_if_one_cannot(hard_job: dict[str, Any], mode: str) -> None:
    env, twin = (native(ID, 3, mode, **hard_job) for _ in range(2))
    good = np.array([SPARES] * 3)
    # the one that fails is in the middle; in every mode another one ends, or has ended and begins anew
    before = 1 if mode == "NextStep" else 0
    for each in (env, twin):
        each.reset(seed=[0, 2, 1])
        each.step(good)
        if before:
            each.reset(seed=[0, 2, 1], options={"reset_mask": np.array([False, True, True])})
            each.step(good)
    bad = good.copy()
    bad[1] = FAILS
    for _ in range(2):
        with pytest.raises(GrindingError, match="no finite numbers"):
            env.step(bad)
    for one, other in zip(env.unwrapped.episodes.programs, twin.unwrapped.episodes.programs, strict=True):
        assert one.chosen == other.chosen
    if mode == "Disabled":  # what the mask leaves out is observed as it was before
        mask = {"reset_mask": np.array([False, False, True])}
        assert_same(env.reset(options=dict(mask)), twin.reset(options=dict(mask)))
    for _ in range(1 if mode == "Disabled" else 3):
        assert_same(env.step(good), twin.step(good))


def test_a_step_that_fails_is_not_counted(hard_job: dict[str, Any]) -> None:
    env, twin = (native(ID, 2, "Disabled", max_episode_steps=2, **hard_job) for _ in range(2))
    good = np.array([SPARES] * 2)
    bad = np.array([SPARES, FAILS])
    for each in (env, twin):
        each.reset(seed=[0, 2])
        each.step(good)
        each.reset(seed=[1, 2], options={"reset_mask": np.array([True, False])})
    with pytest.raises(GrindingError, match="no finite numbers"):
        env.step(bad)
    stepped = env.step(good)
    assert_same(stepped, twin.step(good))
    assert stepped[3].tolist() == [False, True]
