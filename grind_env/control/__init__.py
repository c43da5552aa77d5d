"""The 9/Series control: part-program text in, a stream of motions, cycles and dresses out; no physics."""

from grind_env.control.check import Report, check
from grind_env.control.control import Control
from grind_env.control.errors import ControlError
from grind_env.control.execution import Execution, dress_program_moves, execute
from grind_env.control.motions import (
    Arc,
    CycleAhead,
    CycleEnd,
    CyclePlan,
    CycleStart,
    CycleStrokes,
    DressEnd,
    DressStart,
    Dwell,
    Event,
    Hold,
    Infeed,
    InterruptEnd,
    InterruptStart,
    Line,
    Message,
    Motion,
    Pick,
    Position,
    ProgramEnd,
    ProgramStop,
    Rapid,
    Source,
    Spindle,
    Stroke,
)
from grind_env.control.numbers import NumberFormat
from grind_env.control.operator import Interrupt
from grind_env.control.reader import Programs, read, read_file
from grind_env.control.trace import error_record, record

__all__ = [
    "Arc",
    "Control",
    "ControlError",
    "CycleAhead",
    "CycleEnd",
    "CyclePlan",
    "CycleStart",
    "CycleStrokes",
    "DressEnd",
    "DressStart",
    "Dwell",
    "Event",
    "Execution",
    "Hold",
    "Infeed",
    "Interrupt",
    "InterruptEnd",
    "InterruptStart",
    "Line",
    "Message",
    "Motion",
    "NumberFormat",
    "Pick",
    "Position",
    "ProgramEnd",
    "ProgramStop",
    "Programs",
    "Rapid",
    "Report",
    "Source",
    "Spindle",
    "Stroke",
    "check",
    "dress_program_moves",
    "error_record",
    "execute",
    "read",
    "read_file",
    "record",
]
