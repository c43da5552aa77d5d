"""Compiled kernels on disk: damaged files, unwritable folders, concurrent processes, other compilers, first starts."""

import itertools
import json
import multiprocessing
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numba
import pytest
from numba.extending import overload

import grind_env
from grind_env.kernel import cache, entry, inlined

DAY = 24 * 3600.0
KEYWAY = str(Path(grind_env.__file__).parent / "examples" / "keyway_g81.nc")

TOY = """
import sys
from grind_env.kernel import compile_at_once, entry

compile_at_once()

def scaled(factor):
    @entry
    def kernel(x, shift=1.0):
        return factor * x + shift
    return kernel

if "full" in sys.argv:
    import resource
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
kernels = [scaled(factor) for factor in range(KERNELS)]
print([kernel(2.0) for kernel in kernels])
print(sum(sum(kernel.stats.cache_hits.values()) for kernel in kernels if hasattr(kernel, "stats")))
"""
#: source of a kernel that calls another one, too long to be inlined
CALLING = """
import sys
from math import sin
from grind_env.kernel import compile_at_once, entry

compile_at_once()

def scaled(factor):
    @entry
    def called(x):
        return factor * (sin(x) + sin(x + 1.0) + SINES)

    @entry
    def kernel(x):
        return called(x) - called(x + 1.0)
    return kernel

print([scaled(int(factor))(2.0) for factor in sys.argv[1:]])
print(0)
""".replace("SINES", " + ".join(f"sin({k} * x)" for k in range(2, 60)))

RESULTS = "[1.0, 3.0]"

DAMAGES: list[Callable[[bytes], bytes]] = [
    lambda content: content[: len(content) // 2],
    lambda content: b"",
    lambda content: bytes(range(256)) * 40,
    lambda content: bytes(400) + content[400:],
    lambda content: content[: len(content) // 2] + bytes(400) + content[len(content) // 2 + 400 :],
    lambda content: content[:-400] + bytes(400),
]


class Start(NamedTuple):
    """Output of one run of the toy."""

    results: str
    hits: int
    lines: list[str]


class Toy:
    """A script with kernels, which runs in fresh processes."""

    def __init__(self, folder: Path, kernels: int = 2) -> None:
        self.cache = folder / "cache"
        self.script = folder / "toy.py"
        self.script.write_text(TOY.replace("KERNELS", str(kernels)), encoding="utf-8")

    def begin(self, *arguments: str, **environment: str) -> "subprocess.Popen[str]":
        place = {"NUMBA_CACHE_DIR": str(self.cache), "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, str(self.script), *arguments]
        environment = {**os.environ, **place, **environment}
        return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def start(self, *arguments: str, **environment: str) -> Start:
        return self.end(self.begin(*arguments, **environment))

    def end(self, process: "subprocess.Popen[str]") -> Start:
        out, error = process.communicate()
        assert process.returncode == 0, error
        results, hits = out.splitlines()
        return Start(results, int(hits), error.splitlines())

    def files(self) -> list[Path]:
        return sorted(path for path in self.cache.rglob("*") if path.is_file())


@pytest.fixture
def toy(tmp_path: Path) -> Toy:
    return Toy(tmp_path)


@pytest.fixture(scope="module")
def started(tmp_path_factory: pytest.TempPathFactory) -> Toy:
    """Return a toy that has run once and filled its cache."""
    toy = Toy(tmp_path_factory.mktemp("toy"))
    assert toy.start() == (RESULTS, 0, [])
    return toy


@pytest.fixture
def copied(toy: Toy, started: Toy) -> Toy:
    """Return a toy with a copy of the filled cache, which a test may change."""
    shutil.copytree(started.cache, toy.cache)
    return toy


def test_damaged_cache_files_are_reported_once_and_rewritten(tmp_path: Path) -> None:
    toy = Toy(tmp_path, len(DAMAGES))
    made = toy.start()
    assert (made.hits, made.lines) == (0, [])
    files = toy.files()
    for path, damage in zip(files, itertools.cycle(DAMAGES), strict=False):
        path.write_bytes(damage(path.read_bytes()))
    results, hits, lines = toy.start()
    assert (results, hits) == (made.results, 0)
    assert len(lines) == len(files) == len(DAMAGES)
    assert all(sum(str(path) in line for line in lines) == 1 for path in files)
    assert toy.start() == (made.results, len(DAMAGES), [])


@pytest.mark.nightly
def test_a_file_under_the_name_of_another_kernel_is_not_loaded(copied: Toy) -> None:
    one, other = copied.files()
    other.write_bytes(one.read_bytes())
    results, hits, (line,) = copied.start()
    assert (results, hits) == (RESULTS, 1)
    assert str(other) in line


@pytest.mark.nightly
def test_kernels_from_the_cache_call_their_own_inner_functions(toy: Toy) -> None:
    toy.script.write_text(CALLING, encoding="utf-8")
    alone = [toy.start(factor).results.strip("[]") for factor in "12"]
    assert toy.start(*"12").results == f"[{', '.join(alone)}]"


@pytest.mark.nightly
def test_kernels_run_on_a_full_disk_with_one_warning(toy: Toy, started: Toy) -> None:
    pytest.importorskip("resource")
    results, hits, (line,) = toy.start("full")
    assert (results, hits) == (RESULTS, 0)
    assert str(toy.cache) in line
    assert "NUMBA_CACHE_DIR" in line
    assert toy.files() == []
    shutil.copytree(started.cache, toy.cache, dirs_exist_ok=True)
    assert toy.start("full") == (RESULTS, 2, [])


def test_kernels_run_without_a_cache_folder_with_one_warning(toy: Toy) -> None:
    toy.cache.touch()
    results, hits, (line,) = toy.start()
    assert (results, hits) == (RESULTS, 0)
    assert str(toy.cache) in line


@pytest.mark.nightly
def test_kernels_are_loaded_from_a_read_only_folder(copied: Toy) -> None:
    folder = copied.files()[0].parent
    folder.chmod(0o555)
    try:
        if os.access(folder, os.W_OK):
            pytest.skip("root may write anywhere")
        assert copied.start() == (RESULTS, 2, [])
    finally:
        folder.chmod(0o755)


@pytest.mark.nightly
def test_one_of_several_simultaneous_processes_compiles_each_kernel(toy: Toy) -> None:
    starts = [*map(toy.end, [toy.begin() for _ in range(3)])]
    assert all((results, lines) == (RESULTS, []) for results, _, lines in starts)
    if sys.platform != "win32":
        assert sum(hits for _, hits, _ in starts) == 2 * (len(starts) - 1)
    assert toy.start() == (RESULTS, 2, [])
    assert len(toy.files()) == 2


@pytest.mark.nightly
def test_a_process_killed_while_compiling_does_not_block_the_next_one(toy: Toy, tmp_path: Path) -> None:
    toy.script.write_text(CALLING, encoding="utf-8")
    process = toy.begin("1")
    while not any(path.suffix == ".lock" for path in toy.files()):
        assert process.poll() is None
    process.kill()
    process.communicate()
    left = [path for path in toy.files() if path.suffix == ".lock"]
    assert left and toy.start("1").lines == []
    assert not any(path.suffix == ".lock" for path in toy.files())


@pytest.mark.nightly
@pytest.mark.parametrize(
    "environment",
    [{"NUMBA_OPT": "1"}, {"NUMBA_CPU_NAME": "generic"}, {"NUMBA_CPU_FEATURES": ""}, {"NUMBA_BOUNDSCHECK": "1"}],
    ids=str,
)
def test_code_for_another_cpu_or_other_settings_is_not_loaded(started: Toy, environment: dict[str, str]) -> None:
    assert started.start(**environment) == (RESULTS, 0, [])


@pytest.mark.nightly
def test_code_does_not_depend_on_threads_or_hash_seeds(started: Toy) -> None:
    assert started.start(NUMBA_NUM_THREADS="1", PYTHONHASHSEED="5") == (RESULTS, 2, [])


@pytest.mark.nightly
def test_plain_python_neither_reads_nor_writes_kernels(toy: Toy) -> None:
    assert toy.start(NUMBA_DISABLE_JIT="1") == (RESULTS, 0, [])
    assert toy.files() == []


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path / "kernels"


def test_kernels_unused_for_30_days_are_deleted(folder: Path) -> None:
    def kernel(x: complex) -> complex:
        return x + 1

    entry(kernel)(1)
    (used,) = folder.iterdir()
    entry(kernel)(1.0)
    (unused,) = set(folder.iterdir()) - {used}
    foreign, abandoned = folder / "notes.txt", folder / ".grind-killed"
    foreign.touch()
    abandoned.mkdir()
    for path in (used, unused, foreign, abandoned):
        os.utime(path, (time.time() - 31 * DAY,) * 2)
    entry(kernel)(1)
    entry(kernel)(1j)
    left = set(folder.iterdir())
    assert {used, foreign} < left
    assert not {unused, abandoned} & left


def look_up_uncached(functions: int) -> None:
    """Look up a kernel of `functions` functions that is not in the cache."""

    def after(function: Callable[[float], float]) -> Callable[[float], float]:
        return inlined(lambda x: function(x) + 1.0)

    chain = inlined(lambda x: x)
    for _ in range(functions - 2):
        chain = after(chain)
    kernel: Any = entry(lambda x: chain(x))
    assert kernel._cache.load_overload((numba.float64,), numba.core.registry.cpu_target.target_context) is None


def test_a_process_announces_a_long_compilation_once(
    folder: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache.KernelCache, "announced", False)
    look_up_uncached(20)
    assert caplog.messages == []
    look_up_uncached(50)
    look_up_uncached(100)
    (line,) = caplog.messages
    assert "about 5 s" in line and str(folder) in line


def test_worker_processes_do_not_announce_a_compilation(
    folder: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache.KernelCache, "announced", False)
    monkeypatch.setattr(multiprocessing, "parent_process", object)
    look_up_uncached(50)
    assert caplog.messages == []


def test_running_a_program_with_an_empty_cache_compiles_nothing(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "from grind_env.cli import main; main()", "run", KEYWAY, "--json"]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["parts"][0]["strokes"] == 23
    assert done.stderr == "" and not any(tmp_path.rglob("*.nbc"))


def half(x: float) -> float:
    return x / 2


overload(half)(lambda x: lambda x: x / 2)


def test_a_kernel_with_unknown_ingredients_runs_and_is_reported_as_uncached(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    @entry
    def kernel(x: float) -> float:
        return half(x)

    assert kernel(3.0) == 1.5
    (line,) = caplog.messages
    assert "kernel is compiled at every start: half in " in line
    assert list(folder.iterdir()) == []


def test_a_numba_without_support_for_the_cache_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(2):
        cache.keep_on_disk(SimpleNamespace())
    (line,) = caplog.messages
    assert numba.__version__ in line
