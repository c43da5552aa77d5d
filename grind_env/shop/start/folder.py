"""A folder to begin with: a program, its job, the shop's catalogue, a notebook, a sample log; all run as they are."""

import functools
from pathlib import Path

from grind_env.errors import GrindError
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.files import FileError, read_text, shown, write_atomically
from grind_env.shop.start.template import EXAMPLE, example_values, job_template

HERE = Path(__file__).parent
CATALOGUE, NOTEBOOK, LOG = "shop.toml", "first_steps.ipynb", "log.csv"
OWN = {"wheel": "our_a60j", "machine": "our_grinder"}
"""Entries of the catalogue that the job names."""


class ExistsError(GrindError):
    """A file that would be overwritten."""


def start_folder(folder: Path) -> list[Path]:
    """Write the files into a folder, which is made if need be; returns them, the program first.

    Raises:
        ExistsError: one of them is there already; nothing is then written.
        FileError: the folder cannot be made or written to.
    """
    example = example_values()
    job = {**example, "setup": {**example["setup"], **OWN}, "catalogue": {"files": [CATALOGUE]}}
    texts = {
        "part.nc": read_text(EXAMPLES / f"{EXAMPLE}.nc"),
        "part.toml": job_template(job),
        CATALOGUE: read_text(HERE / CATALOGUE),
        NOTEBOOK: read_text(HERE / NOTEBOOK),
        LOG: read_text(HERE / LOG),
    }
    paths = [folder / name for name in texts]
    for path in paths:
        if path.exists() or path.is_symlink():
            raise ExistsError(f"{shown(path)} is there already, and is not overwritten; name another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{shown(folder)} cannot be made: {error.strerror or error}; name another folder") from None
    for path, text in zip(paths, texts.values(), strict=True):
        write_atomically(path, functools.partial(_write, text))
    return paths


def _write(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")
