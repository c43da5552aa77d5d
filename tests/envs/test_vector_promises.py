"""Vector environments: refused options, failed steps, threads and the last block."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.array_types import Array
from grind_env.envs.episode_state import EpisodeOver
from grind_env.envs.job.loading import EXAMPLE
from grind_env.envs.reset_options import ContextError
from grind_env.envs.tasks import TaskError
from grind_env.envs.transition import TOGETHER
from grind_env.machine.part.part import PartRun
from grind_env.machine.program_run import GrindingError
from tests.envs.harness import MODES, assert_same, every_id, native, sampled

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
def test_a_bad_list_of_options_changes_no_environment(options: dict[str, Any]) -> None:
    env, twin = native(ID, 2, "Disabled"), native(ID, 2, "Disabled")
    for each in (env, twin):
        each.reset(seed=1)
    for mask in (True, False):
        with pytest.raises(ContextError):
            env.reset(seed=5, options=options | {"reset_mask": np.array([True, mask])})
    assert_same(env.step(np.zeros((2, 2), np.float32)), twin.step(np.zeros((2, 2), np.float32)))
    assert_same(env.reset(), twin.reset())


def test_a_refused_option_does_not_count_as_a_reset() -> None:
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


#: groove before the plate: this program has no script, and the control executes it
GROOVE = "G71 G94 G90 G18\nG00 X1. Z0\nG77 X-1. Z-50. I.7 K40. D0 F6.\nM00\n"


def grooved(folder: Path) -> str:
    """Write the plate program with a groove before it."""
    program = folder / "grooved.nc"
    program.write_text(EXAMPLE.read_text().replace("N10 ", GROOVE + "N10 ", 1))
    program.with_suffix(".toml").write_text(EXAMPLE.with_suffix(".toml").read_text())
    return str(program)


@pytest.fixture
def hard_job(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """Return a job with a groove and a plate; at the lowest E only the nominal lot can be ground."""
    grind = PartRun.grind

    def picky(part: PartRun, rows: Array, *way: Any) -> Any:
        if rows["E"][0] < 3300.0 and part.conditions.factors:
            raise GrindingError("no finite numbers")
        return grind(part, rows, *way)

    monkeypatch.setattr(PartRun, "grind", picky)
    return {"spread": 2.0, "program": grooved(tmp_path)}


def test_a_failed_step_leaves_the_job_unchanged(hard_job: dict[str, Any]) -> None:
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
def test_a_failed_step_of_one_job_leaves_all_jobs_unchanged(hard_job: dict[str, Any], mode: str) -> None:
    env, twin = (native(ID, 3, mode, **hard_job) for _ in range(2))
    good = np.array([SPARES] * 3)
    # the middle one fails; in every mode another one ends, or has ended and restarts
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
    if mode == "Disabled":  # environments outside the mask keep their observation
        mask = {"reset_mask": np.array([False, False, True])}
        assert_same(env.reset(options=dict(mask)), twin.reset(options=dict(mask)))
    for _ in range(1 if mode == "Disabled" else 3):
        assert_same(env.step(good), twin.step(good))


def test_a_failed_step_does_not_count_towards_the_step_limit(hard_job: dict[str, Any]) -> None:
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


N = 11


@pytest.mark.bits
@pytest.mark.parametrize("env_id", every_id())
def test_the_number_of_threads_changes_no_bit(env_id: str) -> None:
    one, three = (native(env_id, N, MODES[every_id().index(env_id) % 2], threads=threads) for threads in (1, 3))
    assert_same(one.reset(seed=0), three.reset(seed=0))
    for number, batch in enumerate(sampled(env_id, 8, N)):
        if number == 4:  # from here on some episodes end, and with them some threads have nothing to do
            assert_same(*(each.reset(options={"reset_mask": np.arange(N) < 9}) for each in (one, three)))
        assert_same(one.step(batch), three.step(batch))
    for name in ("block", "wheels", "parts", "memory", "tape"):
        assert_same(getattr(one.episodes, name), getattr(three.episodes, name))


@pytest.mark.parametrize("n", [2, TOGETHER + 2])
def test_results_do_not_depend_on_threads_for_few_or_many_episodes(n: int) -> None:
    one, many = (native("grind/Oracle6-v0", n, "NextStep", threads=threads) for threads in (1, 5))
    assert_same(one.reset(seed=3), many.reset(seed=3))
    for batch in sampled("grind/Oracle6-v0", 14, n):
        assert_same(one.step(batch), many.step(batch))


def test_a_program_run_by_python_refuses_several_threads(tmp_path: Path) -> None:
    program = grooved(tmp_path)
    native("grind/Job-v0", 2, program=program, threads=1)
    with pytest.raises(TaskError, match="threads is 2, but Python runs this program"):
        native("grind/Job-v0", 2, program=program, threads=2)


IDS = ["PowerLimited", "WidePlates", "Reciprocation"]


def rolled_out(simulation, seed: int, n: int = 32, steps: int = 8) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    episodes = simulation.start([np.random.default_rng([seed, i]) for i in range(n)], full_tape=False)
    found = []
    for _ in range(steps):
        outcomes, _ = simulation.step(episodes, rng.uniform(5000.0, 25000.0, n), rng.integers(0, 2, n).astype(float))
        found += [outcomes, simulation.observe(episodes)]
    return found


@pytest.mark.parametrize("name", IDS)
def test_parallel_simulations_give_the_results_of_sequential_ones(name):
    simulation = gym.make(f"grind/{name}-v0").unwrapped.simulation
    alone = [rolled_out(simulation, seed) for seed in range(4)]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            beside = list(pool.map(lambda seed: rolled_out(simulation, seed), range(4)))
            for one, other in zip(alone, beside, strict=True):
                assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", [*IDS, "Job"])
def test_a_step_after_the_last_block_is_refused_and_changes_nothing(name):
    program = {"program": str(grind_env.examples.path("plate_g82.nc"))} if name == "Job" else {}
    simulation = gym.make(f"grind/{name}-v0", **program).unwrapped.simulation
    episodes = simulation.start([np.random.default_rng(i) for i in range(2)])
    choice = np.full(2, 12000.0), np.zeros(2)
    first = np.array([0])
    while not simulation.over(episodes)[0]:
        simulation.step(episodes, *choice, active=first)
    for active in (None, first):
        before = episodes.pick([0, 1]).arrays()
        with pytest.raises(EpisodeOver, match="episode 0 is over after"):
            simulation.step(episodes, *choice, active=active)
        assert all(np.array_equal(before[key], array, equal_nan=True) for key, array in episodes.arrays().items())
    simulation.step(episodes, *choice, active=np.array([1]))
