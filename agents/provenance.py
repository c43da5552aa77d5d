"""Provenance of results: commit, versions and seeds."""

import platform
import shutil
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from grind_env.task_version import TASK_VERSION

ROOT = Path(__file__).parents[1]

TRAINING = ("stable_baselines3", "torch")  #: packages that only trainings need


def provenance(seeds: range, *, trains: bool = True) -> dict[str, str | int]:
    """Return versions, seeds and commit of results; versions of `TRAINING` packages only if `trains`."""
    packages = ("grind_env", "numpy", "numba", *TRAINING * trains)
    return {
        "task_version": TASK_VERSION,
        "seeds": shown_seeds(seeds),
        "commit": commit(),
        "python": platform.python_version(),
        **{package: installed(package) for package in packages},
    }


def shown_seeds(seeds: range) -> str:
    """Return the first and the last seed as text."""
    return f"{seeds.start}..{seeds.stop - 1}"


def installed(package: str) -> str:
    """Return the version of an installed package, or `none`."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


@cache  # the first written table makes the checkout dirty
def commit() -> str:
    """Return the commit of the checkout, with `-dirty` if it has changes; `none` outside git."""
    git = shutil.which("git")
    if git is None:
        return "none"
    command = [git, "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude", "*"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip() or "none"
