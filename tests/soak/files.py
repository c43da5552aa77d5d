"""Hostile files for every reader: each is read, or refused with an error sentence.

No file makes a reader read or write elsewhere, run code, hang or fill memory. Its content reaches terminals, pages and
tables only as text.
"""

import csv
import io
import json
import os
import random
import sys
import tempfile
import warnings
from pathlib import Path

from grind_env.errors import GrindError
from grind_env.files import FORMULA
from tests.soak.hostile import CANARY, MARKUP, lay
from tests.soak.limits import TooSlowError, limited, room
from tests.soak.part import Part, Tried, broken, fallen, refused
from tests.soak.readers import NAME, READS, Read, call, copied, good_folder
from tests.test_printable import CONTROLS

ROOM = 1 << 30  #: growth of the process that a file may cause, bytes
TOKEN = "canary-5c19"
RAN = "ran.txt"
#: module that leaves a file behind if its code is run
MODULE = f"""
from pathlib import Path

Path("{RAN}").write_text("imported")

def __getattr__(name):
    Path("{RAN}").write_text(name)
    raise AttributeError(name)
"""
STATUSES = (0, 1, 3, 4)  #: exit statuses of a command that has done its work
#: files beside the valid files, which no command may read or write
SECRETS = {"secret_txt": f"{TOKEN}\n", "secret_toml": f'[login]\npassword = "{TOKEN}"\n'}
LAID = 0.08  #: share of cases with a pipe, folder, link or the like in place of a file
WARM: set[Read] = set()  #: reads of a valid file in this process, after which all their code is compiled


def prepare() -> None:
    """Write valid files and the module that leaves a trace."""
    good_folder()
    modules = tempfile.mkdtemp(prefix="soak-modules-")
    Path(modules, f"{CANARY}.py").write_text(MODULE)
    sys.path.append(modules)


def attempt(seed: int) -> Tried:
    """Read the hostile file of a seed."""
    rng = random.Random(seed)
    (read,) = rng.choices(READS, [each.weight for each in READS])
    if read not in WARM:
        WARM.add(read)
        with copied(**SECRETS) as inside:
            _read(read, inside)
    with copied(**SECRETS) as inside:
        path = inside / read.file
        if read.file != NAME and rng.random() < LAID:
            os.chdir(path.parent)
            lay(Path(path.name), rng)
            os.chdir(inside)
        else:
            path.write_bytes(read.change(path.read_bytes(), rng))
        shown = f"{read.file}: {read.words}\n{_beginning(path)}"
        try:
            with warnings.catch_warnings(), limited(read.seconds), room(ROOM):
                warnings.simplefilter("ignore")
                tried = _read(read, inside)
        except TooSlowError as error:
            return fallen(error, shown)
        except Exception as error:
            return fallen(error, shown)
        if read.file != NAME and (inside / RAN).exists():
            return broken("runs code", shown)
        wrong = _written(inside)
        if wrong:
            return broken(*wrong)
    if tried.end == "fallen":
        return Tried("fallen", tried.kind, f"{tried.details}\n{shown}")
    kind = str(read.words).split()[0] if isinstance(read.words, str) else "function"
    return Tried(tried.end, sums={f"{read.file} by {kind}: {tried.end}": 1})


def _read(read: Read, inside: Path) -> Tried:
    """Read a file with a command or function; return the result."""
    if not isinstance(read.words, str):
        try:
            read.words(inside / read.file)
        except GrindError as error:
            return refused(error)
        return Tried("accepted")
    typed = inside / read.typed
    said = call(read.words, typed.read_bytes() if typed.is_file() and not typed.is_symlink() else b"")
    if CONTROLS & set(said.out + said.error):
        return broken("controls the terminal", repr(said.out + said.error)[-3000:])
    if TOKEN in said.out + said.error:
        return broken("shows another file", (said.out + said.error)[-3000:])
    if "--json" in read.words and not _is_json(said.out):
        return broken("no JSON", said.out[-3000:])
    if "Traceback" in said.error:
        return broken("traceback", said.error)
    if said.status in STATUSES:
        return Tried("accepted")
    if said.status != 2 or not (said.error or said.out).strip():
        return broken(f"status {said.status}", said.error or said.out[-3000:])
    return Tried("refused")


def _written(inside: Path) -> tuple[str, str] | None:
    """Return the fault of the written files and its details, or None."""
    beside = sorted(path.name for path in inside.parent.iterdir())
    if beside != ["inside", "secret.toml", "secret.txt"] or TOKEN not in (inside.parent / "secret.txt").read_text():
        return "writes elsewhere", str(beside)
    for path in inside.glob("out.*"):
        text = path.read_text("utf-8", "replace")
        if path.suffix == ".csv":
            for cell in (each for row in csv.reader(io.StringIO(text, newline="")) for each in row):
                if cell.startswith(FORMULA) and not _is_number(cell):
                    return "formula in a cell", cell
        if path.suffix in (".html", ".svg") and MARKUP in text:
            return f"markup in {path.suffix}", text[max(text.index(MARKUP) - 500, 0) :][:1000]
    return None


def _is_json(out: str) -> bool:
    """Return whether each line is standard JSON, without NaN and Infinity."""

    def refuse(constant: str) -> None:
        raise ValueError(constant)

    try:
        for line in out.splitlines():
            json.loads(line, parse_constant=refuse)
    except ValueError:
        return False
    return True


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _beginning(path: Path) -> str:
    if path.is_file() and not path.is_symlink():
        return repr(path.read_bytes()[:6000])
    return f"no file: {'link' if path.is_symlink() else 'there' if path.exists() else 'missing'}"


PART = Part(name="files", attempt=attempt, prepare=prepare, share=1.5, seconds=120.0)
