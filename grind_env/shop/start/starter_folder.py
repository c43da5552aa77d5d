"""The folder of `grind init`: program, job, catalogue, notebook and sample log."""

import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from os.path import lexists  # true of a broken link, too
from pathlib import Path

from grind_env.files import FileError, read_text, shown
from grind_env.shop.start.job_template import EXAMPLE, example_values, job_template

HERE = Path(__file__).parent
PROGRAM, JOB, CATALOGUE, NOTEBOOK, LOG = "part.nc", "part.toml", "shop.toml", "first_steps.ipynb", "log.csv"
OWN = {"wheel": "our_a60j", "machine": "our_grinder"}  #: entries of the catalogue that the job names


def start_folder(folder: Path) -> list[Path]:
    """Write the files into a folder, which is created if missing; return their paths, the program first."""
    example = example_values()
    job = {**example, "setup": {**example["setup"], **OWN}, "catalogue": {"files": [CATALOGUE]}}
    texts = {PROGRAM: read_text(EXAMPLE.with_suffix(".nc")), JOB: job_template(job)}
    texts |= {name: read_text(HERE / name) for name in (CATALOGUE, NOTEBOOK, LOG)}
    paths = _require_new(folder, texts)
    made = [each for each in (folder, *folder.parents) if not lexists(each)]
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
        if isinstance(error, OSError | ValueError):  # ValueError: no folder can have this name
            why = getattr(error, "strerror", None) or error
            raise FileError(f"{shown(folder)} cannot be made: {why}; make room, or name another folder") from None
        raise
    return paths


def _require_new(folder: Path, names: Iterable[str]) -> list[Path]:
    place = next((each for each in (folder, *folder.parents) if lexists(each)), folder)
    if lexists(place) and not place.is_dir():
        raise FileError(f"{shown(folder)} cannot be made: {shown(place)} is no folder; name another one")
    paths = [folder / name for name in names]
    for path in paths:
        if lexists(path):
            raise FileError(f"{shown(path)} is there already, and is not overwritten; name another folder")
    return paths


def _take_back(files: Sequence[Path], folders: Sequence[Path]) -> None:
    """Remove files, and then the empty ones of some folders, the innermost folder first."""
    with suppress(OSError):
        for path in files:
            path.unlink(missing_ok=True)
        for folder in folders:
            folder.rmdir()
