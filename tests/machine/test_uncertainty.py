"""Uncertainty of a machine: read from catalogue files and sampled."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grind_env import examples
from grind_env.errors import GrindError
from grind_env.machine.job import Job, JobError
from grind_env.machine.job.drawn_machines import USUAL_SPREADS, uncertainty_of, usual_uncertainty
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.job_writer import job_text
from grind_env.machine.job.uncertainty import Uncertainty
from tests.machine.harness import drawn_machines

PLATE = examples.path("plate_g82.nc").with_suffix(".toml")
TABLE = """
[uncertainty]
source = "calibrated from log.csv"
names = ["material.ploughing_pressure", "wheel.roughness"]
spread = [0.2, 0.1]
correlation = [[1, 0.8], [0.8, 1]]
residual = 0.04
drift = 0.01
"""
FITTED = '[material.aisi_52100]\nbase = "aisi_52100"\nploughing_pressure = 0.7\n' + TABLE


def job_with(folder: Path, fitted: str, *, material: str = "aisi_52100") -> Path:
    """Write the job of the plate with a catalogue file and return its path."""
    (folder / "fitted.toml").write_text(fitted)
    job = folder / "plate.toml"
    text = PLATE.read_text(encoding="utf-8").replace('"aisi_52100"', f'"{material}"')
    job.write_text(f'{text}\n[catalogue]\nfiles = ["fitted.toml"]\n')
    return job


def test_a_job_reads_the_uncertainty_of_a_calibrated_file(tmp_path: Path) -> None:
    job = load_job(job_with(tmp_path, FITTED))
    assert job.uncertainty == Uncertainty(
        names=("material.ploughing_pressure", "wheel.roughness"),
        spread=(0.2, 0.1),
        correlation=((1, 0.8), (0.8, 1)),
        residual=0.04,
        drift=0.01,
        source="calibrated from log.csv",
    )
    assert job.part.material.ploughing_pressure == 0.7


def test_a_job_without_calibration_has_catalogue_values(tmp_path: Path) -> None:
    job = load_job(job_with(tmp_path, FITTED), calibrated=False)
    assert job.uncertainty is None and job.part.material == load_job(PLATE).part.material


def test_a_calibration_of_another_material_gives_no_uncertainty(tmp_path: Path) -> None:
    assert load_job(job_with(tmp_path, FITTED, material="aisi_1045")).uncertainty is None


def test_a_job_file_preserves_the_uncertainty(tmp_path: Path) -> None:
    job = load_job(job_with(tmp_path, FITTED))
    path = tmp_path / "again.toml"
    path.write_text(job_text(job))
    assert load_job(path) == job


NAMES = '["material.ploughing_pressure", "wheel.roughness"]'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('ploughing_pressure", ', 'plouhging_pressure", ', "there is no number 'material.plouhging_pressure'.*did you"),
        ("wheel.roughness", "wheel.abrasive", "there is no number"),
        ("wheel.roughness", "material.ploughing_pressure", "named twice"),
        ("[0.2, 0.1]", "[0.2]", "it has 1 numbers"),
        ("[0.2, 0.1]", "[0.2, -0.1]", "uncertainty.spread: '?-0.1'? must be a number from 0 to 3"),
        (
            "[0.2, 0.1]",
            f"[0.2, {10**400}]",
            r"uncertainty.spread: '?1000.*401 characters.* must be a number from 0 to 3",
        ),
        ("0.8, 1]]", f"{10**400}, 1]]", "2 rows of 2 numbers"),
        ("0.04", "nan", "uncertainty.residual: '?nan'? must be a number from 0 to 3"),
        ("0.8, 1]]", "nan, 1]]", "2 rows of 2 numbers"),
        (NAMES, "[" + "'wheel.x'," * 50_000 + "]", "no number 'wheel.x'"),
        (NAMES, "[" + "'wheel.x'," * 10**6 + "]", "it has more than 1 MB"),
        ("0.04", '"much"', "uncertainty.residual: 'much' must be a number from 0 to 3"),
        ("[[1, 0.8], [0.8, 1]]", "[[1, 0.8]]", "2 rows of 2 numbers"),
        ("[[1, 0.8], [0.8, 1]]", "[[1, 0.8], [0.7, 1]]", "symmetric"),
        ("[[1, 0.8], [0.8, 1]]", "[[1, 1.8], [1.8, 1]]", "eigenvalue below 0"),
        ("residual", "residuum", "there is no such key"),
        ("[0.2, 0.1]", "0.2", "uncertainty.spread: it must be a list"),
    ],
)
def test_errors_in_the_uncertainty_table_name_the_file(tmp_path: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(JobError, match=f"fitted.toml.*{told}"):
        load_job(job_with(tmp_path, FITTED.replace(old, new)))


def test_an_uncertainty_that_is_no_table_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(GrindError, match="uncertainty: found 3 where a table"):
        load_job(job_with(tmp_path, "uncertainty = 3"))


def test_drawn_machines_scatter_by_the_spreads_and_the_correlation(tmp_path: Path) -> None:
    """With 2000 machines, a standard deviation is known to about 5 %."""
    job = load_job(job_with(tmp_path, FITTED.replace("residual = 0.04", "residual = 0")))
    drawn = drawn_machines(job, uncertainty_of(job), 3, 2000)
    logs = np.log([[each.part.material.ploughing_pressure, each.setup.wheel.roughness] for each in drawn])
    assert logs.mean(axis=0) == pytest.approx(np.log([0.7, job.setup.wheel.roughness]), abs=0.015)
    assert logs.std(axis=0) == pytest.approx([0.2, 0.1], rel=0.05)
    assert np.corrcoef(logs.T)[0, 1] == pytest.approx(0.8, abs=0.03)
    assert drawn[:3] == drawn_machines(job, uncertainty_of(job), 3, 3) != drawn_machines(job, uncertainty_of(job), 4, 3)


def test_the_residual_scales_all_forces_alike() -> None:
    job = load_job(PLATE)
    only = Uncertainty(names=(), spread=(), correlation=(), residual=0.1)
    drawn = drawn_machines(job, only, 1, 500)
    fields = job.parameters._fields
    nominal = np.where(np.array(job.parameters) == 0.0, 1.0, job.parameters)
    factors = np.array([np.array(each.parameters) / nominal for each in drawn])
    pressure, flats = fields.index("pm"), [fields.index(name) for name in ("pa", "pb")]
    factors[:, flats] *= factors[:, [pressure]]  # a stroke uses only their product
    factors[:, pressure] = 1.0
    force = [fields.index(name) for name in ("u_ch", "kp", "pa", "pb")]
    assert np.ptp(factors[:, force], axis=1) == pytest.approx(0.0, abs=1e-12)
    assert np.log(factors[:, force[0]]).std() == pytest.approx(0.1, rel=0.1)
    others = [k for k in range(len(fields)) if k not in force and np.array(job.parameters)[k] != 0.0]
    assert (factors[:, others] == 1.0).all()


def test_draws_beyond_a_legal_range_are_clipped_to_its_end() -> None:
    job = load_job(PLATE)
    wide = Uncertainty(names=("wheel.dressed_wear_flat",), spread=(3.0,), correlation=((1.0,),))
    assert max(each.setup.wheel.dressed_wear_flat for each in drawn_machines(job, wide, 1, 100)) == 0.1
    low = replace(job, setup=replace(job.setup, wheel=replace(job.setup.wheel, wear_flat_limit=0.05)))
    most = max(each.setup.wheel.dressed_wear_flat for each in drawn_machines(low, wide, 1, 100))
    assert most == pytest.approx(0.99 * 0.05)  # the limit must be above it


def test_drawn_numbers_that_contradict_each_other_are_rejected() -> None:
    both = ("wheel.dressed_wear_flat", "wheel.wear_flat_limit")
    wide = Uncertainty(names=both, spread=(3.0, 3.0), correlation=((1.0, 0.0), (0.0, 1.0)))
    with pytest.raises(
        GrindError, match=r"uncertainty: some of the machines .* must be below wear_flat_limit.*smaller"
    ):
        drawn_machines(load_job(PLATE), wide, 1, 100)


def test_a_job_without_calibration_has_the_usual_uncertainty() -> None:
    job = load_job(PLATE)
    usual = uncertainty_of(job)
    assert usual == usual_uncertainty(job) and usual.source == ""
    assert usual.names == tuple(USUAL_SPREADS) and usual.spread[1] == math.log(1.5)
    soft = replace(job, part=replace(job.part, material=replace(job.part.material, loading_rate=0.0)))
    assert "material.loading_rate" not in usual_uncertainty(soft).names


def test_stations_of_the_same_material_share_the_drawn_material(tmp_path: Path) -> None:
    text = PLATE.read_text(encoding="utf-8")
    path = tmp_path / "two.toml"
    path.write_text(f"{text}\n[[stations]]\nstart = 0\n[[stations]]\nstart = 500\nmaterial = 'aisi_1045'\n")
    job = load_job(path)
    machine: Job = drawn_machines(job, uncertainty_of(job), 1, 1)[0]
    first, second = (each.part.material for each in machine.stations)
    assert first == machine.part.material != job.part.material
    assert second == job.stations[1].part.material
