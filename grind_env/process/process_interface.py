"""The `Process` interface: functions of a grinding process that the machine loops call beside a `CycleKernel`.

The functions are compiled (`kernel.inlined`) and hold conditional expressions only, so that they vectorise. Every
process uses wheel, parameters and stroke result of `process.stroke_types`. All its other memory, of the machine, the
part or the wheel, is in the record `own`.
"""

import functools
from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.process.equations import cooled, part_growth, part_heating
from grind_env.process.stroke_and_dress import dress_wheel, grind_stroke, stroke_constants
from grind_env.process.stroke_types import StrokeConstants, StrokeParameters, StrokeResult, WheelState


class Nothing(NamedTuple):
    """Empty memory of a process that needs only wheel and surface."""


class Moment(NamedTuple):
    """The start of a cycle block."""

    number: float  #: number of cycle blocks before this one in the shift
    seconds: float  #: time since the start of the shift, s
    place: float  #: coordinate of the middle of the part along the table, mm
    E: float  #: commanded table speed, mm/min


class Drive(NamedTuple):
    """True speed and dwell of the table in a cycle block."""

    share: float  #: ratio of the true table speed to the commanded E
    dwell: float  #: dwell at a reversal point, s


class Process(NamedTuple):
    """Compiled functions of wheel, memory (`own`) and the numbers of a stroke, a dress, a block or a wait.

    Times are whole ms: a program run and an episode round times differently, but then get the same bits.
    """

    #: memory besides the wheel: a named tuple type of floats; its defaults hold when a shift begins. A wheel change
    #: does not reset the memory
    own: type[Any]
    #: constants of the strokes of a cycle, made by `constants`: a named tuple type of floats with `stall_time`
    held: type[Any]
    #: `constants(p, speed, length) -> held`, with table speed in mm/s and ground length in mm
    constants: Callable[..., Any]
    #: `stroke(wheel, own, S, Rs, Z, b, held, seconds) -> wheel, own, stroke`, as `stroke_and_dress.grind_stroke`.
    #: `seconds` is the time up to the next stroke, reversal dwell included; `Z` includes the growth of the part
    #: (`grown`). A stroke in the air acts as `idle`. Growth of the machine is subtracted from `wheel.W`, which touching
    #: off and gauging set to 0
    stroke: Callable[..., Any]
    #: `dress(wheel, own, passes, lead, depth, p) -> wheel, own, removed`; as `process.stroke_and_dress.dress_wheel`
    dress: Callable[..., Any]
    #: `idle(wheel, own, p, seconds, loads) -> wheel, own`: effect of a time without a stroke: a dress, a wait, the way
    #: to the next block, or a change of the part (`loads` is true). None for no effect
    idle: Callable[..., Any] | None = None
    #: `before(wheel, own, p, drive, moment) -> wheel, own, p, drive`: called before a cycle block, after the wheel is
    #: touched off or gauged; `drive` has the values of the control. Changes of wheel and own stay; p and drive hold
    #: only in the block. None for no effect
    before: Callable[..., Any] | None = None
    #: `grown(own, held) -> mm`: thermal growth of the part in height. Gauging does not find this growth, because it
    #: measures wheel and part as they are. None for no growth
    grown: Callable[..., Any] | None = None
    #: fields of `own` that belong to the part: a part to which strokes come back gets its own values again, changed by
    #: the time between
    of_part: tuple[str, ...] = ()

    def __reduce__(self) -> Any:
        """Pickle the package's process by name, with the functions compiled there."""
        return "PROCESS" if self is PROCESS else (Process, tuple(self))


class Hook(NamedTuple):
    """A function that is called before every cycle block, with any process."""

    before: Callable[..., Any]  #: `before(wheel, own, p, drive, moment) -> wheel, own, p, drive`, as in `Process`
    own: type[Any] = Nothing  #: memory of the hook: a named tuple type of floats with defaults, as `Process.own`


class PartHeat(NamedTuple):
    """Heat memory of the package's process for the part in work: see `equations.part_slab`."""

    #: part of the slowest mode in the mean temperature above the hall, K; that temperature is the sum of the modes
    dT_1: float = 0.0
    dT_2: float = 0.0
    dT_3: float = 0.0
    dT_4: float = 0.0


with_rises = replacer(None, *PartHeat._fields)


@inlined
def mean_rise(own: Any) -> float:
    """Return the mean temperature of the part above the hall, K."""
    rise: float = own.dT_1 + own.dT_2 + own.dT_3 + own.dT_4
    return rise


@inlined
def _later(own: Any, warmer: float, seconds: float, k: Any, kept: float) -> Any:
    """Return the memory `seconds` after a mean rise by `warmer`, K; `kept` is 0 for a new part, else 1."""
    rises = (
        kept * cooled(own.dT_1 + k.w_1 * warmer, seconds, k.r_1),
        kept * cooled(own.dT_2 + k.w_2 * warmer, seconds, k.r_2),
        kept * cooled(own.dT_3 + k.w_3 * warmer, seconds, k.r_3),
        kept * cooled(own.dT_4 + k.w_4 * warmer, seconds, k.r_4),
    )
    return with_rises(own, rises)


@inlined
def _stroke(
    wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
) -> tuple[WheelState, Any, StrokeResult]:
    wheel, stroke = grind_stroke(wheel, S, Rs, Z, b, k)
    return wheel, _later(own, part_heating(stroke.heat, k.per_vw, k.per_capacity), seconds, k, 1.0), stroke


@inlined
def _dress(
    wheel: WheelState, own: Any, passes: float, lead: float, depth: float, p: StrokeParameters
) -> tuple[WheelState, Any, float]:
    wheel, removed = dress_wheel(wheel, passes, lead, depth, p)
    return wheel, own, removed


@inlined
def _idle(wheel: WheelState, own: Any, p: StrokeParameters, seconds: float, loads: bool) -> tuple[WheelState, Any]:
    return wheel, _later(own, 0.0, seconds, p, 0.0 if loads else 1.0)


@inlined
def _grown(own: Any, k: StrokeConstants) -> float:
    return part_growth(mean_rise(own), k.swell)


#: the process of the package
PROCESS = Process(
    own=PartHeat,
    held=StrokeConstants,
    constants=stroke_constants,
    stroke=_stroke,
    dress=_dress,
    idle=_idle,
    grown=_grown,
    of_part=PartHeat._fields,
)


@functools.cache
def composed(process: Process, *hooks: Hook) -> Process:
    """Return a process with hooks before every block; each hook gets the results of the hook before it."""
    for hook in hooks:
        before = hook.before if process.before is None else _chained(process.before, hook.before)
        process = process._replace(before=before, own=joined(process.own, hook.own))
    return process


def _chained(first: Callable[..., Any], then: Callable[..., Any]) -> Callable[..., Any]:
    @inlined
    def before(wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment) -> Any:
        wheel, own, p, drive = first(wheel, own, p, drive, moment)
        return then(wheel, own, p, drive, moment)

    return before


def joined(*owns: type[Any]) -> type[Any]:
    """Return one memory type with the fields of all `owns`; the functions of each find their fields by name."""
    return _joined(owns)


@functools.cache
def _joined(owns: tuple[type[Any], ...]) -> type[Any]:
    fields = [(name, float(value)) for own in owns for name, value in own()._asdict().items()]
    names = [name for name, _ in fields]
    if len({*names}) < len(names):
        raise ValueError(f"what a process and its hooks remember has names of their own, but here they are {names}")
    return namedtuple("Own", names, defaults=[value for _, value in fields])


HALF = 0.5 + 1e-6  #: half a ms plus more than the rounding error of a sum of times, ms


@inlined
def whole_ms(seconds: float) -> float:
    """Return a time rounded to whole ms, s; see `Process`.

    Half a ms, with which an infeed at F30 and 1 m/s2 ends, rounds up, whatever the rounding error of its sum.
    """
    milliseconds: float = np.floor(1000.0 * seconds + HALF)
    return milliseconds / 1000.0
