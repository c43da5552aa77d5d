"""The soak reports every kind of failure, and loses or repeats no case."""

import os
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from grind_env.plants import find_plant
from tests.patience import wait_until
from tests.soak import __main__ as soak
from tests.soak import files
from tests.soak.files import PART as FILES
from tests.soak.hostile import CANARY
from tests.soak.kills import COMMANDS
from tests.soak.log import Log
from tests.soak.part import Part, Tried
from tests.soak.readers import READS, CommandResult, Read
from tests.soak.turns import run
from tests.test_outputs import TREE


@pytest.fixture(scope="module", autouse=True)
def temporary_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Put temporary files of killed processes into a folder that pytest removes."""
    before, tempfile.tempdir = tempfile.tempdir, str(tmp_path_factory.mktemp("soak"))
    yield
    tempfile.tempdir = before


def odd(seed: int) -> Tried:
    """Fail in several ways."""
    if seed == 3:
        raise ZeroDivisionError
    if seed == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    if seed == 7:
        time.sleep(3600.0)
    time.sleep(0.01)
    return Tried("refused" if seed % 2 else "accepted", sums=Counter(seeds=seed), most={"seed": seed})


ODD = Part(name="odd", attempt=odd, seconds=1.0)


def even(seed: int) -> Tried:
    time.sleep(0.005)
    return Tried("accepted", sums={"seeds": seed})


EVEN = Part(name="even", attempt=even)


def test_the_soak_reports_exceptions_killed_processes_and_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(soak, "part_of", {"texts": ODD}.get)
    monkeypatch.setattr(soak, "log_in", lambda folder: Log(folder / "log.jsonl"))
    words = ["--part", "texts", "--minutes", "0.05", "--jobs", "1", "--out", str(tmp_path)]
    assert soak.main(words) == 1
    said = capsys.readouterr().err
    count = Log(tmp_path / "log.jsonl").counts()["odd"]
    kinds = {"ZeroDivisionError in test_soak.py:odd": 3, "its process ended with -9": 5, "hang": 7}
    assert {kind: falls[0][0] for kind, falls in count.falls.items()} == kinds and all(kind in said for kind in kinds)
    assert "Traceback" in said and "test_soak.py" in count.falls["hang"][0][1]
    assert count.ends["fallen"] == 3 and len(count.ended) == len(count.begun) > 10
    assert soak.main([*words[:2], "--seed", "3"]) == 1 and soak.main([*words[:2], "--seed", "4"]) == 0


def test_a_killed_run_resumes_and_counts_every_case_once(tmp_path: Path) -> None:
    log = Log(tmp_path / "log.jsonl", 40)
    process = os.fork()
    if process == 0:
        run([EVEN], log, 3600.0)
    wait_until(lambda: "even" in log.counts() and len(log.counts()["even"].ended) > 20)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    before = log.counts()["even"]
    assert len(before.begun) - len(before.ended) in (0, 1, 2)
    run([EVEN], log, 0.5)
    count = log.counts()["even"]
    assert count.begun.keys() == count.ended > before.ended and count.ends == {"accepted": len(count.begun)}
    assert count.sums == {"seeds": sum(count.begun)}


def growing(seed: int, kept: list[bytes] = []) -> Tried:  # noqa: B006
    kept.append(bytes([seed % 256]) * 1_000_000)
    time.sleep(0.005)
    return Tried("accepted")


def test_the_soak_reports_growing_memory(tmp_path: Path) -> None:
    log = Log(tmp_path / "log.jsonl")
    run([Part(name="growing", attempt=growing, growth=5.0), EVEN], log, 1.0)
    counts = log.counts()
    assert counts["growing"].falls.keys() == {"memory grows"} and counts["even"].falls == {}


# --- hostile files ------------------------------------------------------------------------------------


def command_name(words: str) -> str:
    """Return the name of a command in the tree of commands."""
    first, *others = words.split()
    return f"grind {first} {others[0]}" if first == "figure" else f"grind {first}"


def test_the_soak_covers_every_command_that_reads_or_writes_files() -> None:
    from grind_env.file_arguments import Keeps, Reads, Writes, roles_of

    roles = {name: set(map(type, roles_of(leaf.function).values())) for name, leaf in TREE.items()}
    read = {command_name(read.words) for read in READS if isinstance(read.words, str)}
    assert {name for name in roles if Reads in roles[name] and name.startswith("grind")} == read
    written = {command_name(words) for words in COMMANDS}
    assert {name for name in roles if {Writes, Keeps} & roles[name] and name.startswith("grind")} <= written


@pytest.fixture(scope="module")
def prepared() -> None:
    FILES.prepare()


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        (CommandResult(0, "fine", ""), ""),
        (CommandResult(2, "", "grind: no"), ""),
        (CommandResult(0, "\x1b[31mfine", ""), "controls the terminal"),
        (CommandResult(0, f"password {files.TOKEN}", ""), "shows another file"),
        (CommandResult(1, "", "Traceback (most recent call last):"), "traceback"),
        (CommandResult(2, "", ""), "status 2"),
        (CommandResult(70, "", "what?"), "status 70"),
    ],
)
def test_the_soak_reports_forbidden_output_of_a_command(
    said: CommandResult, kind: str, prepared: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "READS", [Read("part.nc", "run part.nc")])
    monkeypatch.setattr(files, "call", lambda words, typed: said)
    tried = FILES.attempt(1)
    assert (tried.end == "fallen", tried.kind) == (bool(kind), kind)


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("out.csv", "name,x\n=1+1,2\n", "formula in a cell"),
        ("out.csv", "name,x\n'=1+1,-2\n", ""),
        ("out.html", f"<p>{files.MARKUP}</p>", "markup in .html"),
        ("../out.nc", "G01", "writes elsewhere"),
    ],
)
def test_the_soak_reports_forbidden_files_of_a_command(
    name: str, text: str, kind: str, prepared: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def call(words: str, typed: bytes) -> CommandResult:
        Path(name).write_text(text)
        return CommandResult(0, "", "")

    monkeypatch.setattr(files, "READS", [Read("part.nc", "run part.nc")])
    monkeypatch.setattr(files, "call", call)
    assert FILES.attempt(1).kind == kind


def test_the_soak_reports_a_reader_that_runs_code(prepared: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def attempt(read: Read) -> str:
        monkeypatch.setattr(files, "READS", [read])
        return FILES.attempt(1).kind

    def runs(path: Path) -> object:
        return find_plant(f"{CANARY}:MACHINE", modules=True)

    assert attempt(Read("part.nc", runs)) == "runs code"
    assert attempt(Read("part.nc", lambda path: find_plant(f"{CANARY}:MACHINE"))) == ""


@pytest.mark.parametrize(
    ("read", "kind"),
    [
        (lambda path: {}["x"], "KeyError"),
        (lambda path: bytearray(2 << 30), "MemoryError"),
        (lambda path: [None for _ in iter(int, 1)], "TooSlowError"),
    ],
)
def test_the_soak_reports_readers_that_crash_hang_or_fill_memory(
    read: files.Read, kind: str, prepared: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader = Read("part.nc", read, seconds=0.2)
    monkeypatch.setattr(files, "READS", [reader])
    monkeypatch.setattr(files, "WARM", {reader})
    assert FILES.attempt(1).kind.startswith(kind)


def test_every_part_is_found_by_its_name() -> None:
    assert [soak.part_of(name).name for name in soak.NAMES] == soak.NAMES
