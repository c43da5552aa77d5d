"""Tape rows drawn block by block against full tapes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from grind_env.envs.noise_tape import AHEAD, TapeRow
from grind_env.envs.reset_options import Given, read_options
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_names import shipped_names
from grind_env.policies.problem_lookup import find_problem
from tests.envs.harness import assert_same

N = 6


def problem(name: str) -> Any:
    return find_problem(name).simulation()


def both(simulation: Simulation, given: list[Given]) -> tuple[Any, Any]:
    """Return the same episodes with full tapes and with two rows."""
    whole, two = ([np.random.default_rng(seed) for seed in range(N)] for _ in range(2))
    return simulation.start(whole, given), simulation.start(two, given, full_tape=False)


@pytest.mark.bits
@pytest.mark.parametrize("name", shipped_names())
def test_rows_drawn_block_by_block_equal_the_full_tape(name: str) -> None:
    simulation = problem(name)
    options: list[dict[str, Any]] = [{}, {"split": "inner"}, {"split": "extrapolation"}, {"context": "nominal"}]
    given = [read_options(simulation.task, options[i % 4], Given(), simulation.unfixable) for i in range(N)]
    kept, drawn = both(simulation, given)
    assert drawn.tape.shape[1] == min(AHEAD, simulation.task.blocks)
    rng, tape = np.random.default_rng(0), kept.tape.copy()
    for k in range(simulation.task.blocks):
        if simulation.over(kept).all():
            break
        assert_same(kept.coming(), drawn.coming())
        assert_same(simulation.observe(kept), simulation.observe(drawn))
        if k % 16 == 0:
            assert_same(simulation.with_full_tapes(drawn).tape, tape)
            # copies have the tapes of their originals
            branches = drawn.pick([2, 2])
            assert_same(simulation.with_full_tapes(branches).tape, tape[[2, 2]])
        choice = rng.uniform(*simulation.task.action.speed_ends, N), rng.integers(0, 2, N).astype(float)
        active = np.flatnonzero(~simulation.over(kept))
        for one, other in zip(
            simulation.step(kept, *choice, active=active), simulation.step(drawn, *choice, active=active), strict=True
        ):
            assert_same(one, other)
    assert_same(kept.wheels, drawn.wheels)
    assert_same(kept.memory, drawn.memory)


#: fields of a row that each spread changes
SPREADS = {
    "stock": ["stock", "gauged"],
    "gauge": ["gauged"],
    "lot_growth": ["kA", "spare_kA"],
    "wheel_growth": ["kA", "spare_kA"],
    "lot_pressure": ["pm"],
    "convection": ["hf"],
    "fracture_force": ["fc"],
    "g_ratio": ["Gref"],
    "wheel_roughness": ["ra_scale", "spare_ra_scale"],
    "part_roughness": ["ra_scale", "spare_ra_scale", "part_ra"],
    "measurement": [name for name in TapeRow._fields if name.endswith("_noise")],
}


@pytest.mark.parametrize("spread", SPREADS)
def test_a_spread_of_zero_changes_its_own_fields_only(spread: str) -> None:
    simulation = problem("CBN")
    task = simulation.task
    without = type(simulation)(replace(task, spread=replace(task.spread, **{spread: 0.0})))
    columns = [tape_columns(each) for each in (simulation, without)]
    for name in TapeRow._fields:
        same = np.array_equal(columns[0][name], columns[1][name])
        assert same == (name not in SPREADS[spread]), name


def tape_columns(simulation: Simulation) -> dict[str, NDArray[np.float64]]:
    tape = simulation.start([np.random.default_rng(seed) for seed in range(3)]).tape
    return dict(zip(TapeRow._fields, np.moveaxis(tape, 2, 0), strict=True))


def test_an_episode_takes_two_numbers_from_its_generator() -> None:
    for name in ("rush", "wide_plates"):
        rng, other = np.random.default_rng(3), np.random.default_rng(3)
        problem(name).start([rng])
        other.random(2)
        assert rng.random() == other.random()


def test_no_two_numbers_of_a_tape_are_drawn_from_the_same_word() -> None:
    # all these numbers have one standard deviation, so that two numbers from one random word would be equal
    columns = tape_columns(problem("power_limited"))
    noise = np.array([values for name, values in columns.items() if name.endswith("_noise")])
    stock = np.array([columns["gauged"] - columns["stock"]])
    numbers = np.concatenate([noise.ravel(), stock.ravel()])
    assert len(np.unique(numbers)) == numbers.size
