"""The system variables: positions, coordinate offsets and the radius table (numbers as usual, D).

Lengths are in the units in force, X as set by G07 or G08. Values of the wheel radius, or of an axis led by cycles,
depend on the wheel: `SystemVariables.dependent` is the first such variable read.
"""

from decimal import Decimal

from grind_env.control.control_settings import WHEEL_RADIUS
from grind_env.control.events import placed
from grind_env.control.macro_formulas import VariableFault, rounded
from grind_env.control.macro_variables import KINDS
from grind_env.control.modes import WORK_SYSTEMS
from grind_env.control.motion_paths import AXES, displaced
from grind_env.control.move_execution import Mover
from grind_env.control.numbers import MILLIMETRES_PER_INCH

RADII = range(2001, 2100)  #: variables of the radius table from entry 1; #2033 is the radius of the wheel
PROGRAM_ENDS, MACHINE, PRESENT = 5001, 5021, 5041
EXTERNAL, FIRST_SYSTEM, SYSTEM_STEP = 5201, 5221, 20

NONE_SUCH = (
    f"{KINDS}, #2001 to #2099 the radius table, #3000 the alarm, #5001 to #5003, #5021 to #5023 and #5041 to #5043 "
    "positions and #5201 to #5383 coordinate offsets"
)


class SystemVariables:
    """System variables of one execution."""

    def __init__(self, mover: Mover) -> None:
        self.mover = mover
        self.dependent: int | None = None  # first variable read that depends on the wheel or the end of a cycle

    def read(self, number: int) -> Decimal:
        mover = self.mover
        if number in RADII:
            entry = number - RADII[0] + 1
            if entry == WHEEL_RADIUS:
                self.dependent = self.dependent or number
            return self._shown(mover.tooling.radius_of(entry), None)
        if (offset := _offset(number)) is not None:
            system, axis = offset
            return self._shown((mover.work.external if system is None else mover.work.offsets[system])[axis], axis)
        origin = mover.work.origin(mover.modes.work_system)
        for first, position, zero in (
            (PROGRAM_ENDS, mover.position, origin),
            (MACHINE, mover.timeline.position, (0.0, 0.0, 0.0)),
            (PRESENT, mover.timeline.position, origin),
        ):
            axis = number - first
            if 0 <= axis < len(AXES):
                if axis in mover.timeline.led_by_cycles:
                    self.dependent = self.dependent or number
                return self._shown(displaced(position[axis], -zero[axis]), axis)
        raise VariableFault(f"#{number} is no variable that can be read here; {NONE_SUCH}")

    def write(self, number: int, value: Decimal) -> None:
        work = self.mover.work
        if number in RADII:
            self.mover.tooling.radii[number - RADII[0] + 1] = float(value * self._unit(None))
        elif (offset := _offset(number)) is not None:
            system, axis = offset
            changed = {axis: float(value * self._unit(axis))}
            if system is None:
                work.external = placed(work.external, changed)
            else:
                work.offsets[system] = placed(work.offsets[system], changed)
        else:
            raise VariableFault(f"#{number} is no variable that can be assigned; {NONE_SUCH}")

    def _shown(self, mm: float, axis: int | None) -> Decimal:
        return rounded(Decimal(repr(mm)) / self._unit(axis))

    def _unit(self, axis: int | None) -> Decimal:
        modes = self.mover.modes
        unit = MILLIMETRES_PER_INCH if modes.inch else Decimal(1)
        return unit / 2 if modes.diameter and axis == 0 else unit


def _offset(number: int) -> tuple[str | None, int] | None:
    """Return work system (None for the external offset) and axis of an offset's number; None for other numbers."""
    if 0 <= (axis := number - EXTERNAL) < len(AXES):
        return None, axis
    system, axis = divmod(number - FIRST_SYSTEM, SYSTEM_STEP)
    return (WORK_SYSTEMS[system], axis) if 0 <= system < len(WORK_SYSTEMS) and axis < len(AXES) else None
