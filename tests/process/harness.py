"""Grinder for experiments: one wheel over one part, driven stroke by stroke."""

from dataclasses import dataclass, field

from grind_env.process.catalogue import load_catalogue
from grind_env.process.catalogue_parameters import stroke_parameters
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.process_interface import PROCESS, PartHeat
from grind_env.process.stroke_and_dress import dress_wheel, dressed_wheel, grind_stroke, stroke_constants
from grind_env.process.stroke_types import StrokeConstants, StrokeParameters, StrokeResult, WheelState

CATALOGUE = load_catalogue()
INSULATED = dict.fromkeys(("r_1", "r_2", "r_3", "r_4"), 0.0)  #: parameters of a part that keeps its heat


def parameters(
    material: str = "aisi_52100",
    wheel: str = "a60j",
    wheel_speed: float = 30.0,
    *,
    fluid: str = "emulsion",
    dresser: str = "single_point",
    constant_surface_speed: bool = False,
    **changes: float,
) -> StrokeParameters:
    nominal = stroke_parameters(
        CATALOGUE.material(material),
        CATALOGUE.wheel(wheel),
        CATALOGUE.dresser(dresser),
        CATALOGUE.fluid(fluid),
        CATALOGUE.machine("default"),
        wheel_speed=wheel_speed,
        constant_surface_speed=constant_surface_speed,
        width=20.0,
        height=20.0,
    )
    return nominal._replace(**changes)


@dataclass
class Grinder:
    """Grinder with part and wheel of the reference cases; table speed m/min, depths and lengths mm."""

    p: StrokeParameters
    table_speed: float
    wheel: WheelState
    width: float = 20.0
    length: float = 200.0
    Z: float = 0.0
    S: float = 0.0
    Rs: float = INITIAL_ROUGHNESS

    @property
    def speed(self) -> float:
        return self.table_speed / 0.06

    @property
    def constants(self) -> StrokeConstants:
        return stroke_constants(self.p, self.speed, self.length)

    def new_part(self) -> None:
        """Touch off on the next part."""
        self.Z, self.S, self.Rs = 0.0, 0.0, INITIAL_ROUGHNESS
        self.wheel = self.wheel._replace(W=0.0)

    def stroke(self, downfeed: float = 0.0) -> StrokeResult:
        self.Z += downfeed
        self.wheel, stroke = grind_stroke(self.wheel, self.S, self.Rs, self.Z, self.width, self.constants)
        self.S += stroke.ae
        self.Rs = stroke.Ra
        return stroke

    def strokes(self, count: int, downfeed: float = 0.0) -> list[StrokeResult]:
        return [self.stroke(downfeed) for _ in range(count)]

    def dress(self, passes: float = 2.0, lead: float = 0.10, depth: float = 0.020) -> float:
        """Dress once and return the removed wheel volume, mm3."""
        self.wheel, removed = dress_wheel(self.wheel, passes, lead, depth, self.p)
        return removed


def grinder(
    p: StrokeParameters,
    table_speed: float = 12.0,
    *,
    width: float = 20.0,
    diameter: float = 300.0,
    lead: float = 0.10,
    depth: float = 0.020,
    **state: float,
) -> Grinder:
    """Return a grinder with a freshly dressed wheel; `state` overrides fields of the wheel."""
    wheel = dressed_wheel(diameter, 0.0, lead, depth, p)._replace(**state)
    return Grinder(p, table_speed, wheel, width)


@dataclass
class WarmGrinder(Grinder):
    """Grinder with a part that warms up, grows and cools, by the process that the loops run."""

    own: PartHeat = field(default_factory=PartHeat)

    @property
    def grown(self) -> float:
        """Height by which the warm part has grown, mm."""
        return float(PROCESS.grown(self.own, self.constants))

    def stroke(self, downfeed: float = 0.0, seconds: float = 1.8) -> StrokeResult:
        self.Z += downfeed
        self.wheel, self.own, stroke = PROCESS.stroke(
            self.wheel, self.own, self.S, self.Rs, self.Z + self.grown, self.width, self.constants, seconds
        )
        self.S += stroke.ae
        self.Rs = stroke.Ra
        return stroke

    def wait(self, seconds: float) -> None:
        self.wheel, self.own = PROCESS.idle(self.wheel, self.own, self.p, seconds, False)

    def load(self) -> None:
        """Touch off on the next part, which is as warm as the hall."""
        self.wheel, self.own = PROCESS.idle(self.wheel, self.own, self.p, 20.0, True)
        self.new_part()


def warm_grinder(p: StrokeParameters, table_speed: float = 12.0, **state: float) -> WarmGrinder:
    """Return a grinder with a part that begins at the temperature of the hall."""
    return WarmGrinder(p, table_speed, grinder(p, table_speed, **state).wheel)


def cut(depth: float, at: Grinder) -> StrokeResult:
    """Return the stroke that removes exactly `depth` mm; bisection finds its interference."""
    low, high = 0.0, 100.0 * depth + 10.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        _, stroke = grind_stroke(at.wheel, 0.0, at.Rs, middle, at.width, at.constants)
        low, high = (middle, high) if stroke.ae < depth else (low, middle)
    return stroke
