"""Kills at every write of every command: no file is lost or half written, and the repeated command ends as usual.

A command is killed before it opens, renames, makes or removes a file, at each of these moments in turn; or while it
writes, when a file reaches a number of bytes.
"""

import os
import random
import re
import resource
import signal
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tests.soak.part import Part, Tried, broken
from tests.soak.readers import call, contents, copied, good_folder

#: pattern of texts that differ from run to run: times and random names
MOMENTS = re.compile(rb"\d{4}-\d\d-\d\d[T ]?\d\d:\d\d(:\d\d(\.\d+)?)?|D:\d{14}|[0-9a-f]{10,}")
#: options of a search that ends before its time is up, so that a repetition gives the same result
SMALL = "--vary E --bounds E=8000..12000 --budget 60s"
COMMANDS = (
    "run part.nc --record out.csv",
    "run part.nc --record out.parquet --plot out.png",
    "report part.nc",
    "play --policy E12000D1 --task oracle6 --no-window --output out.nc",
    "init made",
    "evaluate --task oracle6 --policy E12000D1 --episodes 2 --submit out.json --csv out.csv",
    "calibrate --plan out.nc --program part.nc --job part.toml",
    f"optimise part.nc --parts 2 {SMALL} -o out.nc --report out.html --plot out.svg",
    "sweep part.nc --parts 2 --E 8000..9000 --dress-every 1..2 -o out.nc --plot out.svg --csv out.csv",
    "advise part.nc --parts 2 --policy handbook --measurements measured.csv --write values.nc",
    "calibrate log.csv --job part.toml --program part.nc -o out.toml --report out.html",
    "figure dress --dress-every 2 -o out.svg",
    "train oracle6 --plant model --steps 10000 --episodes 2 -o out.safetensors",
)
STATUSES = (0, 3)  #: exit statuses of success; 3: no better program was found, and none is written
BLOCK = 8  #: number of successive cases with one command: each process first runs the command without a kill
WRITING = os.O_WRONLY | os.O_RDWR
CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate"}
LITTER = ".grind-"  #: part of the names of temporary files, which a killed command may leave behind


@dataclass(slots=True)
class Watch:
    """Audit hook that counts changes of the disk, and kills the process before the change numbered `kill`."""

    count: int = 0
    kill: int = 0
    on: bool = False
    #: names and contents of files that a command renamed into place, if it is not killed
    put: list[tuple[str, bytes]] = field(default_factory=list)

    def hear(self, event: str, arguments: tuple[object, ...]) -> None:
        """Count an audit event; kill the process if its number is reached."""
        if not self.on or not (event in CHANGES or (event == "open" and _writes(arguments))):
            return
        if event == "os.rename" and not self.kill:
            new, place = (Path(str(each)) for each in arguments[:2])
            self.put.append((place.name, new.read_bytes()))
        self.count += 1
        if self.count == self.kill:
            os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True, slots=True)
class UnkilledRun:
    """Run without a kill: exit status, number of writes, files in the end, and files that were renamed into place."""

    status: int
    writes: int
    files: Mapping[str, bytes | None]
    put: tuple[tuple[str, bytes], ...]


WATCH = Watch()
UNKILLED: dict[str, UnkilledRun] = {}


def prepare() -> None:
    """Install the audit hook and write valid files."""
    sys.addaudithook(WATCH.hear)
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    good_folder()


def attempt(seed: int) -> Tried:
    """Kill the command of a seed, and run the command again."""
    row, place = divmod(seed, BLOCK * len(COMMANDS))
    words, turn = COMMANDS[place // BLOCK], BLOCK * row + place % BLOCK
    unkilled, rng = _unkilled(words), random.Random(seed)
    if unkilled.status not in STATUSES:
        return broken(f"{words}: status {unkilled.status}", "")
    with copied() as folder:
        if turn % 2 and not words.startswith(("init", "advise")):  # init and advise resume, or replace nothing
            _run(words)
        before = contents(folder)
        step, most = 1 + turn // 2 % max(unkilled.writes, 1), 0
        if turn % 4 == 3:
            good = contents(good_folder())
            largest = max(len(data) for name, data in unkilled.files.items() if data and name not in good)
            step, most = 0, rng.randrange(1, largest)
        status = _killed(words, step, most)
        how = f"{words}, killed at write {step} of {unkilled.writes}, or beyond {most} bytes: {status}"
        killed = contents(folder)
        for name, data in killed.items():
            if LITTER in name or data in (before.get(name, b""), unkilled.files.get(name, b"")):
                continue
            on_its_way = [content for place, content in unkilled.put if Path(name).name == place]
            if any(_alike(words, data, content) for content in (unkilled.files.get(name), *on_its_way)):
                continue
            return broken(f"{words}: a file is neither old nor complete", f"{how}: {name}\n{(data or b'')[:2000]!r}")
        if lost := set(before) - set(killed):
            return broken(f"{words}: a file is lost", f"{how}: {lost}")
        again = _run(words)
        if again != unkilled.status and not (words.startswith("init") and again == 2 and set(killed) - set(before)):
            return broken(f"{words}: status {again} after a kill", how)
        after = {name: data for name, data in contents(folder).items() if LITTER not in name}
        if again == unkilled.status:
            for name, data in unkilled.files.items():
                if not _alike(words, found := after.get(name), data):
                    return broken(f"{words}: another result after a kill", f"{how}: {name}\n{(found or b'')[:2000]!r}")
        litter = any(LITTER in name for name in killed)
    dead = status in (-signal.SIGKILL, -signal.SIGXFSZ)
    return Tried("accepted", sums={f"killed: {words}": int(dead), "kills": int(dead), "left litter": int(litter)})


def _unkilled(words: str) -> UnkilledRun:
    """Return the run without a kill, once in each process; it loads all code of the killed runs."""
    if words not in UNKILLED:
        with copied() as folder:
            _run(words)  # importing and compiling write files, too
        with copied() as folder:
            WATCH.count, WATCH.kill, WATCH.on, WATCH.put = 0, 0, True, []
            status = _run(words)
            WATCH.on = False
            UNKILLED[words] = UnkilledRun(status, WATCH.count, contents(folder), tuple(WATCH.put))
    return UNKILLED[words]


def _run(words: str) -> int:
    """Run a command in this process; return its exit status."""
    return call(words).status


def _killed(words: str, step: int, most: int) -> int:
    """Run a command that is killed before a write, or at a write beyond `most` bytes; return its exit status."""
    process = os.fork()
    if process:
        return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    try:
        if most:
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        WATCH.count, WATCH.kill, WATCH.on = 0, step, True
        os._exit(_run(words))
    finally:
        os._exit(99)


def _writes(arguments: tuple[object, ...]) -> bool:
    path, _, flags = arguments
    if str(path) == os.devnull:
        return False
    return isinstance(flags, int) and bool(flags & WRITING)


def _alike(words: str, found: bytes | None, expected: bytes | None) -> bool:
    """Return whether two files agree apart from times and random names; a search may have other numbers."""
    if found is None or expected is None:
        return found is expected
    if words.startswith("optimise"):
        near = abs(len(found) - len(expected)) < 0.05 * len(expected)
        return near and found.split()[-1:] == expected.split()[-1:]
    return MOMENTS.sub(b"", found) == MOMENTS.sub(b"", expected)


PART = Part(name="kills", attempt=attempt, prepare=prepare, share=2.5, seconds=300.0)
