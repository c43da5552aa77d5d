"""The job: the part, the machine and its set-up, and the limits of a good part.

The part lies where the program finds it: from `start` to `start + length` along the reciprocating axis and
from `across` to `across + width` along the cross axis; the wheel touches it at `surface`, and the infeed is
towards minus. A position of the wheel is that of its centre along the table, of its face in depth, and of its
edge on the minus side across the table.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from grind_env.control import Position
from grind_env.control.control_settings import ORIGIN, Control
from grind_env.control.motion_paths import displaced
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.message_text import did_you_mean, quoted
from grind_env.process import toml_tables
from grind_env.process.catalogue_parameters import USUAL_HEIGHT, limits_of, rates_of, stroke_parameters
from grind_env.process.cost import NO_LIMIT, Limits, Rates
from grind_env.process.entries import Dresser, Fluid, Machine, Material, Quantity, Wheel
from grind_env.process.force_correction import EXPONENTS, corrected_by, exponents_of
from grind_env.process.process_interface import PROCESS, Process
from grind_env.process.stroke_types import FORCES, StrokeParameters
from grind_env.process.toml_tables import TableError

if TYPE_CHECKING:
    from grind_env.plants import Plant

ByHand: TypeAlias = Literal["by program", "always on"]
"""By program: its words act. Always on: the operator does the work, and the words have no effect."""


WorkOffset: TypeAlias = Literal["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]
"""A work coordinate system of the control."""


PART_AT_STATION = "parts.part says what parts are that lie at stations; say there what differs, and leave it out"
"""Message about parts of other kinds in a job with stations."""


class JobError(TableError):
    """A job that cannot be run."""


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
        toml_tables.check(self, "part.stages", JobError)


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
        toml_tables.check(self, "part", JobError)
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
    offset: WorkOffset | None = None
    origin: Annotated[tuple[float, float, float], Quantity("", "mm", -10_000, 10_000)] = ORIGIN
    part: Part

    def __post_init__(self) -> None:
        toml_tables.check(self, "stations", JobError)
        if not self.name.strip() or not self.name.isprintable():
            raise wrong("stations.name", self.name, "a text of one line that is not empty")
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
class Setup:
    """Wheel, dresser, fluid and machine.

    Attributes:
        wheel: grinding wheel.
        dresser: diamond.
        fluid: coolant.
        machine: machine tool.
        wheel_speed: surface speed of the new wheel.
        constant_surface_speed: whether the control holds `wheel_speed` as the wheel shrinks (12-41).
        spindle: "by program": S, G96 and M03 to M05 start the wheel and set its speed; "always on": the operator sets
            `wheel_speed`, and these words have no effect.
        coolant: "by program": M07 and M08 turn the fluid on and M09 off, and without it the wheel grinds dry; "always
            on": the fluid flows regardless.
        dresser_infeed: infeed of the dresser before each pass, if the dress program has none. Without either, 0.02 mm
            is assumed, with a warning.
        grooving_wheel: whether this wheel grinds the grooves of G76 and G77; otherwise a turning tool cuts them, and
            only the time counts.
    """

    wheel: Wheel
    dresser: Dresser
    fluid: Fluid
    machine: Machine
    wheel_speed: Annotated[float, Quantity("vs", "m/s", 5, 150)] = 30.0
    constant_surface_speed: bool = False
    spindle: ByHand = "by program"
    coolant: ByHand = "by program"
    dresser_infeed: Annotated[float | None, Quantity("ad", "mm", 0.0005, 0.1)] = None
    grooving_wheel: bool = False

    def __post_init__(self) -> None:
        toml_tables.check(self, "setup", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Times:
    """Times that the program does not state.

    Attributes:
        load: time from the end of a part to the first cycle of the next part, travel included.
        gauge: time from an M01, at which the part is gauged, to the next cycle, travel included; none if the table
            keeps moving.
        dress_setup: time of a dress execution in addition to the motions of its program.
        wheel_change: time to replace a wheel that is below its least diameter; the operator does this when the part is
            taken off or gauged. Left out if the worn wheel stays.
    """

    load: Annotated[float, Quantity("t_load", "s", 0, 86_400)] = 20.0
    gauge: Annotated[float, Quantity("t_gauge", "s", 0, 86_400)] = 0.0
    dress_setup: Annotated[float, Quantity("t_d0", "s", 0, 86_400)] = 8.0
    wheel_change: Annotated[float | None, Quantity("", "s", 0, 86_400)] = None

    def __post_init__(self) -> None:
        toml_tables.check(self, "times", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelStart:
    """State of the wheel at the start; None for the value of a new, freshly dressed wheel.

    Attributes:
        diameter: diameter of the wheel.
        wear_flat_area: wear-flat area A, share of the wheel face.
        volume_since_dress: volume V ground since the last dress, per mm of width.
        diamond_flat: width of the wear flat on the dressing diamond.
    """

    diameter: Annotated[float | None, Quantity("ds", "mm", 50, 600)] = None
    wear_flat_area: Annotated[float | None, Quantity("A", "", 1e-4, 0.5)] = None
    volume_since_dress: Annotated[float | None, Quantity("V", "mm3/mm", 0, 1e6)] = None
    diamond_flat: Annotated[float, Quantity("wd", "mm", 0, 2)] = 0.0

    def __post_init__(self) -> None:
        toml_tables.check(self, "wheel", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Diamond:
    """Position of the tip of the dressing diamond on the table, as axis coordinates of the wheel there.

    Its height counts for the touched-off wheel: wheel wear from dresses is compensated as on the part. The wheel comes
    down on the diamond; leave the table out for a diamond above the wheel.

    Attributes:
        x: coordinate of the X axis.
        y: coordinate of the Y axis.
        z: coordinate of the Z axis.
    """

    x: Annotated[float, Quantity("", "mm", -10_000, 10_000)]
    y: Annotated[float, Quantity("", "mm", -10_000, 10_000)]
    z: Annotated[float, Quantity("", "mm", -10_000, 10_000)]

    def __post_init__(self) -> None:
        toml_tables.check(self, "diamond", JobError)

    @property
    def tip(self) -> tuple[float, float, float]:
        """Return the coordinates X, Y and Z of the tip, mm."""
        return self.x, self.y, self.z


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
        toml_tables.check(self, "lots", JobError)


@dataclass(frozen=True, kw_only=True)  # no slots, because cached properties need a `__dict__`
class Job:
    """Part, set-up, times, wheel at the start, and variation of the parts of a batch.

    Without `diamond` every dress program is assumed to meet the diamond. `parts` lists how each part differs from
    `part`; empty if all parts are equal. `stations` lists the parts that lie on the table together; `part` is then the
    part of the first station. A run finds out `part_stations`: the station of each part, in machine coordinates.
    `process` is the grinding process. `own` is its memory besides the wheel when the shift begins, in the units of its
    fields; empty for the defaults of the process. `plant` is the name of the machine (`grind_env.plants`); empty for
    none. `uncertainty` is that of a calibration; None without one. `variables` are start values of `#` variables of the
    control (`Control.variables`), without a unit.
    """

    part: Part
    setup: Setup
    times: Times = field(default_factory=Times)
    wheel: WheelStart = field(default_factory=WheelStart)
    lots: Lots = field(default_factory=Lots)
    diamond: Diamond | None = None
    parts: tuple[PartConditions, ...] = ()
    stations: tuple[Station, ...] = ()
    part_stations: tuple[Station, ...] = ()
    process: Process = PROCESS
    own: tuple[float, ...] = ()
    plant: str = ""
    uncertainty: Uncertainty | None = None
    variables: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        wheel, start = self.setup.wheel, self.wheel
        low, high = wheel.minimum_diameter, wheel.diameter
        if start.diameter is not None and not low <= start.diameter <= high:
            legal = f"from {low:g} to {high:g} mm for {wheel} (its new size: setup.wheel_overrides, diameter)"
            raise wrong("wheel.diameter", start.diameter, legal)
        if start.wear_flat_area is not None and start.wear_flat_area >= wheel.wear_flat_limit:
            legal = f"below {wheel.wear_flat_limit:g} for {wheel}"
            raise wrong("wheel.wear_flat_area", start.wear_flat_area, legal)
        if self.stations:
            self._check_stations()
        self._correct_process()

    def _correct_process(self) -> None:
        others = (*(each.part for each in self.parts if each.part is not None), *(each.part for each in self.stations))
        exponents = exponents_of(self.part.material)
        for part in others:
            if exponents_of(part.material) != exponents:
                raise JobError(
                    f"{self.part.material} and {part.material} are of one job, whose exponents of the power are one, "
                    "but they have different ones; give both the same",
                    "part.material",
                )
        left_open = () if self.uncertainty is None else self.uncertainty.names
        open_ = any(f"material.{each}" in left_open for each in EXPONENTS)
        process, own = corrected_by(self.part.material, self.process, self.own, open_=open_)
        object.__setattr__(self, "process", process)
        object.__setattr__(self, "own", own)

    def _check_stations(self) -> None:
        names, origins = set[str](), dict[str, Position]()
        for each in self.stations:
            if each.name in names:
                raise JobError(f"there are two stations {quoted(each.name)}; name them differently", "stations.name")
            names.add(each.name)
            if each.offset is not None and origins.setdefault(each.offset, each.origin) != each.origin:
                raise JobError(
                    f"station {each.name}: stations.origin is another than that of a station before it with the same "
                    f"offset {each.offset}; give both the same, or another offset",
                    "stations.origin",
                    each.origin,
                )
        if any(each.part is not None for each in self.parts):
            raise JobError(PART_AT_STATION, "parts.part")

    def on(self, plant: "Plant") -> "Job":
        """Return the job on another machine."""
        return replace(self, process=plant.process, own=plant.of_process, plant=plant.name)

    def of_part(self, number: int) -> "Job":
        """Return the job of a part by its number, from 1; parts of other kinds and stations have other jobs."""
        own = self.parts[number - 1].part if number <= len(self.parts) else None
        if own is None and number <= len(self.part_stations):
            own = self.part_stations[number - 1].part
        return self if own is None else self._of_kind(own)

    def at_station(self, number: int, axis: int) -> "Job":
        """Return the job of the part at a station by its number, from 0; the table reciprocates along `axis`."""
        return self._of_kind(self.lying(axis)[number].part)

    def lying(self, axis: int) -> tuple[Station, ...]:
        """Return the stations in machine coordinates, for a table that reciprocates along `axis`."""
        if axis not in self._lying:
            self._lying[axis] = tuple(each.on_machine(axis) for each in self.stations)
        return self._lying[axis]

    def station_of(self, number: int) -> str:
        """Return the name of the station of a part by its number, from 1; empty for a job without stations."""
        return self.part_stations[number - 1].name if number <= len(self.part_stations) else ""

    @cached_property
    def _lying(self) -> dict[int, tuple[Station, ...]]:
        return {}

    def _of_kind(self, part: Part) -> "Job":
        if part == self.part:
            return self
        if part not in self._kinds:
            self._kinds[part] = replace(self, part=part)
        return self._kinds[part]

    @cached_property
    def _kinds(self) -> dict[Part, "Job"]:
        return {}

    @property
    def own_at_start(self) -> tuple[float, ...]:
        """Return the memory of the process besides the wheel at the start of the shift."""
        return self.own or tuple(self.process.own())

    @cached_property
    def parameters(self) -> StrokeParameters:
        """Return the parameters of the process model for the nominal part."""
        setup = self.setup
        return stroke_parameters(
            self.part.material,
            setup.wheel,
            setup.dresser,
            setup.fluid,
            setup.machine,
            wheel_speed=setup.wheel_speed,
            constant_surface_speed=setup.constant_surface_speed,
            width=self.part.width,
            height=USUAL_HEIGHT if self.part.height is None else self.part.height,
        )

    @cached_property
    def rates(self) -> Rates:
        """Return the prices of time, wheel and dresser."""
        return rates_of(self.setup.wheel, self.setup.dresser, self.setup.machine)

    @cached_property
    def limits(self) -> Limits:
        """Return the limits of a good part."""
        return self.limits_at(self.part)

    def limits_at(self, asked: Stage | Part) -> Limits:
        """Return the limits at the end of a stage, or of the part."""
        return limits_of(
            self.part.material,
            self.setup.machine,
            rise_allowance=asked.rise_allowance,
            roughness_limit=asked.roughness_limit,
            tolerance=asked.tolerance,
        )

    @cached_property
    def control(self) -> Control:
        """Return the control of this machine."""
        machine = self.setup.machine
        return Control(
            acceleration=machine.acceleration,
            rapid_feed=machine.rapid_feed,
            reversal_dwell=machine.reversal_dwell,
            variables=self.variables,
            work_offsets={each.offset: each.origin for each in self.stations if each.offset is not None},
        )


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


def wrong(key: str, value: object, legal: str) -> TableError:
    """Return the error for a value that is not legal."""
    return toml_tables.wrong(key, value, legal, JobError)
