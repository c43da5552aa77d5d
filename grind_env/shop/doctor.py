"""Check an installation: versions, missing extras with their install commands, and speed."""

import os
import platform
import re
import shlex
import tempfile
import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grind_env.envs.threaded_step import step_shared
from grind_env.kernel.cache import cache_folder
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.policies.evaluation import episode_seeds, start_episodes
from grind_env.policies.problem_lookup import find_problem
from grind_env.task_version import TASK_VERSION

PACKAGE = "grind_env"
#: purpose of each extra of the package
EXTRAS = {
    "plot": "figures, `--plot`",
    "render": "pictures of environments, videos",
    "data": ".parquet files, tables for pandas",
    "shop": "`grind optimise`, `sweep`, `calibrate`, `report`",
    "train": "`grind train`",
    "sb3": "agents of Stable-Baselines3",
}
REQUIREMENT = re.compile(r"(([\w.-]+)[^;]*)(?:;.*extra == ['\"](\w+)['\"])?")
#: number of machines side by side, and of blocks that each grinds, in the measurement of the time of a stroke
MACHINES, BLOCKS = 4096, 8
STROKES = Tally._fields.index("strokes")


class Finding(NamedTuple):
    """Result of one check of the installation."""

    what: str  #: name of the check
    found: str  #: result
    remedy: str = ""  #: what to do; empty where all is well


def findings() -> list[Finding]:
    """Return the results of all checks, in the order of the output."""
    return [*_installed(), _kernels(cache_folder()), *_speeds(), *map(_extra, EXTRAS)]


def _installed() -> list[Finding]:
    libraries = ", ".join(f"{name} {version(name)}" for name in ("gymnasium", "numba", "numpy"))
    return [
        Finding(PACKAGE, f"{version(PACKAGE)}, tasks of version {TASK_VERSION}, in {Path(__file__).parents[1]}"),
        Finding("Python", f"{platform.python_version()}, {platform.platform(terse=True)}, {_cores()} cores"),
        Finding("libraries", libraries),
    ]


def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _kernels(folder: Path) -> Finding:
    sizes = [path.stat().st_size for path in folder.glob("*.nbc")]
    found = f"{len(sizes)}, {sum(sizes) / 1e6:.0f} MB, in {folder}"
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return Finding(
            "kernels",
            f"{found}, which cannot be written ({error.strerror})",
            "set NUMBA_CACHE_DIR to a folder that can",
        )
    return Finding("kernels", found, "" if sizes else "`grind warm-up` compiles them ahead")


def _speeds() -> list[Finding]:
    threads = (1,) if _cores() == 1 else (1, 2)
    said = ", ".join(f"{1e9 * _seconds_a_stroke(each):.0f} ns on {each} core{'s' * (each > 1)}" for each in threads)
    return [Finding("a stroke", f"{said}, of {MACHINES} machines side by side")]


def _seconds_a_stroke(threads: int) -> float:
    """Return the time of a stroke, s, of machines that grind PowerLimited with one E and D; without the first block."""
    simulation = find_problem("power_limited").simulation()
    episodes = start_episodes(simulation, episode_seeds("training", MACHINES))
    choice = np.full(MACHINES, 7000.0), np.ones(MACHINES)
    everyone, strokes, seconds = np.arange(MACHINES), 0.0, 0.0
    strokes_of = simulation.step(episodes.pick(everyone), *choice)[1][:, STROKES].sum()
    for _ in range(BLOCKS):
        began = time.perf_counter()
        step_shared(simulation, episodes, choice, everyone, threads)
        seconds, strokes = seconds + time.perf_counter() - began, strokes + strokes_of
    return seconds / strokes


def _extra(name: str) -> Finding:
    asked = _required(requires(PACKAGE) or (), name)
    found = [(each, _version(each)) for each in asked]
    missing = [each for each, number in found if number is None]
    said = ", ".join(each if number is None else f"{each} {number}" for each, number in found)
    if not missing:
        return Finding(name, said)
    remedy = f"pip install {' '.join(shlex.quote(asked[each]) for each in missing)}"
    return Finding(name, f"{', '.join(missing)} missing, for {EXTRAS[name]}", remedy)


def _required(requirements: Sequence[str], extra: str) -> dict[str, str]:
    """Return the libraries of an extra with versions, without those of an included extra."""
    matched = [REQUIREMENT.match(each) for each in requirements]
    return {
        each[2]: each[1].strip() for each in matched if each is not None and each[3] == extra and each[2] != PACKAGE
    }


def _version(library: str) -> str | None:
    try:
        return version(library)
    except PackageNotFoundError:
        return None
