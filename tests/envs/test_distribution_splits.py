"""The extrapolation split against the tape of the same seed without it, and against the catalogue."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grind_env.belief.filter_quantities import CUT
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.distribution_splits import EVERY, SPLITS, Split
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.reset_options import Given, read_options
from grind_env.envs.task_names import task_names
from grind_env.envs.tasks import load_task
from grind_env.envs.tasks.unseen_entries import other_materials, other_wheels
from tests.envs.harness import actions, assert_same, every_id, native, sync

BEYOND = SPLITS["extrapolation"]
NOISES = [name for name in TapeRow._fields if name.endswith("_noise")]
COUNT = 200


def tapes(simulation: BlockSimulation, split: Split, context: Any = None) -> TapeRow:
    """Return the tapes of `COUNT` episodes, each column of shape (COUNT, blocks)."""
    given = replace(read_options(simulation.task, {"context": context}, Given()), split=split)
    drawn = simulation.start([np.random.default_rng(i) for i in range(COUNT)], [given] * COUNT).tape
    return TapeRow(*np.moveaxis(drawn, 2, 0))


def test_extrapolation_scales_the_draws_of_the_same_seed() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    plain, beyond = tapes(simulation, SPLITS[EVERY]), tapes(simulation, BEYOND)
    for name in ("kind", "new_lot", "part_ra", "due"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(beyond, name))
    for name in NOISES:
        np.testing.assert_allclose(getattr(beyond, name), 3.0 * getattr(plain, name))
    np.testing.assert_allclose(beyond.stock, 1.5 * plain.stock, atol=0.002)
    np.testing.assert_allclose(beyond.gauged - beyond.stock, 3.0 * (plain.gauged - plain.stock), atol=1e-12)


def test_wear_and_pressure_lie_beyond_the_range_of_the_task_and_other_factors_within() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    spread = simulation.task.spread
    rows = tapes(simulation, replace(BEYOND, foreign=False))
    wheel = tapes(simulation, replace(BEYOND, foreign=False), {"kA": 1.0}).kA
    for logs, sigma in (
        (np.log(wheel), spread.wheel_growth),
        (np.log(rows.kA / wheel), spread.lot_growth),
        (np.log(rows.pm), spread.lot_pressure),
    ):
        far = np.abs(logs) / sigma
        assert far.min() > CUT and far.max() == pytest.approx(1.5 * CUT)
        assert (logs > 0.0).any() and (logs < 0.0).any()
    for name, sigma in (("hf", spread.convection), ("fc", spread.fracture_force), ("Gref", spread.g_ratio)):
        assert np.abs(np.log(getattr(rows, name))).max() <= CUT * sigma * (1.0 + 1e-12)


def test_every_extrapolation_episode_has_an_unseen_wheel_and_material() -> None:
    task = load_task("job_shop")
    simulation = BlockSimulation(task)
    near, far = tapes(simulation, replace(BEYOND, foreign=False)), tapes(simulation, BEYOND)
    # all kinds of an episode have one material
    assert (far.material == far.material[:, :1]).all()
    names = {task.materials[int(number)] for number in np.unique(far.material)}
    assert names == set(other_materials(task)) == {"aisi_1045", "case_hardened_16mncr5", "grey_cast_iron"}
    assert not names & {kind.material for kind in task.kinds}
    # the wheels of the catalogue, each with its parameters in the task
    own, found = task.parameters(task.kinds[0]), []
    for name in ("a46h", "a46j", "a80k", "a120k", "sg60j"):
        p = replace(task, setup=replace(task.setup, wheel=name)).parameters(task.kinds[0])
        found.append([p.kA / own.kA, p.fc / own.fc, p.Gref / own.Gref, p.RaRef / own.RaRef])
    np.testing.assert_allclose(sorted(found), sorted(other_wheels(task)))
    drawn = np.stack([getattr(far, name) / getattr(near, name) for name in ("kA", "fc", "Gref", "ra_scale")], axis=-1)
    met = np.unique(np.round(drawn[:, 0], 9), axis=0)
    np.testing.assert_allclose(met, np.unique(np.round(found, 9), axis=0), rtol=1e-8)
    assert np.ptp(drawn, axis=1).max() < 1e-9


def test_a_context_fixes_factors_in_the_extrapolation_split() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    context = {"material": "inconel_718", "stock": 0.8, "noise": 0.5, "wheel_kA": 2.0, "kA": 3.0, "pm": 1.0, "fc": 1.2}
    plain, rows = (tapes(simulation, split, context) for split in (SPLITS[EVERY], BEYOND))
    for name in ("material", "stock", "gauged", "kA", "spare_kA", "pm", "fc", *NOISES):
        np.testing.assert_array_equal(getattr(plain, name), getattr(rows, name))


def test_a_catalogue_without_unseen_entries_keeps_wheel_and_material() -> None:
    task = load_task("power_limited")
    own = replace(
        task.catalogue,
        materials={name: task.catalogue.materials[name] for name in ("aisi_52100", "inconel_718", "ti_6al_4v")},
        wheels={"a60j": task.catalogue.wheels["a60j"], "b126": task.catalogue.wheels["b126"]},
    )
    alone = replace(task, catalogue=own)
    assert (other_materials(alone), other_wheels(alone)) == ([], [])
    simulation = BlockSimulation(alone)
    near, far = tapes(simulation, replace(BEYOND, foreign=False)), tapes(simulation, BEYOND)
    for name in TapeRow._fields:
        np.testing.assert_array_equal(getattr(near, name), getattr(far, name))


@pytest.mark.parametrize("name", task_names())
def test_every_task_has_unseen_materials_and_wheels(name: str) -> None:
    task = load_task(name)
    assert len(other_materials(task)) >= 3 and len(other_wheels(task)) >= 1


@pytest.mark.parametrize("env_id", every_id())
def test_the_split_is_an_option_of_reset_in_every_environment_single_and_vector(env_id: str) -> None:
    native_env, beside = native(env_id, 2), sync(env_id, 2)
    options = {"split": "extrapolation"}
    begun = native_env.reset(seed=1, options=dict(options))
    assert_same(begun, beside.reset(seed=1, options=dict(options)))
    for action in actions(3, 2):
        assert_same(native_env.step(action), beside.step(action))
    assert [each.split for each in native_env.unwrapped.given] == [BEYOND] * 2
