"""Variants of a program: with other E and picks, and with several parts of different E."""

import json
import re
from pathlib import Path

import numpy as np

from agents.plants.study_machines import StudyProgram
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.plants.plant_names import MODEL
from grind_env.toml import read_toml

NUMBER = r"(\d+\.?\d*|\.\d+)"
FEED, PICK, DRESSES = (
    re.compile(rf"(?<![A-Z]){word}", re.IGNORECASE) for word in (f"E{NUMBER}", f"J(-?){NUMBER}", r"D\d+")
)
COMMENT = re.compile(r"(\([^)\n]*\)|;[^\n]*)")
INFEED = re.compile(r"(G0?1 Y-\.\d+ F)(\.\d+)", re.IGNORECASE)  #: infeed motion while the table runs
NEXT = "G80\nM00\n"
HEAD = re.compile(r"\s*(%|[O:]\d+|$)", re.IGNORECASE)  #: start of a line that precedes the first block
END, LABEL = re.compile(r"(?<![A-Z])M0?(30|2)(?!\d)", re.IGNORECASE), re.compile(r"^\s*N\d+\s*", re.IGNORECASE)
FILES = re.compile(r"^files\s*=\s*\[[^\]]*\]", re.MULTILINE)
CATALOGUE = re.compile(r"^\[catalogue\][^\n]*$", re.MULTILINE)


def scaled(text: str, E: float = 1.0, J: float = 1.0, *, dressed: bool = True) -> str:
    """Return the program with E times a factor, depths of cut times J, and without dresses unless `dressed`."""

    def words(code: str) -> str:
        code = FEED.sub(lambda found: f"E{_number(E * float(found[1]))}", code)
        code = PICK.sub(lambda found: f"J{found[1]}{_number(J * float(found[2]))}", code)
        code = INFEED.sub(lambda found: f"{found[1]}{_number(E * J * float(found[2]))}", code)
        return code if dressed else DRESSES.sub("D0", code)

    return "".join(piece if COMMENT.fullmatch(piece) else words(piece) for piece in COMMENT.split(text))


def batch(program: StudyProgram, feeds: tuple[float, ...], dressed: tuple[bool, ...]) -> str:
    """Return the program for several parts, each with a factor on E, and dressed or not; GrindError if impossible."""
    head, body, tail = _pieces(program.text)
    bodies = [scaled(body, E, dressed=D) for E, D in zip(feeds, dressed, strict=True)]
    text = head + NEXT.join(bodies) + "M30\n" + tail
    job = load_job(program.job, plant=MODEL)
    own = grind(program.read(program.text), job)
    try:
        whole = grind(program.read(text), job)
    except GrindError as error:
        raise _not_so(program, f" ({error})") from None
    parts = [np.unique(whole.strokes["E"][whole.strokes["part"] == number]) for number in whole.parts["part"]]
    speeds = np.outer(feeds, np.unique(own.strokes["E"]))
    same = (a.shape == b.shape and np.allclose(a, b) for a, b in zip(parts, speeds, strict=False))
    if len(own.parts) != 1 or len(parts) != len(feeds) or not all(same):
        raise _not_so(program, "")
    return text


def with_catalogue(job: Path, file: Path) -> str:
    """Return the text of a job that reads a further catalogue file; its paths are valid in any folder."""
    text = job.read_text(encoding="utf-8")
    held = read_toml(job).get("catalogue")
    if held is None:
        return f'{text}\n[catalogue]\nfiles = ["{file.as_posix()}"]\n'
    files = json.dumps([*((job.parent / each).resolve().as_posix() for each in held.get("files", ())), file.as_posix()])
    return CATALOGUE.sub(lambda found: f"{found[0]}\nfiles = {files}", FILES.sub("", text))


def _pieces(text: str) -> tuple[str, str, str]:
    """Return the text before the first block, the blocks up to the end of the program, and the subprograms."""
    lines = text.splitlines(keepends=True)
    code = [COMMENT.sub("", line) for line in lines]
    begin = next((k for k, line in enumerate(code) if not HEAD.match(line)), len(lines))
    end = next((k for k, line in enumerate(code) if END.search(line)), len(lines))
    body = [LABEL.sub("", line) for line in lines[begin:end]]
    return "".join(lines[:begin]), "".join(body), "".join(lines[end + 1 :])


def _number(value: float) -> str:
    """Return a number with a decimal point; some controls count a number without one in steps."""
    return f"{value:.6f}".rstrip("0")


def _not_so(program: StudyProgram, why: str) -> GrindError:
    return GrindError(
        f"{program.path.name}: the study writes it out for several parts with other E in each, and that does not grind "
        f"as it should{why}; let it grind one part, its E be numbers, and nothing of it jump or count"
    )


def write(path: Path, text: str) -> Path:
    """Write a text to a file, and return the path."""
    path.write_text(text, encoding="utf-8")
    return path
