"""The `Process` interface of the machine loops, used beside a `CycleKernel`.

Its functions are compiled (`kernel.inlined`), and hold conditional expressions only, so that they vectorise. Wheel,
parameters and stroke are those of `process.state`, whatever the process; all else that it remembers, of the machine, of
the part or of the wheel, is its `own`.
"""

import functools
from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.kernel import inlined
from grind_env.kernel.columns import replacer
from grind_env.process.equations import cooled, part_growth, part_heating
from grind_env.process.state import StrokeConstants, StrokeParameters, StrokeResult, WheelState
from grind_env.process.stroke import dress_wheel, grind_stroke, stroke_constants


class Nothing(NamedTuple):
    """Empty memory of a process that needs only wheel and surface."""


class Moment(NamedTuple):
    """A cycle block that is about to begin."""

    number: float
    """Number of them before it in the shift."""
    seconds: float
    """Seconds of the shift, s."""
    place: float
    """Coordinate of the middle of the part along the table, mm."""
    E: float
    """Commanded, mm/min."""


class Drive(NamedTuple):
    """True speed and dwell of the table in a cycle block."""

    share: float
    """Share of every commanded E that it reaches."""
    dwell: float
    """At a reversal point, s."""


class Process(NamedTuple):
    """Functions of wheel, own, and the numbers of a stroke, a dress, a block or a while.

    Times are whole ms, so that program and episode, which round differently, get the same bits.
    """

    own: type[Any]
    """A named tuple of floats with defaults: what it remembers besides, as a shift begins. Wheel changes leave it."""
    held: type[Any]
    """What strokes of a cycle have in common, a named tuple of floats with `stall_time`: what `constants` gives."""
    constants: Callable[..., Any]
    """`constants(p, speed, length) -> held`, with table speed in mm/s and ground length in mm."""
    stroke: Callable[..., Any]
    """`stroke(wheel, own, S, Rs, Z, b, held, seconds) -> wheel, own, stroke`; as `process.stroke.grind_stroke`, with
    the time up to the next one, reversal dwell included; in `Z` is what the part has `grown`. Where the wheel meets
    nothing, a stroke does what `idle` does. What the machine grows by, it takes off `wheel.W`: touching off and gauging
    set that to 0."""
    dress: Callable[..., Any]
    """`dress(wheel, own, passes, lead, depth, p) -> wheel, own, removed`; as `process.stroke.dress_wheel`."""
    idle: Callable[..., Any] | None = None
    """`idle(wheel, own, p, seconds, loads) -> wheel, own`: what a while without a stroke does: a dress, a wait, the way
    to the next block, or a change of the part, which `loads`. None for nothing."""
    before: Callable[..., Any] | None = None
    """`before(wheel, own, p, drive, moment) -> wheel, own, p, drive`: before a cycle block, once the wheel has been
    touched off or gauged; `drive` as the control has it. Wheel and own stay changed, p and drive hold in the block.
    None for nothing."""
    grown: Callable[..., Any] | None = None
    """`grown(own, held) -> mm`: by how much the part stands higher than when it was cold, which gauging does not see,
    for it finds wheel and part as they are. None for nothing."""
    of_part: tuple[str, ...] = ()
    """What of `own` goes with the part: where strokes come back to one, it is what that one has come to meanwhile."""

    def __reduce__(self) -> Any:
        """Pickle the package's process by name, with the functions compiled there."""
        return "PROCESS" if self is PROCESS else (Process, tuple(self))


class Hook(NamedTuple):
    """Something that happens before every cycle block, whatever grinds in it."""

    before: Callable[..., Any]
    """As in `Process`."""
    own: type[Any] = Nothing
    """What it remembers, as of `Process`."""


class PartHeat(NamedTuple):
    """Heat memory of the package's process for the part in work: see `equations.slab`."""

    dT_1: float = 0.0
    """What the slowest mode has of the mean temperature above the hall, K; the modes add up to that."""
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
    """Return what is remembered a while after heat for so many K came in; of a part taken off, 0 is `kept`."""
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
"""That of the package."""


@functools.cache
def composed(process: Process, *hooks: Hook) -> Process:
    """Return a process with hooks before every block, one after the other, each with what those before have changed."""
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
    """Return the record of all that some of them remember; functions of one find its fields in it by their names."""
    return _joined(owns)


@functools.cache
def _joined(owns: tuple[type[Any], ...]) -> type[Any]:
    fields = [(name, float(value)) for own in owns for name, value in own()._asdict().items()]
    names = [name for name, _ in fields]
    if len({*names}) < len(names):
        raise ValueError(f"what a process and its hooks remember has names of their own, but here they are {names}")
    return namedtuple("Own", names, defaults=[value for _, value in fields])


HALF = 0.5 + 1e-6
"""ms; by more than sums of times round."""


@inlined
def whole_ms(seconds: float) -> float:
    """Return a time rounded to whole ms, s; see `Process`.

    Half a ms, in which an infeed at F30 under 1 m/s2 ends, is a whole one, from whatever sum it comes.
    """
    milliseconds: float = np.floor(1000.0 * seconds + HALF)
    return milliseconds / 1000.0
