from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from agents.commands.dataset import PLACE, make_dataset
from agents.video import record, watch
from grind_env import evaluate
from grind_env.envs.task_gauges import GAUGE
from grind_env.errors import GrindError
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.nominal_model import on
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.rules import Fixed
from grind_env.process.process_interface import PROCESS
from grind_env.render.frames import TALL, render

PROBLEM, PLATES = find_problem("oracle6"), find_problem("power_limited")
SIMULATION = PROBLEM.simulation()
SEED = 2_000_003


def test_the_film_ends_with_the_totals_of_the_evaluation() -> None:
    simulation = PLATES.simulation()
    (*_, last) = watch(make_policy("adaptive_rule", simulation), PLATES, SEED, 1)
    result = run_seeds(make_policy("adaptive_rule", simulation), simulation, [SEED])
    assert last.cost == pytest.approx(result.cost[0])
    assert last.good_parts == pytest.approx(result.good[0])
    assert [block.speed for block in last.ground] == result.speeds[0].tolist()
    assert [block.executions for block in last.ground] == result.executions[0].tolist()


@pytest.mark.parametrize("executions", [0, 1, 2, 3])
def test_a_moving_block_loses_its_stock_evenly_and_shows_every_dress(executions: int) -> None:
    frames = 12
    views = list(watch(Fixed(4000.0, executions), PLATES, SEED, frames))
    assert len(views) == 1 + PLATES.simulation().task.blocks * frames
    # without a dress the spindle stalls in the eighth block
    for start in (1, 1 + 3 * frames):
        *moving, rest = views[start : start + frames]
        left = [view.part.left for view in moving]
        assert np.diff(left) == pytest.approx(-rest.part.stock / frames)
        assert sum(view.instant.dressing for view in moving) == executions
        assert {view.text for view in moving} == {rest.text}
        assert {view.number for view in moving} == {rest.number}
        assert {view.wheel for view in moving} == {views[start - 1].wheel}
        assert rest.instant is None and rest.part.left < min(left)


def test_a_policy_filmed_or_recorded_on_another_machine_sees_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, seen = on(PLATES, "meter:7"), []

    class Looker(Fixed):
        sees = "state"

        def act(self, observation, episodes):
            seen.append((self.simulation, episodes.wheels.shape[1]))
            return super().act(observation, episodes)

        def begin(self, simulation, episodes):
            self.simulation = simulation
            super().begin(simulation, episodes)

    judged = evaluate(Fixed(8000.0, 1), PLATES, episodes=2, first_seed=SEED, plant="meter:7").evaluation
    *_, last = watch(Looker(8000.0, 1), problem, SEED, 1)
    assert last.cost == pytest.approx(judged.cost[0])
    monkeypatch.setenv(PLACE, str(tmp_path))
    data = make_dataset(Looker(8000.0, 1), problem, range(SEED, SEED + 2)).iterate_episodes()
    earned = np.array([each.rewards.sum() for each in data])
    assert -PLATES.simulation().task.reference_cost * earned == pytest.approx(judged.cost)
    assert {(simulation.gauge, width) for simulation, width in seen} == {(GAUGE, OWN_FROM + len(PROCESS.own._fields))}
    assert problem.simulation().gauge != GAUGE


def test_the_animation_has_every_frame(tmp_path: Path) -> None:
    path = tmp_path / "two.gif"
    left, right = named_policy("constant", SIMULATION), named_policy("E21000D1", SIMULATION)
    size = record([left, right], PROBLEM, 0, path, 2)
    assert size == path.stat().st_size
    with Image.open(path) as film:
        assert (film.size, film.n_frames, film.info["loop"]) == (
            (2 * TALL[0], TALL[1]),
            1 + 2 * SIMULATION.task.blocks,
            0,
        )
        durations = []
        for k in range(film.n_frames):
            film.seek(k)
            durations.append(film.info["duration"])
        last = np.array(film.convert("RGB")).astype(int)
    assert durations == [100] * (2 * SIMULATION.task.blocks) + [3000]
    ends = [list(watch(policy, PROBLEM, 0, 2))[-1] for policy in (left, right)]
    drawn = np.hstack([render(view, TALL) for view in ends]).astype(int)
    assert np.abs(last - drawn).mean() < 2.0
    assert np.quantile(np.abs(last - drawn), 0.99) < 24


@pytest.mark.parametrize("name", ["reciprocation", "wide_plates"])
def test_an_episode_of_another_cycle_is_filmed(name: str) -> None:
    problem, plan, frames = find_problem(name), Fixed(6000.0, 1, 3), 3
    views = list(watch(plan, problem, SEED, frames))
    result = run_seeds(plan, problem.simulation(), [SEED])
    assert len(views) == 1 + frames * result.speeds.shape[1]
    assert views[-1].cost == pytest.approx(result.cost[0])
    assert views[-1].good_parts == pytest.approx(result.good[0])
    # between two frames at rest the stock falls and every dress is shown
    for k in range(1, min(len(views), 60), frames):
        *moving, rest = views[k : k + frames]
        left = [view.part.left for view in moving]
        assert left == sorted(left, reverse=True)
        assert sum(view.instant.dressing for view in moving) == rest.ground[-1].executions


def test_a_wrong_file_type_or_a_large_film_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.video.MOST_BYTES", 1000)
    policy = named_policy("E6000D0", SIMULATION)
    with pytest.raises(GrindError, match=r"film\.mp4: an animation is written as \.gif; name such a file"):
        record([policy], PROBLEM, 0, tmp_path / "film.mp4")
    with pytest.raises(GrindError, match=r"would have 0\.\d\d MB, more than 0\.001: ask for fewer pictures a block"):
        record([policy], PROBLEM, 0, tmp_path / "film.gif", 1)
    assert list(tmp_path.iterdir()) == []
