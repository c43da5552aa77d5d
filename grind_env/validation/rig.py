"""The test rig: a wheel over a part, with the same process functions as all simulations."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

from grind_env.control import read_file
from grind_env.errors import GrindError
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.kernel import entry
from grind_env.machine.grind import grind
from grind_env.machine.job import Job, Part, Setup
from grind_env.machine.loops.cycle import grown_of
from grind_env.machine.record import GrindingRecord
from grind_env.optional_libraries import needing
from grind_env.process import equations as eq
from grind_env.process.catalogue import Catalogue
from grind_env.process.catalogue_parameters import USUAL_HEIGHT, stroke_parameters
from grind_env.process.entries import Entry, Machine, Wheel, quantities
from grind_env.process.process_interface import PROCESS, PartHeat, whole_ms
from grind_env.process.stroke_and_dress import dress_wheel, dressed_wheel
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState

SHARP = 25  #: number of strokes after a dress at which a wheel is called sharp: the dressed texture has worn in

constants_of, grind_stroke, part_grown = PROCESS.constants, PROCESS.stroke, grown_of(PROCESS)

EntryT = TypeVar("EntryT", bound=Entry)


COLD = PartHeat()  #: heat of a cold part, as it is put on


def crossing(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a rising function passes zero; the nearer end if there is no zero between `low` and `high`."""
    if function(low) >= 0.0 or function(high) <= 0.0:
        return low if function(low) >= 0.0 else high
    with needing("shop", "the validation needs"):
        from scipy.optimize import brentq
    return float(brentq(function, low, high, xtol=1e-14))


class RigError(GrindError):
    """A set-up that this version of the catalogue or of the process cannot make."""


class RigState(NamedTuple):
    """A wheel and a part after some strokes."""

    wheel: WheelState
    S: float  #: stock removed, mm
    Rs: float  #: roughness of the surface, um
    Z: float  #: downfeed position, mm
    worn: float  #: wheel volume worn on this part, mm3
    part: PartHeat  #: heat of the part, as the process remembers it


@entry
def grind_strokes(
    before: RigState, downfeed: float, count: int, vw: float, b: float, Lw: float, p: StrokeParameters, pause: float
) -> tuple[RigState, StrokeResult]:
    """Return wheel and part after `count` strokes (at least one), and the last stroke.

    Each stroke follows a downfeed of `downfeed` mm, and takes `pause` s more than the way over the part.
    """
    constants, seconds = constants_of(p, vw, Lw), whole_ms(Lw / vw + pause)
    wheel, S, Rs, Z, worn, part = before
    for _ in range(count):
        Z += downfeed
        face = Z + part_grown(part, constants)
        wheel, part, done = grind_stroke(wheel, part, S, Rs, face, b, constants, seconds)
        S, Rs, worn = S + done.ae, done.Ra, worn + done.worn
    return RigState(wheel, S, Rs, Z, worn, part), done


@dataclass(frozen=True, slots=True, kw_only=True)
class SetUp:
    """Wheel, material and conditions of a test; names come from the catalogue."""

    material: str = "aisi_52100"
    wheel: str = "a60j"
    dresser: str = "single_point"
    fluid: str = "emulsion"
    wheel_speed: float = 30.0  #: surface speed of the wheel at its new diameter, m/s
    constant_surface_speed: bool = False  #: whether the surface speed is held as the wheel shrinks
    diameter: float = 300.0  #: diameter of the wheel, mm
    table_speed: float = 200.0  #: mm/s
    downfeed: float = 0.010  #: downfeed of each plunge, mm
    width: float = 20.0  #: engaged width, mm
    length: float = 200.0  #: ground length, mm
    height: float = USUAL_HEIGHT  #: height of the part, mm
    pause: float = 0.5  #: time between strokes, off the part, s
    lead: float = 0.10  #: lead of the dress, mm per revolution
    depth: float = 0.020  #: depth of each dress pass, mm
    diamond_flat: float = 0.0  #: wear flat of the diamond, mm
    changes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  #: changed fields, by kind of entry


#: changes of a set-up for a part that does not grow with heat, so that only the elastic loop acts
NO_GROWTH: Mapping[str, Mapping[str, float]] = {"material": {"thermal_expansion": 0.0}}

#: usual conditions, which the conditions of a check do not repeat
CONDITIONS = (
    "Unless a row says otherwise: aisi_52100, a60j, emulsion, default machine, downfeed 10 um, table 12 m/min, wheel "
    "30 m/s and 300 mm, part 200 mm long and 20 mm wide, dressed with single_point, lead .1 mm, depth .02 mm. "
    f"Sharp: {SHARP} strokes after the dress. A is the flat share of the wheel face. Steps are ratios of neighbours."
)


SLACK = 1e-9  #: tolerance of a limit as a share of the limit, for rounding errors of unit conversions


class Violation(NamedTuple):
    """A number of a set-up that is beyond the limit of an entry, and this limit, both in `unit`."""

    what: str
    value: float
    unit: str
    entry: str
    limit: float

    @property
    def excess(self) -> float:
        """Return the excess as a ratio: above 1 if beyond the limit."""
        return max(self.value / self.limit, self.limit / self.value)

    def __str__(self) -> str:
        """Return a text such as `wheel speed 80 m/s (sg60j: at most 35)`."""
        end = "at most" if self.value > self.limit else "at least"
        return f"{self.what} {self.value:.4g} {self.unit} ({self.entry}: {end} {self.limit:g})"


def violations(setup: SetUp, wheel: Wheel, machine: Machine) -> list[Violation]:
    """Return the conditions of a set-up beyond the limits of its wheel and machine."""
    turning = setup.diameter if setup.constant_surface_speed else wheel.diameter
    speed, spindle_speed = setup.wheel_speed, 60_000.0 * setup.wheel_speed / (math.pi * turning)
    most = (
        Violation("wheel speed", speed * setup.diameter / turning, "m/s", wheel.name, wheel.maximum_speed),
        Violation("wheel diameter", setup.diameter, "mm", wheel.name, wheel.diameter),
        Violation("width", setup.width, "mm", wheel.name, wheel.width),
        Violation("spindle speed", spindle_speed, "1/min", machine.name, machine.maximum_spindle_speed),
        Violation("table speed", 0.06 * setup.table_speed, "m/min", machine.name, machine.maximum_table_speed / 1000.0),
    )
    least = Violation("wheel diameter", setup.diameter, "mm", wheel.name, wheel.minimum_diameter)
    found = [each for each in most if each.value > each.limit * (1.0 + SLACK)]
    return found + [least] * (least.value < least.limit * (1.0 - SLACK))


@dataclass(slots=True)
class Grinder:
    """A wheel over a part; each method continues from the state that the last one has left."""

    setup: SetUp
    p: StrokeParameters
    wheel: WheelState
    S: float = 0.0
    Rs: float = eq.INITIAL_ROUGHNESS
    Z: float = 0.0
    worn: float = 0.0
    heat: PartHeat = COLD

    def grind(self, count: int = 1, downfeed: float | None = None) -> StrokeResult:
        """Grind strokes with the downfeed of the set-up, or another, mm; return the last stroke."""
        state = RigState(self.wheel, self.S, self.Rs, self.Z, self.worn, self.heat)
        state, done = self._ground(state, self.setup.downfeed if downfeed is None else downfeed, count)
        self.wheel, self.S, self.Rs, self.Z, self.worn, self.heat = state
        return done

    def grind_volume(self, volume: float) -> StrokeResult:
        """Grind as many strokes as would remove `volume` mm3/mm at the full downfeed; return the last stroke."""
        return self.grind(max(1, round(volume / (self.setup.downfeed * self.setup.length))))

    def trial(self, interference: float) -> StrokeResult:
        """Return the stroke that this wheel would make with an interference, mm; nothing is changed."""
        return self._ground(RigState(self.wheel, 0.0, self.Rs, 0.0, 0.0, COLD), interference + self.wheel.W, 1)[1]

    def cut(self, depth: float) -> StrokeResult:
        """Return the stroke that removes exactly `depth` mm."""
        return self.trial(crossing(lambda u: self.trial(u).ae - depth, 0.0, 100.0 * depth + 1.0))

    def threshold(self) -> StrokeResult:
        """Return the stroke at the threshold of cutting, which removes 1 nm."""
        return self.cut(1e-6)

    def _ground(self, state: RigState, feed: float, count: int) -> tuple[RigState, StrokeResult]:
        setup = self.setup
        return grind_strokes(state, feed, count, setup.table_speed, setup.width, setup.length, self.p, setup.pause)

    def new_part(self) -> None:
        """Touch off on a new part, which is cold."""
        self.S, self.Rs, self.Z, self.worn, self.heat = 0.0, eq.INITIAL_ROUGHNESS, 0.0, 0.0, COLD
        self.wheel = self.wheel._replace(W=0.0)

    def dress(self, passes: float = 2.0) -> float:
        """Dress with the lead and depth of the set-up; return the wheel volume removed, mm3."""
        self.wheel, removed = dress_wheel(self.wheel, passes, self.setup.lead, self.setup.depth, self.p)
        return removed

    def g_ratio(self) -> float:
        """Return the ratio of work volume to wheel volume since the part was put on."""
        return self.S * self.setup.length * self.setup.width / self.worn


@dataclass(frozen=True, slots=True)
class Rig:
    """Maker of grinders from a catalogue; `outside` keeps the conditions of set-ups farthest beyond its limits."""

    catalogue: Catalogue
    outside: dict[tuple[str, str], Violation] = field(default_factory=dict)

    def fresh(self, **setup: Any) -> Grinder:
        """Return a freshly dressed wheel over a new part; arguments as in `SetUp`."""
        chosen = SetUp(**setup)
        p = self.parameters(chosen)
        wheel = dressed_wheel(chosen.diameter, chosen.diamond_flat, chosen.lead, chosen.depth, p)
        return Grinder(chosen, p, wheel)

    def sharp(self, **setup: Any) -> Grinder:
        """Return a wheel over a new part, `SHARP` strokes of the set-up after its dress."""
        grinder = self.fresh(**setup)
        grinder.grind(SHARP)
        grinder.new_part()
        return grinder

    def steady(self, **setup: Any) -> Grinder:
        """Return a freshly dressed wheel over a new part, without loose grains: its wear is steady."""
        return self.fresh(**setup, changes={"wheel": {"initial_wear": 0.0}})

    def dulled(self, flats: float, **setup: Any) -> Grinder:
        """Return a sharp wheel whose wear-flat area is set to `flats`, share of its face."""
        grinder = self.sharp(**setup)
        grinder.wheel = grinder.wheel._replace(A=flats)
        return grinder

    def used(self, volume: float, **setup: Any) -> Grinder:
        """Return a wheel that has ground `volume` mm3/mm since the dress."""
        grinder = self.fresh(**setup)
        grinder.grind_volume(volume)
        return grinder

    def redressed(self, passes: float, **setup: Any) -> Grinder:
        """Return a dull wheel after a dress of some passes, in a set-up changed by some arguments of `SetUp`."""
        grinder = self.with_setup(self.dulled(0.04), **setup)
        grinder.dress(passes)
        return grinder

    def worn_in(self, **setup: Any) -> Grinder:
        """Return a wheel that is sharp in the usual set-up, over a new part in another one."""
        return self.with_setup(self.sharp(), **setup)

    def with_setup(self, grinder: Grinder, **setup: Any) -> Grinder:
        """Return the same wheel over a new part, in a set-up changed by some arguments of `SetUp`."""
        chosen = replace(grinder.setup, **setup)
        return Grinder(chosen, self.parameters(chosen), grinder.wheel._replace(W=0.0))

    def parameters(self, setup: SetUp) -> StrokeParameters:
        """Return the stroke parameters of a set-up; `outside` keeps conditions beyond the catalogue."""
        catalogue, changes = self.catalogue, setup.changes
        wheel = changed(catalogue.wheel(setup.wheel), changes.get("wheel", {}))
        machine = changed(catalogue.machine("default"), changes.get("machine", {}))
        for found in violations(setup, wheel, machine):
            known = self.outside.setdefault((found.entry, found.what), found)
            self.outside[found.entry, found.what] = max(known, found, key=lambda each: each.excess)
        return stroke_parameters(
            changed(catalogue.material(setup.material), changes.get("material", {})),
            wheel,
            changed(catalogue.dresser(setup.dresser), changes.get("dresser", {})),
            changed(catalogue.fluid(setup.fluid), changes.get("fluid", {})),
            machine,
            wheel_speed=setup.wheel_speed,
            constant_surface_speed=setup.constant_surface_speed,
            width=setup.width,
            height=setup.height,
        )


def changed(known: EntryT, values: Mapping[str, Any]) -> EntryT:
    """Return an entry with some fields changed; an unknown field or a value out of range is an error."""
    for name in values:
        if name not in quantities(type(known)):
            raise RigError(f"{known} has no {name}")
    return replace(known, **values)


def grind_plate(rig: Rig, power_limit: float) -> GrindingRecord:
    """Return the record of the example `plate_g82` on the default machine with another power limit, W."""
    machine = changed(rig.catalogue.machine("default"), {"power_limit": power_limit})
    part = Part(material=rig.catalogue.material("aisi_52100"), length=200, width=20, stock=0.2, scrap_cost=40)
    setup = Setup(
        wheel=rig.catalogue.wheel("a60j"),
        dresser=rig.catalogue.dresser("single_point"),
        fluid=rig.catalogue.fluid("emulsion"),
        machine=machine,
    )
    return grind(read_file(EXAMPLES / "plate_g82.nc"), Job(part=part, setup=setup))
