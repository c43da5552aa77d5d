"""How kernels read and write the records of a machine: each a row of a table, one field a column."""

from typing import Any

from numpy.typing import NDArray

from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.cycle import Cycle, PartState
from grind_env.machine.tally import Tally
from grind_env.process.state import Stroke, StrokeParameters, WheelState

Table = NDArray[Any]
"""One row a machine."""

read_cycle, write_cycle = column_reader(Cycle), column_writer(Cycle)
read_parameters = column_reader(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_tally, write_tally = column_reader(Tally), column_writer(Tally)
write_stroke = column_writer(Stroke)
