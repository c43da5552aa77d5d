"""Interrupted commands and commands without a working output end with their exit status and no traceback."""

import errno
import io
import re
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import grind_env
from grind_env.command_exit import command
from grind_env.errors import GrindError, GrindWarning
from tests.command import status
from tests.examples import few

ROOT = Path(grind_env.__file__).parents[1]
PLATE = str(ROOT / "grind_env" / "examples" / "plate_g82.nc")
GRIND = [sys.executable, "-c", "from grind_env.__main__ import main; main()"]
AGENTS = [sys.executable, "-m", "agents"]
COMMANDS = {
    "trace": [*GRIND, "trace", PLATE],
    "check": [*GRIND, "check", PLATE],
    "run": [*GRIND, "run", PLATE],
    "facts": [*GRIND, "facts"],
    "help": [*GRIND, "--help"],
    "agents": [*AGENTS, "--help"],
    "evaluate": [*GRIND, "evaluate", "--policy", "handbook", "--episodes", "2"],
}


def without_notice(said: str) -> str:
    """Return errors without the notice of compilation, which the first command on a machine prints."""
    return "".join(line for line in said.splitlines(keepends=True) if not line.startswith("compiling "))


@pytest.mark.parametrize("words", few(COMMANDS.values(), 2), ids=COMMANDS)
def test_a_full_disk_is_reported_in_one_sentence(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(words, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    name = "agents" if words[1] == "-m" else "grind"
    told = f"{name}: the output cannot be written (No space left on device)\n"
    assert (ended.returncode, without_notice(ended.stderr)) == (2, told)


@pytest.mark.parametrize("words", few(COMMANDS.values(), 2), ids=COMMANDS)
def test_a_command_ends_silently_if_its_output_pipe_is_closed(words: list[str]) -> None:
    started = subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert started.stdout is not None and started.stderr is not None
    started.stdout.close()
    assert without_notice(started.stderr.read().decode()) == ""
    assert started.wait() == 128 + signal.SIGPIPE
    started.stderr.close()


def test_a_warning_is_printed_once_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.warns(DeprecationWarning, match="of another library"), command("grind"):
        for _ in range(2):
            warnings.warn("#500 is not read\x1b", GrindWarning, stacklevel=1)
            with warnings.catch_warnings():  # as libraries do; Python would then repeat its warnings
                pass
        warnings.warn("of another library", DeprecationWarning, stacklevel=1)
    assert capsys.readouterr().err == "grind: warning: #500 is not read\\x1b\n"
    with pytest.warns(GrindWarning):
        warnings.warn("outside of a command", GrindWarning, stacklevel=1)


INTERRUPTED = """
import importlib.abc, sys

class Interrupting(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupting())
sys.argv = {arguments!r}
from {entry} import main
main()
"""


@pytest.mark.parametrize(
    ("entry", "module", "arguments"),
    few(
        [
            ("grind_env.__main__", "gymnasium", ["grind", "tasks"]),
            ("grind_env.__main__", "numpy", ["grind", "run", PLATE]),
            ("grind_env.__main__", "numba", ["grind", "run", PLATE]),
            ("grind_env.__main__", "grind_env.control", ["grind", "check", PLATE]),
            ("agents.__main__", "grind_env", ["agents", "--help"]),
            ("grind_env.__main__", "safetensors", ["grind", "evaluate", "--policy", "a.safetensors"]),
        ]
    ),
)
def test_an_interrupted_import_prints_nothing(entry: str, module: str, arguments: list[str]) -> None:
    script = INTERRUPTED.format(entry=entry, module=module, arguments=arguments)
    ended = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (128 + signal.SIGINT, "", "")


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (GrindError("part.nc has no blocks"), 2, "grind: part.nc has no blocks\n"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "(No space left on device)\n"),
        (FileNotFoundError(errno.ENOENT, "No such file", "a.csv"), 2, "grind: [Errno 2] No such file: 'a.csv'\n"),
        (BrokenPipeError(errno.EPIPE, "Broken pipe"), 141, ""),
        (KeyboardInterrupt(), 130, ""),
        (SystemExit(1), 1, ""),
    ],
    ids=repr,
)
def test_each_exception_has_its_exit_status_and_message(
    error: BaseException, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended, command("grind"):
        raise error
    assert ended.value.code == status
    found = capsys.readouterr().err
    assert found.endswith(said) and found.count("\n") == bool(said)


def test_the_console_script_is_the_guarded_main() -> None:
    assert 'grind = "grind_env.__main__:main"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


TABLES = {
    "run": ["run", PLATE],
    "tasks": ["tasks"],
    "catalogue": ["catalogue"],
    "entry": ["catalogue", "wheel", "a60j"],
    "facts": ["facts", "--page", "16-13"],
    "optimise": ["optimise", PLATE, "--vary", "E", "--bounds", "E=15000..15500", "--parts", "1"],
    "sweep": ["sweep", PLATE, "--E", "12000..15000", "--dress-every", "1..2", "--lead", ".08...12", "--parts", "2"],
    "calibrate": ["calibrate", "log.csv", "--program", "part.nc", "--job", "part.toml"],
}


def printed(words: list[str], columns: str, monkeypatch: pytest.MonkeyPatch, out: io.StringIO) -> list[str]:
    """Return the lines that a command prints if COLUMNS is set to `columns`."""
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setattr(sys, "stdout", out)
    assert status(*words) in (0, 3)
    return out.getvalue().splitlines()


class Screen(io.StringIO):
    """Output stream that calls itself a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shop")
    status("init", folder)
    return folder


@pytest.mark.usefixtures("few_lots")
@pytest.mark.parametrize("name", few(TABLES, 2))
def test_tables_are_complete_in_a_pipe(name: str, sample: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(sample)
    narrow, wide = (printed(TABLES[name], columns, monkeypatch, io.StringIO()) for columns in ("40", "2000"))
    assert narrow == wide
    assert len(wide) > 1
    assert not any("…" in line for line in wide)
    assert max(map(len, wide)) < 1000  # no line is drawn across the full width


def test_a_task_description_stays_on_one_line_in_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    from grind_env.pages import summaries

    lines = printed(["tasks"], "40", monkeypatch, io.StringIO())
    for row in summaries():
        assert any(row.id in line and row.hard in line for line in lines)


@pytest.mark.parametrize("name", ["tasks", "catalogue", "facts"])
def test_tables_fit_a_terminal(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = re.compile(r"\x1b\[[\d;]*m")
    lines = printed(TABLES[name], "60", monkeypatch, Screen())
    assert max(len(text.sub("", line)) for line in lines if "::" not in line) <= 60
