"""Compiled functions of the process and all their callees in plain Python: few strokes run without compiling."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import CellType, FunctionType, ModuleType, SimpleNamespace
from typing import Any

from grind_env.plants import Plant
from grind_env.process.process_interface import Drive, Moment
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState
from tests.process.harness import grinder, parameters

_WRITTEN: dict[int, tuple[Any, Any]] = {}


def written(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function and all its callees in plain Python."""
    plain = getattr(function, "py_func", None)
    if plain is None:
        return function
    if id(plain) not in _WRITTEN:
        cells = tuple(CellType(_plain(cell.cell_contents)) for cell in plain.__closure__ or ())
        made = FunctionType(plain.__code__, {}, plain.__name__, plain.__defaults__, cells)
        _WRITTEN[id(plain)] = plain, made
        names = {name: plain.__globals__[name] for name in plain.__code__.co_names if name in plain.__globals__}
        made.__globals__.update({name: _plain(value) for name, value in names.items()})
    return _WRITTEN[id(plain)][1]


def _plain(value: Any) -> Any:
    if isinstance(value, ModuleType) and value.__name__.startswith("grind_env"):
        return SimpleNamespace(**{name: written(each) for name, each in vars(value).items()})
    return written(value)


@dataclass
class Shop:
    """Machine with one part, driven stroke by stroke in plain Python; mm, s, table speed in m/min."""

    plant: Plant
    p: StrokeParameters = field(default_factory=parameters)
    table_speed: float = 12.0
    width: float = 20.0
    length: float = 200.0
    Z: float = 0.0
    S: float = 0.0
    Rs: float = 1.6

    def __post_init__(self) -> None:
        self.wheel: WheelState = grinder(self.p).wheel
        self.own = self.plant.remembers(*self.plant.own)
        self.drive = Drive(share=1.0, dwell=0.15)

    def stroke(self, downfeed: float = 0.0) -> StrokeResult:
        process = self.plant.process
        k = written(process.constants)(self.p, self.table_speed / 0.06, self.length)
        self.Z += downfeed
        grind = written(process.stroke)
        self.wheel, self.own, done = grind(self.wheel, self.own, self.S, self.Rs, self.Z, self.width, k, 2.0)
        self.S += done.ae
        self.Rs = done.Ra
        return done

    def strokes(self, count: int, downfeed: float) -> list[StrokeResult]:
        return [self.stroke(downfeed) for _ in range(count)]

    def dress(self) -> None:
        dress = written(self.plant.process.dress)
        self.wheel, self.own, _ = dress(self.wheel, self.own, 2.0, 0.1, 0.02, self.p)

    def begin(self, number: int = 0, seconds: float = 0.0, place: float = 0.0, E: float = 12_000.0) -> StrokeParameters:
        """Begin a block and return its stroke parameters."""
        if self.plant.process.before is None:
            return self.p
        moment = Moment(number=float(number), seconds=seconds, place=place, E=E)
        before = written(self.plant.process.before)
        self.wheel, self.own, p, self.drive = before(self.wheel, self.own, self.p, Drive(1.0, 0.15), moment)
        return p
