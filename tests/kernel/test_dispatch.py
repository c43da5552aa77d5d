"""An entry runs as plain Python first, is compiled in the background, and gives the same bits in both tiers."""

import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

import grind_env
from grind_env.kernel import entry
from grind_env.kernel.background_compiler import Background

PACKAGE = Path(grind_env.__file__).parent
TOY = """
import os, sys, time
from grind_env.kernel import dispatch, entry
from grind_env.kernel.background_compiler import Background
from numba.core.registry import CPUDispatcher
from toy_parts import scaled

dispatch.CACHE_CHECK_SECONDS = 0.001
kernel, said = scaled(3.0), None
plain = kernel(2.0)
end = time.monotonic() + 60.0
while type(kernel) is not CPUDispatcher and time.monotonic() < end:
    assert kernel(2.0) == plain
    time.sleep(0.02)
    if Background.process and said is None:
        said = Background.process.pid
        print(said, flush=True)
        if "kill" in sys.argv:
            os.kill(said, 9)
        if "wait" in sys.argv:
            time.sleep(60.0)
assert type(kernel) is CPUDispatcher and kernel(2.0) == plain
print(kernel.stats.cache_hits != {}, plain.hex())
"""
PARTS = """
from grind_env.kernel import entry, exp, inlined

def scaled(factor):
    @inlined
    def faded(x):
        return factor * exp(-x)

    @entry
    def kernel(x):
        total = 0.0
        for k in range(200):
            total += faded(x + k)
        return total

    return kernel
"""


def begin(folder: Path, *arguments: str) -> "subprocess.Popen[str]":
    """Start a process that calls the toy until it is compiled, and that is not taken for a test."""
    (folder / "toy.py").write_text(TOY)
    (folder / "toy_parts.py").write_text(PARTS)
    environment = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    environment |= {"NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, str(folder / "toy.py"), *arguments]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def end(process: "subprocess.Popen[str]") -> list[str]:
    """Return the lines that the process printed."""
    out, error = process.communicate()
    assert (process.returncode, error) == (0, "")
    return out.splitlines()


def runs(pid: int) -> bool:
    """Return whether a process exists."""
    try:
        os.kill(pid, 0)
    except OSError:
        return False
    return True


@pytest.mark.nightly
def test_simultaneous_processes_share_one_background_compilation(tmp_path: Path) -> None:
    starts = [end(process) for process in [begin(tmp_path) for _ in range(4)]]
    assert {line for _, line in starts} == {"True " + starts[0][1].split()[1]}
    assert len([*tmp_path.rglob("*.nbc")]) == 1
    # the kernel is on disk now, so no process compiles it
    assert end(begin(tmp_path)) == [starts[0][1]]


@pytest.mark.nightly
def test_an_entry_compiles_in_its_own_process_after_the_background_is_killed(tmp_path: Path) -> None:
    assert end(begin(tmp_path, "kill"))[-1].startswith("False ")
    assert len([*tmp_path.rglob("*.nbc")]) == 1


def test_the_background_process_ends_with_its_parent(tmp_path: Path) -> None:
    process = begin(tmp_path, "wait")
    assert process.stdout is not None
    pid = int(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    process.communicate()
    until = time.monotonic() + 20.0
    while runs(pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert not runs(pid)


def test_tests_and_workers_start_no_background_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def compiles() -> bool:
        return Background.compiles(entry(lambda x: x + 1.0), (numba.float64,), tmp_path)

    assert not compiles()
    monkeypatch.delenv("PYTEST_CURRENT_TEST")
    monkeypatch.setattr(multiprocessing, "parent_process", object)
    assert not compiles() and Background.process is None


DIVIDES = """
import numpy as np
from grind_env.kernel import entry, inlined

@inlined
def inverse(x):
    return 1.0 / x

@entry
def kernel(values):
    values[0] += 1.0
    values[1] = inverse(float(values[1] - values[1]))
    return values[0]

values = np.array([3.0, 4.0])
print(kernel(values), values, inverse(0.0), bool(kernel.overloads))
"""


def test_compiled_code_restarts_from_the_original_values_after_a_division_by_zero(tmp_path: Path) -> None:
    command, environment = [sys.executable, "-c", DIVIDES], {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["4.0", "[", "4.", "inf]", "inf", "True"]


@pytest.mark.nightly
@pytest.mark.bits
def test_every_entry_has_the_same_bits_in_both_tiers() -> None:
    entries = set()
    for path in PACKAGE.rglob("*.py"):
        module = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
        entries |= {f"{module} {name}" for name in re.findall(r"@entry\n *def (\w+)", path.read_text())}
    done = subprocess.run(
        [sys.executable, "-m", "tests.kernel.both_tiers"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert entries - set(done.stdout.splitlines()) == set()
