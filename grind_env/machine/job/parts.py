"""The parts of a job: dimensions and limits, stages, stations on the table, and differences from part to part.

The part lies where the program finds it: from `start` to `start + length` along the reciprocating axis and
from `across` to `across + width` along the cross axis; the wheel touches it at `surface`, and the infeed is
towards minus. A position of the wheel is that of its centre along the table, of its face in depth, and of its
edge on the minus side across the table.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

from grind_env.control.control_settings import ORIGIN
from grind_env.control.modes import WorkSystem
from grind_env.control.motion_paths import displaced
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.job.errors import JobError
from grind_env.message_text import did_you_mean, quoted
from grind_env.process.cost import NO_LIMIT
from grind_env.process.entries import Material, Quantity
from grind_env.process.stroke_types import FORCES, StrokeParameters
from grind_env.process.toml_tables import check, wrong


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """Requirements on a part at a gauging stop (M01) of its program, such as between roughing and finishing.

    Attributes:
        stock: nominal depth to grind off up to the stop; a difference of the true stock counts in the final size only.
        roughness_limit: highest Ra; 0 for none.
        tolerance: limit of the size error; 0 for none.
        rise_allowance: allowed temperature rise above tempering, for the plunges since the stop before. With 0 only
            those of the last 0.05 mm count, otherwise all.
    """

    stock: Annotated[float, Quantity("H", "mm", 0.0001, 20)]
    roughness_limit: Annotated[float, Quantity("Ra", "um", 0, 50)] = NO_LIMIT
    tolerance: Annotated[float, Quantity("tol", "um", 0, 1000)] = NO_LIMIT
    rise_allowance: Annotated[float, Quantity("dT", "K", 0, 2000)] = 0.0

    def __post_init__(self) -> None:
        check(self, "part.stages", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """The part and its limits.

    Attributes:
        material: work material.
        length: length along the reciprocating axis; for a part with grooves the length that every infeed grinds (the
            circumference if the part turns).
        width: width along the cross axis.
        stock: depth to grind off; for a program without strokes the depth of its grooves.
        start: coordinate of the minus end of the part along the reciprocating axis.
        across: coordinate of the minus edge of the part along the cross axis.
        surface: plunge coordinate where the wheel touches the part; of grooves on the infeed axis (X is a radius).
        roughness_limit: highest Ra; 0 for none.
        tolerance: limit of the size error; 0 for none.
        scrap_cost: price of a scrapped part.
        rise_allowance: allowed temperature rise above tempering, for a surface that is ground again later. With 0 only
            the plunges of the last 0.05 mm count, otherwise all plunges.
        height: height above the table or chuck before grinding; the table is assumed to lie under the whole travel. A
            part whose size is judged needs a height, because a hot part grows in proportion. Left out if
            unknown: moves into the table then go unnoticed, and the part warms up and grows like one of 20 mm.
        stages: stages before the last one. The first M01 after the part has been ground ends the first stage, and so
            on. The limits above judge the last stage, up to the M00 or M30 that takes the part off; heat and power
            count only after the listed stages. Without stages the limits hold for all grinding of the part.
    """

    material: Material
    length: Annotated[float, Quantity("Lw", "mm", 1, 10_000)]
    width: Annotated[float, Quantity("b", "mm", 0.5, 2000)]
    stock: Annotated[float, Quantity("H", "mm", 0.0001, 20)]
    start: Annotated[float, Quantity("", "mm", -10_000, 10_000)] = 0.0
    across: Annotated[float, Quantity("", "mm", -10_000, 10_000)] = 0.0
    surface: Annotated[float, Quantity("", "mm", -10_000, 10_000)] = 0.0
    roughness_limit: Annotated[float, Quantity("Ra", "um", 0, 50)] = NO_LIMIT
    tolerance: Annotated[float, Quantity("tol", "um", 0, 1000)] = NO_LIMIT
    scrap_cost: Annotated[float, Quantity("", "$", 0, 1e6)]
    rise_allowance: Annotated[float, Quantity("dT", "K", 0, 2000)] = 0.0
    height: Annotated[float | None, Quantity("", "mm", 0.1, 10_000)] = None
    stages: tuple[Stage, ...] = ()

    def __post_init__(self) -> None:
        check(self, "part", JobError)
        tolerances = self.tolerance, *(stage.tolerance for stage in self.stages)
        if self.height is None and any(tolerance > NO_LIMIT for tolerance in tolerances):
            message = (
                "part.height is missing: a tolerance is given, and how far a hot part grows depends on its height; "
                "add height, mm above the chuck, to [part], or leave the tolerance out"
            )
            raise JobError(message, "part.height")
        least = 0.0
        for number, stage in enumerate(self.stages, 1):
            if not least <= stage.stock <= self.stock:
                legal = f"from that of the stage before, {least:g} mm, to part.stock, {self.stock:g} mm"
                message = f"stage {number}: part.stages.stock is {quoted(stage.stock)}, but must be {legal}"
                raise JobError(message, "part.stages.stock", stage.stock, legal)
            least = stage.stock

    def off(self, turn: float, other: float) -> float:
        """Return the distance of the middle of the ground length from the middle of two reversal points, mm."""
        low, high = max(min(turn, other), self.start), min(max(turn, other), self.start + self.length)
        return 0.5 * abs((low + high) - (turn + other))


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A part on the table beside others; one program grinds them all.

    Attributes:
        name: name in messages and tables.
        offset: work offset in which the place of the part is given; left out for machine coordinates, as for a
            program that shifts its zero by G52.
        origin: machine coordinates X, Y and Z of the zero of `offset`.
        part: the part at the station.
    """

    name: str
    offset: WorkSystem | None = None
    origin: Annotated[tuple[float, float, float], Quantity("", "mm", -10_000, 10_000)] = ORIGIN
    part: Part

    def __post_init__(self) -> None:
        check(self, "stations", JobError)
        if not self.name.strip() or not self.name.isprintable():
            raise wrong("stations.name", self.name, "a text of one line that is not empty", JobError)
        if self.offset is None and self.origin != ORIGIN:
            raise JobError(
                "stations.origin is that of an offset, and there is none; say stations.offset, or leave it out",
                "stations.origin",
            )

    def on_machine(self, axis: int) -> "Station":
        """Return the station with its part in machine coordinates, for a table that reciprocates along `axis`."""
        part, along, across, down = self.part, *(self.origin[k] for k in (axis, cross_axis(axis), plunge_axis(axis)))
        placed = replace(
            part,
            start=displaced(along, part.start),
            across=displaced(across, part.across),
            surface=displaced(down, part.surface),
        )
        return Station(name=self.name, part=placed)


@dataclass(frozen=True, slots=True, kw_only=True)
class PartConditions:
    """Differences of one part from the job.

    Attributes:
        part: the part, if there are several kinds; None for the part of the job.
        stock: true stock of the part, mm; None for the stock of `part`.
        factors: factors on fields of `StrokeParameters`, such as `kA` for a lot that dulls the wheel.
        new_wheel_factors: factors after a change of the wheel; None for `factors`.

    Raises:
        JobError: a stock or factor that is not a positive number, or a name that is no parameter.
    """

    part: Part | None = None
    stock: float | None = None
    factors: Mapping[str, float] = field(default_factory=dict)
    new_wheel_factors: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        numbers = (*self.factors.items(), *(self.new_wheel_factors or {}).items())
        for name, _ in numbers:
            if name not in StrokeParameters._fields:
                hint = did_you_mean(name, StrokeParameters._fields)
                raise JobError(
                    f"there is no stroke parameter {quoted(name)}{hint}; they are the fields of StrokeParameters", name
                )
        for name, value in (("stock", self.stock), *numbers):
            if value is not None and not 0.0 < value < math.inf:
                legal = "a positive number"
                raise JobError(f"{name} is {quoted(value)}, but must be {legal}", name, value, legal)

    def forced(self, factor: float) -> "PartConditions":
        """Return conditions with a factor on all forces, in addition to the own factors."""

        def times(factors: Mapping[str, float]) -> Mapping[str, float]:
            return {**factors, **{name: factors.get(name, 1.0) * factor for name in FORCES}}

        spare = None if self.new_wheel_factors is None else times(self.new_wheel_factors)
        return replace(self, factors=times(self.factors), new_wheel_factors=spare)

    def parameters(self, nominal: StrokeParameters, *, new_wheel: bool = False) -> StrokeParameters:
        """Return the parameters that hold for this part, under the first wheel or after a change of it."""
        factors = self.factors if self.new_wheel_factors is None or not new_wheel else self.new_wheel_factors
        changed = {name: getattr(nominal, name) * f for name, f in factors.items()}
        return nominal._replace(**changed) if changed else nominal


@dataclass(frozen=True, slots=True, kw_only=True)
class Lots:
    """Variation of the parts of a batch.

    Attributes:
        probability: probability that a part begins a new lot of material; the first part always does.
        growth: logarithmic standard deviation of the dulling rate of a lot.
        pressure: logarithmic standard deviation of a lot's pressure on the wear flats.
        stock: standard deviation of the stock of a part, as a share of the nominal one.
        roughness: logarithmic standard deviation of the roughness from part to part.
    """

    probability: Annotated[float, Quantity("", "", 0, 1)] = 1.0 / 6.0
    growth: Annotated[float, Quantity("", "", 0, 2)] = 0.45
    pressure: Annotated[float, Quantity("", "", 0, 1)] = 0.08
    stock: Annotated[float, Quantity("", "", 0, 0.3)] = 0.0
    roughness: Annotated[float, Quantity("", "", 0, 1)] = 0.15

    def __post_init__(self) -> None:
        check(self, "lots", JobError)


def require_conditions(conditions: Sequence[PartConditions], parts: int, program: str) -> None:
    """Refuse conditions for fewer parts than a program grinds; a job without conditions is legal.

    Raises:
        JobError: some parts have conditions, but not all.
    """
    if conditions and parts > len(conditions):
        raise JobError(
            f"{program} grinds more parts than the {len(conditions)} that have conditions; give conditions for every "
            "part or for none",
            "parts",
        )
