"""The folder of a part that has no program yet: as that of the example, with a program that is proposed."""

import math
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from grind_env.control import read
from grind_env.errors import GrindError
from grind_env.files import read_text
from grind_env.machine.job import Job, Part
from grind_env.machine.job.file import load_job
from grind_env.process.catalogue import load_catalogue
from grind_env.process.entries import Machine, Wheel
from grind_env.process.tables import contents
from grind_env.shop.optimise.variation import Progress
from grind_env.shop.start.folder import (
    CATALOGUE,
    FILES,
    HERE,
    JOB,
    LOG,
    NOTEBOOK,
    OWN,
    PROGRAM,
    require_new,
    write_folder,
)
from grind_env.shop.start.proposal import Proposal, proposal_of
from grind_env.shop.start.rules import LEAST_STOCK, WHEEL_SPEED
from grind_env.shop.start.sample import sample_log
from grind_env.shop.start.template import example_values, job_template

FIELDS = {
    "length": "length",
    "width": "width",
    "stock": "stock",
    "Ra": "roughness_limit",
    "tolerance": "tolerance",
}
"""Of a `Part`, by the option that says it."""
EXAMPLE_FEED = "E15000."
"""Of the example, which its notebook changes."""


class AskedError(GrindError):
    """A number that no part has."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """What is said of a part; None for what the example has.

    Attributes:
        material: name of an entry of the catalogue.
        wheel: likewise.
        Ra: highest, um.
        tolerance: on the size, um.
        length: along the table, mm.
        width: across, mm.
        stock: to grind off, mm.
        catalogue: a file of the user's own entries, which is copied; the machine is its `our_grinder`, or `default`.
    """

    material: str | None = None
    wheel: str | None = None
    Ra: float | None = None
    tolerance: float | None = None
    length: float | None = None
    width: float | None = None
    stock: float | None = None
    catalogue: Path | None = None


class Task(NamedTuple):
    """What is to be ground: the job as it is read, and the texts of its file and of the catalogue that it names."""

    job: Job
    texts: dict[str, str]


def propose_folder(
    folder: Path, asked: Asked, *, seconds: float, seed: int, progress: Progress = lambda label, count: None
) -> tuple[list[Path], Proposal]:
    """Propose a program for a part, and write it with its job and all that `start_folder` writes.

    Args:
        folder: is made if need be.
        asked: of the part.
        seconds: as of `proposal_of`, like the ones after it.
        seed: of lots and search.
        progress: is told what is being done.

    Returns:
        The files, the program first, and the proposal.

    Raises:
        NotHeldError: no program that was tried keeps the limits; nothing is written.
        ExistsError: one of the files is there already, which is found out before the search.
        GrindError: as of `task_of` and `write_folder`.
    """
    require_new(folder, FILES)
    job, texts = task_of(asked)
    found = proposal_of(job, seconds=seconds, seed=seed, progress=progress)
    notebook = read_text(HERE / NOTEBOOK).replace(EXAMPLE_FEED, f"E{found.words.rough_feed:.0f}.")
    log = sample_log(read(found.text, PROGRAM), job)
    return write_folder(folder, {PROGRAM: found.text, **texts, NOTEBOOK: notebook, LOG: log}), found


def task_of(asked: Asked) -> Task:
    """The job of a part, and its files.

    Raises:
        AskedError: a number that no part has.
        CatalogueError: there is no such material or wheel, or the catalogue cannot be used.
    """
    numbers = {name: value for name in FIELDS if (value := getattr(asked, name)) is not None}
    for name, value in numbers.items():
        _check(name, value)
    example, own = example_values(), asked.catalogue
    known = load_catalogue(*(() if own is None else (own,)))
    usual = known.wheel(example["setup"]["wheel"])
    material = known.material(example["part"]["material"] if asked.material is None else asked.material)
    wheel = usual if asked.wheel is None else known.wheel(asked.wheel)
    machine = known.machines.get(OWN["machine"], known.machine("default"))
    catalogue, names = read_text(HERE / CATALOGUE if own is None else own), (wheel.name, machine.name)
    if own is None:
        catalogue = catalogue.replace(usual.name, wheel.name)
        catalogue = catalogue.replace(f"width = {usual.width:g}", f"width = {wheel.width:g}")
        names = OWN["wheel"].replace(usual.name, wheel.name), OWN["machine"]
    part = {"material": material.name, **{FIELDS[name]: value for name, value in numbers.items()}}
    setup = {"wheel": names[0], "machine": names[1], "wheel_speed": _speed(wheel, machine)}
    job = {
        **example,
        "part": {**example["part"], **part},
        "setup": {**example["setup"], **setup},
        "catalogue": {"files": [CATALOGUE]},
    }
    texts = {JOB: job_template(job), CATALOGUE: catalogue}
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        return Task(load_job(Path(folder, JOB)), texts)


def _speed(wheel: Wheel, machine: Machine) -> float:
    """Wheel speed by the rule, or the highest that wheel and spindle take, m/s."""
    return min(WHEEL_SPEED, wheel.maximum_speed, math.pi * wheel.diameter * machine.maximum_spindle_speed / 60_000.0)


def _check(name: str, value: float) -> None:
    quantity = contents(Part)[FIELDS[name]].quantity
    assert quantity is not None
    least = LEAST_STOCK if name == "stock" else quantity.low
    if not (quantity.allows(value) and value >= least and value > 0.0):
        low = f"above 0, up to {quantity.high:g}" if least == 0.0 else f"from {least:g} to {quantity.high:g}"
        raise AskedError(f"--{name} is {value:g}, but must be a number {low} {quantity.unit}")
