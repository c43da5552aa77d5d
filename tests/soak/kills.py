"""Kills at every write of every command: no file is lost or half written, and the same command ends as if unkilled.

A command is killed before it opens a file to write, renames, makes or removes one, each of them in its turn; or in the
middle of a file, when that has come to so many bytes.
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

MOMENTS = re.compile(rb"\d{4}-\d\d-\d\d[T ]?\d\d:\d\d(:\d\d(\.\d+)?)?|D:\d{14}|[0-9a-f]{10,}")
"""What differs from run to run: times, and names that are drawn."""
SMALL = "--vary E --bounds E=8000..12000 --budget 60s"
"""A search that ends by itself: what the time ends may be another one when it is run again."""
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
STATUSES = (0, 3)
"""3 tells that no better program was found, and none is written."""
BLOCK = 8
"""Cases of a command in a row: each process runs it whole before it kills it."""
WRITING = os.O_WRONLY | os.O_RDWR
CHANGES = {"os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate"}
LITTER = ".grind-"
"""What a killed command may leave behind, which no other reads."""


@dataclass(slots=True)
class Watch:
    """Events of a command that change something on the disk; the process is killed before the one numbered `kill`."""

    count: int = 0
    kill: int = 0
    on: bool = False
    put: list[tuple[str, bytes]] = field(default_factory=list)
    """Names of files that were put in place, and what was in them; of a command that is not killed."""

    def hear(self, event: str, arguments: tuple[object, ...]) -> None:
        """As `sys.addaudithook` calls it."""
        if not self.on or not (event in CHANGES or (event == "open" and _writes(arguments))):
            return
        if event == "os.rename" and not self.kill:
            new, place = (Path(str(each)) for each in arguments[:2])
            self.put.append((place.name, new.read_bytes()))
        self.count += 1
        if self.count == self.kill:
            os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True, slots=True)
class Whole:
    """What a command does that is not killed: its status, its writes, what the folder holds then and held before."""

    status: int
    writes: int
    files: Mapping[str, bytes | None]
    put: tuple[tuple[str, bytes], ...]


WATCH = Watch()
WHOLE: dict[str, Whole] = {}


def prepare() -> None:
    """Write good files."""
    sys.addaudithook(WATCH.hear)
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    good_folder()


def attempt(seed: int) -> Tried:
    """Kill the command of a seed, and run it once more."""
    row, place = divmod(seed, BLOCK * len(COMMANDS))
    words, turn = COMMANDS[place // BLOCK], BLOCK * row + place % BLOCK
    whole, rng = _whole(words), random.Random(seed)
    if whole.status not in STATUSES:
        return broken(f"{words}: status {whole.status}", "")
    with copied() as folder:
        if turn % 2 and not words.startswith(("init", "advise")):  # these go on, or replace nothing
            _run(words)
        before = contents(folder)
        step, most = 1 + turn // 2 % max(whole.writes, 1), 0
        if turn % 4 == 3:
            good = contents(good_folder())
            largest = max(len(data) for name, data in whole.files.items() if data and name not in good)
            step, most = 0, rng.randrange(1, largest)
        status = _killed(words, step, most)
        how = f"{words}, killed at write {step} of {whole.writes}, or beyond {most} bytes: {status}"
        killed = contents(folder)
        for name, data in killed.items():
            if LITTER in name or data in (before.get(name, b""), whole.files.get(name, b"")):
                continue
            on_its_way = [content for place, content in whole.put if Path(name).name == place]
            if any(_alike(words, data, content) for content in (whole.files.get(name), *on_its_way)):
                continue
            return broken(f"{words}: a file is neither as before nor whole", f"{how}: {name}\n{(data or b'')[:2000]!r}")
        if lost := set(before) - set(killed):
            return broken(f"{words}: a file is lost", f"{how}: {lost}")
        again = _run(words)
        if again != whole.status and not (words.startswith("init") and again == 2 and set(killed) - set(before)):
            return broken(f"{words}: status {again} after a kill", how)
        after = {name: data for name, data in contents(folder).items() if LITTER not in name}
        if again == whole.status:
            for name, data in whole.files.items():
                if not _alike(words, found := after.get(name), data):
                    return broken(f"{words}: another result after a kill", f"{how}: {name}\n{(found or b'')[:2000]!r}")
        litter = any(LITTER in name for name in killed)
    dead = status in (-signal.SIGKILL, -signal.SIGXFSZ)
    return Tried("accepted", sums={f"killed: {words}": int(dead), "kills": int(dead), "left litter": int(litter)})


def _whole(words: str) -> Whole:
    """The run that is not killed, once in each process; it loads here what the killed ones need."""
    if words not in WHOLE:
        with copied() as folder:
            _run(words)  # what is imported and compiled writes, too
        with copied() as folder:
            WATCH.count, WATCH.kill, WATCH.on, WATCH.put = 0, 0, True, []
            status = _run(words)
            WATCH.on = False
            WHOLE[words] = Whole(status, WATCH.count, contents(folder), tuple(WATCH.put))
    return WHOLE[words]


def _run(words: str) -> int:
    """Run a command here."""
    return call(words).status


def _killed(words: str, step: int, most: int) -> int:
    """Run a command in a process that is killed before a write, or at a write beyond so many bytes; its exit status."""
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
    """Whether two files are the same but for moments and names that are drawn; a search is as long as its time."""
    if found is None or expected is None:
        return found is expected
    if words.startswith("optimise"):
        near = abs(len(found) - len(expected)) < 0.05 * len(expected)
        return near and found.split()[-1:] == expected.split()[-1:]
    return MOMENTS.sub(b"", found) == MOMENTS.sub(b"", expected)


PART = Part(name="kills", attempt=attempt, prepare=prepare, share=2.5, seconds=300.0)
