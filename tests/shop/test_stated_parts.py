"""Jobs with stated parts: searches and sweeps grind exactly these parts."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read, read_file
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.repeated_program import repeated
from grind_env.envs.tasks import load_task
from grind_env.machine.grind import grind as ground
from grind_env.machine.job import Job, JobError, PartConditions
from grind_env.machine.job.job_file import load_job
from grind_env.machine.script.block_settings import D, E
from grind_env.shop.trials import trials_of
from tests.command import Grind
from tests.policies.optimum import exact_optimum
from tests.shop.programs import EXAMPLES, KNOWN, PLATE

JOB = load_job(EXAMPLES / "plate_g82.toml")
OTHER = replace(JOB.part, stock=0.9 * JOB.part.stock, roughness_limit=0.3, tolerance=8.0, scrap_cost=90.0)
PARTS = (
    PartConditions(factors={"kA": 2.0, "pm": 1.1}),
    PartConditions(part=OTHER, factors={"ra_scale": 1.2, "hf": 0.9}),
    PartConditions(stock=1.02 * JOB.part.stock, factors={"fc": 0.9, "Gref": 1.3}),
)


@pytest.fixture
def oracle6(grind: Grind, tmp_path: Path) -> Path:
    """Return the program that `grind play` writes for the task oracle6, with its job beside it."""
    program = tmp_path / "oracle6.nc"
    assert grind("play", "--task", "oracle6", "--policy", "E9000D1", "--output", program)[0] == 0
    job = program.with_suffix(".toml")
    job.write_text(job.read_text(encoding="utf-8") + KNOWN)
    return program


def test_optimal_settings_of_oracle6_cost_the_same_in_trials_and_in_the_task(oracle6: Path) -> None:
    optimum = exact_optimum(BlockSimulation(load_task("oracle6")))
    trials = trials_of(read_file(oracle6), load_job(oracle6.with_suffix(".toml")), 1, [(0,)])
    settings = trials.own[None].copy()
    settings[0, :, E], settings[0, :, D] = optimum.speeds, optimum.executions
    assert 6.0 * trials.measure(settings).cost[0, 0] == pytest.approx(optimum.cost, rel=1e-4)


@pytest.mark.parametrize("longer", [0.0, 2.0], ids=["replayed", "executed by the control"])
def test_trials_of_stated_parts_match_a_run_of_the_batch(longer: float) -> None:
    last = replace(PARTS[-1], part=replace(JOB.part, length=JOB.part.length - longer))
    job = replace(JOB, parts=(*PARTS[:-1], last))
    programs = repeated(read(PLATE), len(PARTS))
    simulation = JobSimulation(programs, job, 0.0)
    assert simulation.compiled == (longer == 0.0)
    trials = trials_of(read(PLATE), job, len(PARTS), [(0,), (1,)])
    assert trials.seeds == ((0,),)
    found = trials.measure(trials.own[None], handover=False)
    parts = ground(programs, job).parts
    assert found.cost[0, 0] == pytest.approx(parts["total_cost"].mean(), rel=1e-9)
    assert found.seconds[0, 0] == pytest.approx(parts["seconds"].mean(), rel=1e-9)
    assert 1.0 - found.scrap[0, 0] == pytest.approx(parts["survival"].mean(), rel=1e-9)
    # the ratio is the 95 % quantile of Ra over each part's own limit
    limits = np.array([job.of_part(number).limits.roughness for number in parts["part"]])
    assert found.ratios[0, 2] == pytest.approx(np.quantile(parts["Ra"] / limits, 0.95), rel=1e-9)


def job_with(*parts: PartConditions) -> Job:
    return replace(JOB, parts=parts)


@pytest.mark.parametrize(
    ("job", "told"),
    [
        (job_with(*PARTS[:2], PartConditions(factors={"wi": 2.0})), "part 3 has a factor on wi"),
        (
            job_with(*PARTS[:2], PartConditions(factors={"pm": 1.1}, new_wheel_factors={"kA": 1.2})),
            "part 3 has another pm with a new wheel",
        ),
    ],
)
def test_parts_that_cannot_be_replayed_are_refused(job: Job, told: str) -> None:
    with pytest.raises(JobError, match=told):
        trials_of(read(PLATE), job, 3, [(0,)])


def test_more_runs_than_stated_parts_are_refused_with_the_remedy() -> None:
    with pytest.raises(JobError, match=r"run 50 times, grinds more parts than the 3 .* choose --parts 3 or fewer"):
        trials_of(read(PLATE), job_with(*PARTS[:3]), 50, [(0,)])


def test_a_sweep_grinds_the_stated_parts(oracle6: Path, grind: Grind) -> None:
    status, out, _ = grind("sweep", oracle6, "--parts", 1, "--E", "9000..21000", "--json")
    found = json.loads(out)
    wanted = json.loads(grind("run", oracle6, "--json")[1])["parts"]
    assert (status, found["lots"]) == (0, 1)
    assert found["own"]["seconds"] == pytest.approx(np.mean([part["seconds"] for part in wanted]), rel=1e-9)
