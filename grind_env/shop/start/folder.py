"""A folder to begin with: a program, its job, the shop's catalogue, a notebook, a sample log; all run as they are."""

import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from grind_env.errors import GrindError
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.files import FileError, read_text, shown
from grind_env.shop.start.template import EXAMPLE, example_values, job_template

HERE = Path(__file__).parent
PROGRAM, JOB, CATALOGUE, NOTEBOOK, LOG = "part.nc", "part.toml", "shop.toml", "first_steps.ipynb", "log.csv"
OWN = {"wheel": "our_a60j", "machine": "our_grinder"}
"""Entries of the catalogue that the job names."""


class ExistsError(GrindError):
    """A file that would be overwritten."""


def start_folder(folder: Path) -> list[Path]:
    """Write the files into a folder, which is made if need be; returns them, the program first."""
    example = example_values()
    job = {**example, "setup": {**example["setup"], **OWN}, "catalogue": {"files": [CATALOGUE]}}
    texts = {PROGRAM: read_text(EXAMPLES / f"{EXAMPLE}.nc"), JOB: job_template(job)}
    texts |= {name: read_text(HERE / name) for name in (CATALOGUE, NOTEBOOK, LOG)}
    paths = _require_new(folder, texts)
    made = [each for each in (folder, *folder.parents) if not _is_there(each)]
    moved = list[Path]()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".grind-") as unfinished:
            for name, text in texts.items():
                Path(unfinished, name).write_text(text, encoding="utf-8")
            for path in paths:
                Path(unfinished, path.name).replace(path)
                moved.append(path)
    except BaseException as error:
        _take_back(moved, made)
        if isinstance(error, OSError | ValueError):  # of a name that no folder can have
            why = getattr(error, "strerror", None) or error
            raise FileError(f"{shown(folder)} cannot be made: {why}; make room, or name another folder") from None
        raise
    return paths


def _require_new(folder: Path, names: Iterable[str]) -> list[Path]:
    place = next((each for each in (folder, *folder.parents) if _is_there(each)), folder)
    if _is_there(place) and not place.is_dir():
        raise FileError(f"{shown(folder)} cannot be made: {shown(place)} is no folder; name another one")
    paths = [folder / name for name in names]
    for path in paths:
        if _is_there(path):
            raise ExistsError(f"{shown(path)} is there already, and is not overwritten; name another folder")
    return paths


def _is_there(path: Path) -> bool:
    """Whether a name is taken, if only by a link that leads nowhere."""
    try:
        path.lstat()
    except (OSError, ValueError):
        return False
    return True


def _take_back(files: Sequence[Path], folders: Sequence[Path]) -> None:
    """Remove files, and those folders that are then empty, the innermost of which comes first."""
    with suppress(OSError):
        for path in files:
            path.unlink(missing_ok=True)
        for folder in folders:
            folder.rmdir()
