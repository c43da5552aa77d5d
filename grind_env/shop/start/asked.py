"""What is asked of a part that has no program yet: its job and its catalogue, written and read."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from grind_env.errors import GrindError
from grind_env.files import read_text
from grind_env.machine.job import Job, Part
from grind_env.machine.job.file import load_job
from grind_env.process.catalogue import load_catalogue
from grind_env.process.entries import Machine, Wheel
from grind_env.process.tables import contents
from grind_env.shop.start.folder import CATALOGUE, HERE, JOB, OWN
from grind_env.shop.start.rules import LEAST_STOCK, WHEEL_SPEED
from grind_env.shop.start.template import example_values, job_template

FIELDS = {
    "length": "length",
    "width": "width",
    "stock": "stock",
    "Ra": "roughness_limit",
    "tolerance": "tolerance",
}
"""Of a `Part`, by the option that says it."""


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

    @property
    def numbers(self) -> Mapping[str, float]:
        """Those that are said, by option."""
        return {name: value for name in FIELDS if (value := getattr(self, name)) is not None}


def texts_of(asked: Asked) -> dict[str, str]:
    """The job and the catalogue that it names, by the names of their files.

    Raises:
        AskedError: a number that no part has.
        CatalogueError: there is no such material or wheel, or the catalogue cannot be used.
    """
    for name, value in asked.numbers.items():
        _check(name, value)
    example, own = example_values(), asked.catalogue
    known = load_catalogue(*(() if own is None else (own,)))
    usual = example["setup"]["wheel"]
    material = known.material(example["part"]["material"] if asked.material is None else asked.material)
    wheel = known.wheel(usual if asked.wheel is None else asked.wheel)
    machine = known.machines.get(OWN["machine"], known.machine("default"))
    catalogue = read_text(HERE / CATALOGUE if own is None else own)
    names = {"wheel": wheel.name, "machine": machine.name}
    if own is None:
        width = known.wheel(usual).width
        catalogue = catalogue.replace(usual, wheel.name).replace(f"width = {width:g}", f"width = {wheel.width:g}")
        names = {kind: name.replace(usual, wheel.name) for kind, name in OWN.items()}
    job = {
        **example,
        "part": {
            **example["part"],
            "material": material.name,
            **{FIELDS[name]: value for name, value in asked.numbers.items()},
        },
        "setup": {**example["setup"], **names, "wheel_speed": _speed(wheel, machine)},
        "catalogue": {"files": [CATALOGUE]},
    }
    return {JOB: job_template(job), CATALOGUE: catalogue}


def job_in(texts: Mapping[str, str]) -> Job:
    """The job of some files, as it is read."""
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        return load_job(Path(folder, JOB))


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
