"""The C reference gives the results of the kernel, bit by bit, on random machines."""

from pathlib import Path

import numpy as np
import pytest

from grind_env.process.process_interface import PROCESS
from tests.batches import TALLY, as_table
from tests.speed.c_reference import LANES, Loop, compiled, compiler
from tests.speed.kernel import cycles, plunges

MACHINES = 300


def machines(seed: int) -> tuple[np.ndarray, ...]:
    """Return random cycles, parameters, wheels and parts: some dress first, some stall, some have no depth."""
    rng = np.random.default_rng(seed)
    table, parameters, wheels, parts = cycles(MACHINES, seed)

    def sometimes(share: float) -> np.ndarray:
        return rng.random(MACHINES) < share

    for record in (parameters, wheels):
        for name in record.dtype.names or ():
            record[name] *= rng.uniform(0.7, 1.4, MACHINES)
    parameters["power"] *= np.where(sometimes(0.1), 0.05, 1.0)
    parameters["vs_set"] = np.where(sometimes(0.5), rng.uniform(15.0, 60.0, MACHINES), 0.0)
    wheels["lam"], wheels["V"] = rng.uniform(0.0, 0.5, MACHINES), rng.uniform(0.0, 200.0, MACHINES)
    wheels["W"] = rng.uniform(0.0, 0.02, MACHINES)
    for mode in PROCESS.own._fields:
        wheels[mode] = rng.uniform(0.0, 3.0, MACHINES)
    wheels["wd"] = rng.uniform(0.0, 0.3, MACHINES)
    table["pre_dress"], table["surface"] = sometimes(0.3), rng.uniform(0.0, 0.05, MACHINES)
    table["first_seconds"], table["set_out"] = rng.uniform(0.5, 9.0, (2, MACHINES))
    table["primary_pick"] = rng.choice([0.005, 0.01, 0.03], MACHINES)
    table["secondary_pick"] = rng.choice([0.0, 0.005, 0.02], MACHINES)
    table["depth"] *= np.where(sometimes(0.1), 0.0, 1.0)
    table["finish"] += rng.uniform(0.0, 0.1, MACHINES)
    parts["Z"] = parts["S"] = np.where(sometimes(0.5), rng.uniform(0.0, 0.1, MACHINES), 0.0)
    return table, parameters, wheels, parts


def final_bits(loop: Loop, tables: tuple[np.ndarray, ...]) -> list[np.ndarray]:
    """Return the bits of wheels, parts and tallies after a loop."""
    tallies = np.zeros(MACHINES, TALLY)
    copies = [each.copy() for each in tables]
    loop(*map(as_table, (*copies, tallies)))
    assert tallies["strokes"].sum() > 5 * MACHINES
    return [as_table(each).view(np.int64) for each in (*copies[2:], tallies)]


@pytest.mark.skipif(compiler() is None, reason="no gcc, so that the C reference is not compared with the kernel")
@pytest.mark.parametrize("lanes", LANES)
def test_c_and_kernel_end_with_the_same_bits(lanes: int, tmp_path: Path) -> None:
    reference = compiled(tmp_path, lanes)
    for seed in range(5):
        tables = machines(seed)
        assert all(map(np.array_equal, final_bits(plunges, tables), final_bits(reference, tables)))


def test_the_random_machines_vary_in_every_tally_and_some_stall() -> None:
    tables = machines(0)
    tallies = np.zeros(MACHINES, TALLY)
    table = [each.copy() for each in tables]
    plunges(*map(as_table, (*table, tallies)))
    for name in tallies.dtype.names or ():
        assert np.isfinite(tallies[name]).all()
        assert len(np.unique(tallies[name])) > 1, name
    assert (tallies["peak_torque"] >= 1.0).any()
    assert (tallies["peak_torque"] < 1.0).any()
