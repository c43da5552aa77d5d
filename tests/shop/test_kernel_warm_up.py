"""`grind warm-up` compiles every kernel that later commands load."""

import os
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest

from grind_env import examples
from grind_env.errors import GrindError
from grind_env.machine.job.job_file import load_job
from grind_env.optional_libraries import MissingExtra
from grind_env.process.force_correction import EXPONENTS
from grind_env.shop import kernel_warm_up as warm_up
from tests.command import Grind
from tests.shop.programs import EXAMPLES, JOB

UNRELATED = "correlation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
SMALL = (
    "from grind_env.process.catalogue import load_catalogue; from grind_env.validation import Rig; "
    "use = lambda: Rig(load_catalogue()).fresh().grind(); "
)


def test_warm_up_covers_every_environment_id_and_example() -> None:
    names = set(warm_up.uses())
    assert {name for name in gym.registry if name.startswith("grind/")} < names
    assert {f"grind run {name}" for name in examples.names()} < names
    assert any(name.startswith("grind optimise ") for name in names)


def test_warm_up_covers_calibrated_jobs(tmp_path: Path) -> None:
    written = "".join(f"material.{each}\n" for each in EXPONENTS).split()
    job = tmp_path / "job.toml"
    job.write_text(f"{JOB}\n[catalogue.uncertainty]\nnames = {written}\nspread = [0.1, 0.1, 0.1]\n{UNRELATED}\n")
    plain, warmed = load_job(EXAMPLES / "plate_g82.toml"), warm_up.calibrated(load_job(EXAMPLES / "plate_g82.toml"))
    assert load_job(job).process == warmed.process != plain.process
    assert {f"{name}, calibrated" for name in warm_up.uses()} & set(warm_up.uses()) == {
        f"grind {command} {examples.names()[0]}, calibrated" for command in ("run", "optimise")
    }


@pytest.mark.nightly
def test_warmed_up_code_runs_without_the_compiler(tmp_path: Path) -> None:
    def run(code: str) -> str:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "-c", code]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    code = (
        "from grind_env.shop import kernel_warm_up as w; from grind_env.cli import main; "
        "w.uses = lambda: {'a stroke': use}; main(['warm-up'])"
    )
    first, last = run(SMALL + code).splitlines()
    made = sorted((tmp_path / "kernels").glob("*.nbc"))
    assert made and first.startswith("a stroke ") and first.endswith(f" {len(made)} new")
    assert last == f"{len(made)} kernels in {tmp_path / 'kernels'}"
    no_compiler = "import numba.core.compiler as compiler; compiler.CompilerBase.__init__ = None; "
    run(no_compiler + SMALL + "use()")
    assert sorted((tmp_path / "kernels").glob("*.nbc")) == made


def test_warm_up_reports_a_missing_extra(grind: Grind, monkeypatch: pytest.MonkeyPatch) -> None:
    def search() -> None:
        raise MissingExtra("the search needs SciPy")

    monkeypatch.setattr(warm_up, "uses", lambda: {"grind optimise": search})
    monkeypatch.setattr(warm_up, "kernels", lambda: 3)
    status, out, _ = grind("warm-up")
    assert (status, out.splitlines()[0]) == (0, f"{'grind optimise':40} the search needs SciPy")


def test_warm_up_fails_if_the_cache_stays_empty(grind: Grind, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(warm_up, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(warm_up, "uses", lambda: {"nothing": lambda: None})
    status, _, err = grind("warm-up")
    assert status == 2 and str(tmp_path) in err and "NUMBA_CACHE_DIR" in err
    with pytest.raises(GrindError):
        list(warm_up.warm_up({}))
