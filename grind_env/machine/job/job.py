"""The job: a part with the limits of a good one, on a machine with its set-up."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

from grind_env.control import Position
from grind_env.control.control_settings import Control
from grind_env.machine.job.errors import JobError
from grind_env.machine.job.machine_setup import Diamond, Setup, Times, WheelStart
from grind_env.machine.job.parts import Lots, Part, PartConditions, Stage, Station
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.message_text import quoted
from grind_env.process.catalogue_parameters import USUAL_HEIGHT, limits_of, rates_of, stroke_parameters
from grind_env.process.cost import Limits, Rates
from grind_env.process.force_correction import EXPONENTS, corrected_by, exponents_of
from grind_env.process.process_interface import PROCESS, Process
from grind_env.process.stroke_types import StrokeParameters
from grind_env.process.toml_tables import wrong

if TYPE_CHECKING:
    from grind_env.plants import Plant

#: message about parts of other kinds in a job with stations
PART_AT_STATION = "parts.part says what parts are that lie at stations; say there what differs, and leave it out"


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
            raise wrong("wheel.diameter", start.diameter, legal, JobError)
        if start.wear_flat_area is not None and start.wear_flat_area >= wheel.wear_flat_limit:
            legal = f"below {wheel.wear_flat_limit:g} for {wheel}"
            raise wrong("wheel.wear_flat_area", start.wear_flat_area, legal, JobError)
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
