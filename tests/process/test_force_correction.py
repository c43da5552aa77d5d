"""Calibrated corrections of the forces: a factor, and exponents of depth, speed and volume."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from grind_env.control import read_file
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.repeated_program import repeated
from grind_env.envs.simulation import advance
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.grind import grind
from grind_env.machine.job import JobError, PartConditions
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.job_writer import job_text
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.plants import find_plants
from grind_env.process.force_correction import CORRECTED, exponents_of
from grind_env.process.process_interface import PROCESS
from grind_env.process.stroke_and_dress import dressed_wheel, grind_stroke, stroke_constants
from tests.machine.harness import drawn_machines

PLATE = "plate_g82"


def job_of(program, **material):
    # this table reaches E over the whole part
    return with_entries(
        load_job(EXAMPLES / f"{program}.toml"), {"material": material, "machine": {"acceleration": 2000.0}}
    )


def strokes(program, parts=2, **material):
    return grind(repeated(read_file(EXAMPLES / f"{program}.nc"), parts), job_of(program, **material)).strokes


def test_a_job_without_exponents_has_the_standard_process():
    assert job_of(PLATE).process is PROCESS
    corrected = job_of(PLATE, power_volume_exponent=0.1)
    assert corrected.process is CORRECTED
    assert with_entries(corrected, {"material": {"power_volume_exponent": 0.0}}).process is PROCESS


def test_the_power_factor_scales_chips_ploughing_and_flats():
    material = job_of(PLATE).part.material
    by_hand = {key: 1.2 * getattr(material, key) for key in ("chip_energy", "ploughing_pressure", "pressure_factor")}
    np.testing.assert_allclose(
        strokes(PLATE, power_factor=1.2)["power"], strokes(PLATE, **by_hand)["power"], rtol=1e-12
    )


def test_a_speed_exponent_acts_as_one_factor_per_block():
    """The plate is roughed at 15 and finished at 9 m/min; the factor by hand is that of roughing."""
    corrected, plain = (
        strokes(PLATE, 1, **each) for each in ({"power_speed_exponent": 0.3}, {"power_factor": (250.0 / 200.0) ** 0.3})
    )
    rough = plain["E"] == 15_000.0
    np.testing.assert_allclose(corrected["power"][rough], plain["power"][rough], rtol=1e-9)
    assert np.all(corrected["power"][~rough][2:] != plain["power"][~rough][2:])


@pytest.mark.parametrize("u", [0.0001, 0.004, 0.010, 0.3])
@pytest.mark.parametrize("V", [0.0, 300.0, 2000.0])
def test_a_corrected_stroke_equals_one_with_forces_scaled_by_a_power_law(u, V):
    job = job_of(PLATE)
    k = stroke_constants(job.parameters, 300.0, 200.0)
    wheel = dressed_wheel(300.0, 0.0, 0.1, 0.02, job.parameters)._replace(V=V, A=0.01)
    depth = min(max(u, 0.0005), 0.1)  # the power law ends at these depths
    factor = (depth / 0.010) ** 0.2 * (300.0 / 200.0) ** -0.3 * ((V + 10.0) / 310.0) ** 0.1
    by_hand = k._replace(u_ch=factor * k.u_ch, kp=factor * k.kp, pa=factor * k.pa, pb=factor * k.pb)
    surface = (0.0, 0.5, u, 20.0)
    _, _, found = CORRECTED.stroke(wheel, CORRECTED.own(0.0, 0.0, 0.0, 0.0, 0.2, -0.3, 0.1), *surface, k, 1.0)
    _, right = grind_stroke(wheel, *surface, by_hand)
    np.testing.assert_allclose(found, right, rtol=1e-12)


def test_a_job_file_preserves_factor_and_exponents(tmp_path):
    corrected = job_of(PLATE, power_depth_exponent=0.1, power_factor=1.1)
    (tmp_path / "job.toml").write_text(job_text(corrected), encoding="utf-8")
    again = load_job(tmp_path / "job.toml")
    assert again.own == corrected.own
    assert again == corrected


def test_a_copied_simulation_on_a_named_machine_keeps_the_exponents():
    programs, job = read_file(EXAMPLES / f"{PLATE}.nc"), job_of(PLATE, power_speed_exponent=0.3)
    here, there = (
        JobSimulation(programs, job, 0.0),
        copy.copy(JobSimulation(programs, job, 0.0, plants=find_plants("model"))),
    )
    found = [
        advance(each, each.start([np.random.default_rng(0)]), np.full(1, 9000.0), np.ones(1)) for each in (here, there)
    ]
    np.testing.assert_array_equal(*(outcome for outcome, _ in found))


def test_a_job_rejects_parts_with_different_exponents():
    plain = job_of(PLATE)
    other = job_of(PLATE, power_depth_exponent=0.1).part
    with pytest.raises(JobError, match="give both the same"):
        replace(plain, parts=(PartConditions(part=other),))


def test_machines_with_uncertain_exponents_share_the_corrected_process():
    job = load_job(EXAMPLES / "plate_g82.toml")
    names = ("material.power_depth_exponent", "machine.stiffness")
    spreads = Uncertainty(names=names, spread=(0.1, 0.2), correlation=((1.0, 0.0), (0.0, 1.0)))
    uncertain = replace(job, uncertainty=spreads)
    assert job.process is PROCESS and uncertain.process is CORRECTED and not any(exponents_of(uncertain.part.material))
    some = drawn_machines(uncertain, spreads, 1, 4)
    assert {each.process for each in some} == {CORRECTED} and len({each.own for each in some}) == 4
    assert replace(uncertain, uncertainty=None).process is PROCESS


def test_the_heat_factor_scales_temperature_burn_ratio_and_growth_only():
    plain, cooler = (strokes(PLATE, 1, heat_factor=each) for each in (1.0, 0.4))
    first = int(np.argmax(plain["power"] > 0.0))
    assert cooler["power"][first] == plain["power"][first] and plain["T"][first] > 10.0
    for name, stroke in (("T", first), ("burn_ratio", first), ("grown", first + 1)):
        np.testing.assert_allclose(cooler[name][stroke], 0.4 * plain[name][stroke], rtol=1e-12)
