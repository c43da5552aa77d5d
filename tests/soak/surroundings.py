"""Commands in odd surroundings: full disk, closed streams, ASCII only, read-only folders, Ctrl-C.

A command always ends by itself with a status of its own and at most one sentence, and leaves no partial file.
"""

import ctypes
import os
import random
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.soak.part import Part, Tried, broken, clean
from tests.soak.readers import PACKAGE, contents, good_folder
from tests.test_printable import CONTROLS

COMMANDS = (
    *("check part.nc --json", "trace part.nc", "run part.nc --record out.csv", "run part.nc --plot out.png", "facts"),
    *("run part.nc --json", "report part.nc -o out.html", "catalogue", "tasks", "tasks task.toml", "job --template"),
    *("tasks grind/Rush-v0", "evaluate --policy E12000D1 --episodes 2", "init made", "figure dress -o out.svg"),
    *("play --policy E12000D1 --no-window --output out.nc", "play --policy handbook", "--help", "", "run --help"),
    *("advise part.nc --parts 2 --policy handbook", "calibrate settings.csv --job part.toml -o out.toml"),
    *("run missing.nc", "check missing.nc", "sweep part.nc --parts 2 --E 8000..9000 --dress-every 1..2 -o out.nc"),
)
STATUSES = {0, 1, 2, 3, 130, 141}
LATEST = 3.0  #: latest time of an interrupt, s
PATIENCE = 240.0  #: duration after which a command counts as a hang, s
WRONG = "Traceback (most", "Exception ignored", "Error in sys.", "Fatal Python", "object address", "Warning:"
#: CAP_DAC_OVERRIDE, which lets root write read-only files, and PR_CAPBSET_DROP, which drops it
CAPABILITY, DROP = 1, 24


@dataclass(slots=True)
class Surroundings:
    """Surroundings of a command."""

    name: str  # name in tables
    begin: Callable[[], object] = lambda: None  # function that the process of the command calls first
    # changes of the environment variables; None unsets one
    environment: Mapping[str, str | None] = field(default_factory=dict)
    out: str | None = None  # path for the output; None for a pipe
    error: str | None = None  # path for the errors; None for a pipe
    signal: int | None = None  # signal that is sent after a while
    reads_on: bool = True  # whether the output is read
    gone: bool = False  # whether the working folder is removed


def _closing(*descriptors: int) -> Callable[[], object]:
    def close() -> None:
        for each in descriptors:
            with suppress(OSError):
                os.close(each)

    return close


def _no_room(most: int) -> Callable[[], object]:
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


def may_not_write() -> None:
    """Make read-only modes apply to root, too."""
    ctypes.CDLL(None).prctl(DROP, CAPABILITY, 0, 0, 0)


FULL = "a full disk"
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LANG": None}
NOWHERE = "/dev/null/at/all"  #: path that nobody can create, not even root


def _drawn(rng: random.Random, folder: Path, installed: Path) -> Surroundings:
    """Draw surroundings; `installed` is a read-only copy of the package."""
    streams = rng.choice(((0,), (1,), (2,), (0, 1), (1, 2), (0, 1, 2)))
    read_only = {"PYTHONPATH": str(installed.parent), "HOME": NOWHERE, "XDG_CACHE_HOME": str(installed)}
    return rng.choice(
        (
            Surroundings("output to a full disk", out="/dev/full"),
            Surroundings("errors to a full disk", error="/dev/full"),
            Surroundings("both to a full disk", out="/dev/full", error="/dev/full"),
            Surroundings(FULL, _no_room(rng.choice((0, 1, 100, 3000, 20_000)))),
            Surroundings(f"streams {streams} closed", _closing(*streams)),
            Surroundings("nobody reads on", reads_on=False),
            Surroundings("locale C", environment=ASCII),
            Surroundings("locale C, ASCII output", environment={**ASCII, "PYTHONIOENCODING": "ascii"}),
            Surroundings("Latin-1 output", environment={"PYTHONIOENCODING": "latin-1"}),
            Surroundings("a narrow terminal", environment={"COLUMNS": rng.choice(("1", "0", "-5", "x", "99999"))}),
            Surroundings("no terminal", environment={"TERM": rng.choice(("dumb", "", "odd")), "FORCE_COLOR": "1"}),
            Surroundings("no home", environment={"HOME": None, "XDG_CACHE_HOME": None}),
            Surroundings("a home that is nowhere", environment={"HOME": NOWHERE, "MPLCONFIGDIR": NOWHERE}),
            Surroundings("no place for temporary files", environment=dict.fromkeys(("TMPDIR", "TEMP"), NOWHERE)),
            Surroundings("the folder gone", gone=True),
            Surroundings("a folder that is only read", lambda: (folder.chmod(0o555), may_not_write())),
            Surroundings("site-packages that are only read", may_not_write, environment=read_only),
            Surroundings("odd time zone and hash seed", environment={"TZ": "Nowhere/X", "PYTHONHASHSEED": "7"}),
            Surroundings("an interrupt", signal=signal.SIGINT),
            Surroundings("an interrupt", signal=signal.SIGINT),
            Surroundings("an interrupt", signal=signal.SIGINT),
            Surroundings("an end", signal=signal.SIGTERM),
        )
    )


FOLDER: list[Path] = []


def prepare() -> None:
    """Write valid files and a read-only copy of the package."""
    good_folder()
    FOLDER.append(Path(tempfile.mkdtemp(prefix="soak-around-")))
    (FOLDER[0] / "grind").write_text("from grind_env.__main__ import main\nmain()\n")
    installed = FOLDER[0] / "site" / "grind_env"
    shutil.copytree(PACKAGE, installed, ignore=shutil.ignore_patterns("__pycache__"))
    for path in [installed, *installed.rglob("*")]:
        path.chmod(0o555 if path.is_dir() else 0o444)


def attempt(seed: int) -> Tried:
    """Run the command of a seed in its surroundings."""
    rng = random.Random(seed)
    words = rng.choice(COMMANDS)
    with tempfile.TemporaryDirectory(prefix="soak-surroundings-") as base:
        folder = Path(base, "inside")
        shutil.copytree(good_folder(), folder)
        before = contents(folder)
        around = _drawn(rng, folder, FOLDER[0] / "site" / "grind_env")
        began = time.monotonic()
        status, out, error = _run(words, around, folder, rng.random() * LATEST)
        spent = time.monotonic() - began
        if not around.gone:
            folder.chmod(0o755)
        wrong = _wrong(words, around, status, out, error) or (
            None if around.gone else _files(before, folder, status, around)
        )
    if wrong is not None:
        return broken(f"{words}, {around.name}: {wrong}", f"status {status}\n{out[-1500:]}\n{error[-4000:]}")
    end = "refused" if status == 2 else "accepted"
    return Tried(end, sums={f"{around.name}: {end}": 1}, most={"slowest, s": spent})


def _run(words: str, around: Surroundings, folder: Path, moment: float) -> tuple[int, str, str]:
    """Run a command; return its exit status, output and errors."""
    environment = clean({**os.environ, "PYTHONWARNINGS": "default::ResourceWarning"})
    for name, value in around.environment.items():
        environment.pop(name, None)
        if value is not None:
            environment[name] = value

    def begin() -> None:
        around.begin()
        if around.gone:
            shutil.rmtree(folder)

    out, error = (
        subprocess.PIPE if name is None else os.open(name, os.O_WRONLY) for name in (around.out, around.error)
    )
    with subprocess.Popen(
        [sys.executable, FOLDER[0] / "grind", *shlex.split(words)],
        cwd=folder,
        env=environment,
        preexec_fn=begin,
        stdin=subprocess.PIPE,
        stdout=out,
        stderr=error,
    ) as process:
        for each in (out, error):
            if each != subprocess.PIPE:
                os.close(each)
        if not around.reads_on and process.stdout is not None:
            process.stdout.close()
            process.stdout = None
        if around.signal is not None:
            time.sleep(moment)
            process.send_signal(around.signal)
        said = process.communicate((folder / "readings.jsonl").read_bytes() if folder.exists() else b"", PATIENCE)
        texts = [(each or b"").decode("utf-8", "replace") for each in said]
    return process.returncode, texts[0], texts[1]


def _wrong(words: str, around: Surroundings, status: int, out: str, error: str) -> str | None:
    """Return what is wrong with the status and output of a command, or None."""
    started = "grind_env" in error  # Python itself may be interrupted before that
    if started and (found := next((each for each in WRONG if each in error), None)):
        return found
    if status not in STATUSES and not (around.signal is not None and status == -around.signal):
        return f"status {status}"
    hidden = around.error is not None or "closed" in around.name
    if status == 2 and not hidden and not (error + out).strip():
        return "status 2 without a word"
    if "FORCE_COLOR" not in around.environment and CONTROLS & set(out + error):
        return "controls the terminal"
    return None


def _files(before: Mapping[str, bytes | None], folder: Path, status: int, around: Surroundings) -> str | None:
    """Return what is wrong with the files in the folder, or None."""
    after = contents(folder)
    if changed := [name for name in before if after.get(name) != before[name]]:
        return f"changes {changed}"
    if litter := [name for name in after if ".grind-" in name and status >= 0]:
        return f"leaves {litter}"
    if around.name == FULL and status == 2 and any(name.startswith("out.") for name in after):
        return "has no room, and writes a file"
    return None


PART = Part(name="surroundings", attempt=attempt, prepare=prepare, seconds=300.0)
