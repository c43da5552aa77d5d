"""Changes of the rows of machines between cycles: time passes, and the next block begins."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.array_types import Array
from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.loops.cycle import idle_of
from grind_env.machine.loops.row_io import OWN_FROM, read_parameters, read_wheel, write_parameters, write_wheel
from grind_env.process.process_interface import Drive, Moment, Process, whole_ms


class Shift(NamedTuple):
    """Compiled functions for machine i: row i of `wheels`, with the memory of the process, and of `parameters`."""

    #: `pass_time(wheels, parameters, i, seconds, loads)`: let `seconds` pass without a stroke, as `Process.idle`
    pass_time: Callable[..., None]
    #: `before(wheels, parameters, i, dwell, moment) -> Drive`: begin a cycle block, as `Process.before`; `dwell` is the
    #: reversal dwell of the control, s
    before: Callable[..., Drive]


@functools.cache
def shift_of(process: Process) -> Shift:
    """Return the compiled functions of a process between cycles; functions that it lacks read and write nothing."""
    read_own, write_own = column_reader(process.own, OWN_FROM), column_writer(process.own, OWN_FROM)
    idle, process_before = idle_of(process), process.before

    @inlined
    def pass_time(wheels: Array, parameters: Array, i: int, seconds: float, loads: bool) -> None:
        wheel, own, p = read_wheel(wheels, i), read_own(wheels, i), read_parameters(parameters, i)
        wheel, own = idle(wheel, own, p, seconds, loads)
        write_wheel(wheels, i, wheel)
        write_own(wheels, i, own)

    if process_before is None:
        return Shift(_nothing if process.idle is None else pass_time, _as_commanded)

    @inlined
    def before(wheels: Array, parameters: Array, i: int, dwell: float, moment: Moment) -> Any:
        moment = Moment(number=moment.number, seconds=whole_ms(moment.seconds), place=moment.place, E=moment.E)
        drive = Drive(share=1.0, dwell=dwell)
        wheel, own, p = read_wheel(wheels, i), read_own(wheels, i), read_parameters(parameters, i)
        wheel, own, p, drive = process_before(wheel, own, p, drive, moment)
        write_wheel(wheels, i, wheel)
        write_own(wheels, i, own)
        write_parameters(parameters, i, p)
        return drive

    return Shift(_nothing if process.idle is None else pass_time, before)


@functools.cache
def entries_of(process: Process) -> Shift:
    """Return the functions of `shift_of` as entries that Python calls."""
    pass_time, before = shift_of(process)

    @entry
    def pass_time_of(wheels: Array, parameters: Array, i: int, seconds: float, loads: bool) -> None:
        pass_time(wheels, parameters, i, seconds, loads)

    @entry
    def before_of(wheels: Array, parameters: Array, i: int, dwell: float, moment: Moment) -> Drive:
        return before(wheels, parameters, i, dwell, moment)

    return Shift(pass_time_of, before_of)


@inlined
def _nothing(wheels: Any, parameters: Any, i: int, seconds: float, loads: bool) -> None:
    pass


@inlined
def _as_commanded(wheels: Any, parameters: Any, i: int, dwell: float, moment: Moment) -> Drive:
    return Drive(share=1.0, dwell=dwell)
