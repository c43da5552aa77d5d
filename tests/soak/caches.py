"""Compiled kernels in a folder that is damaged, full, only read, gone, or used by eight cold processes at once."""

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.kernel.test_cache import DAMAGES, RESULTS, Toy
from tests.soak.part import Part, Tried, clean
from tests.soak.surroundings import may_not_write

KERNELS = 2
COLD = 8
"""Processes that start at once."""
STARTED: list[Toy] = []
"""A toy whose kernels are on disk."""


def prepare() -> None:
    """Have kernels compiled that the cases begin with."""
    toy = Toy(Path(tempfile.mkdtemp(prefix="soak-kernels-")))
    assert toy.start().results == RESULTS
    STARTED.append(toy)


def attempt(seed: int) -> Tried:
    """Start kernels with the cache of a seed; a case that falls does so by an assertion."""
    rng = random.Random(seed)
    name, case = list(CASES.items())[seed % len(CASES)]
    with tempfile.TemporaryDirectory(prefix="soak-caches-") as folder:
        toy = Toy(Path(folder), KERNELS)
        case(toy, rng)
    return Tried("accepted", sums={name: 1})


def _again(toy: Toy) -> Path:
    """A copy of what is compiled; its folder."""
    shutil.copytree(STARTED[0].cache, toy.cache)
    return toy.files()[0].parent


def _damaged(toy: Toy, rng: random.Random) -> None:
    _again(toy)
    spoiled = [path for path in toy.files() if rng.random() < 0.7]
    for path in spoiled:
        content = path.read_bytes()
        flipped = bytearray(content)
        flipped[rng.randrange(len(flipped))] ^= 1 + rng.randrange(255)
        cut = content[: rng.randrange(len(content))]
        path.write_bytes(rng.choice((rng.choice(DAMAGES)(content), bytes(flipped), cut)))
    first, second = toy.start(), toy.start()
    assert first.results == second.results == RESULTS, first
    assert first.hits == KERNELS - len(spoiled) and len(first.lines) == len(spoiled), first
    assert second == (RESULTS, KERNELS, []), second


def _full(toy: Toy, rng: random.Random) -> None:
    warm = rng.random() < 0.5
    if warm:
        _again(toy)
    started = toy.start("full")
    assert started.results == RESULTS and started.hits == KERNELS * warm, started
    assert len(started.lines) == (not warm), started
    assert len(toy.files()) == KERNELS * warm, toy.files()


def _only_read(toy: Toy, rng: random.Random) -> None:
    warm = rng.random() < 0.5
    folder = _again(toy) if warm else toy.cache / "kernels"
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(0o555)
    place = {"NUMBA_CACHE_DIR": str(toy.cache)}
    command = [sys.executable, str(toy.script)]
    ended = subprocess.run(
        command, env={**clean(), **place}, preexec_fn=may_not_write, capture_output=True, text=True, check=False
    )
    folder.chmod(0o755)
    assert ended.returncode == 0 and ended.stdout.splitlines() == [RESULTS, str(KERNELS * warm)], ended
    assert len(ended.stderr.splitlines()) == (not warm), ended.stderr


def _no_folder(toy: Toy, rng: random.Random) -> None:
    toy.cache.touch()
    started = toy.start()
    assert started.results == RESULTS and len(started.lines) == 1, started


def _cold(toy: Toy, rng: random.Random) -> None:
    started = [toy.end(process) for process in [toy.begin() for _ in range(COLD)]]
    assert all(each.results == RESULTS and not each.lines for each in started), started
    assert sum(each.hits for each in started) == KERNELS * (COLD - 1), started
    assert len(toy.files()) == KERNELS, toy.files()


def _killed(toy: Toy, rng: random.Random) -> None:
    """Of several processes that compile, some are killed at any moment."""
    processes = [toy.begin() for _ in range(3)]
    for process in processes[:2]:
        time.sleep(rng.random())
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    assert toy.end(processes[2]).results == RESULTS
    assert toy.start() == (RESULTS, KERNELS, [])


CASES: dict[str, Callable[[Toy, random.Random], None]] = {
    "damaged": _damaged,
    "full": _full,
    "only read": _only_read,
    "no folder": _no_folder,
    "eight cold processes": _cold,
    "killed while they compile": _killed,
}

PART = Part(name="caches", attempt=attempt, prepare=prepare, share=0.5, seconds=600.0)
