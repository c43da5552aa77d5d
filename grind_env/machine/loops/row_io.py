"""Read and write the records of a machine in kernels: a record is a row of a table, a field a column."""

from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.loops.cycle import PartState, Stroking, Zone
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.process.stroke_types import StrokeParameters, WheelState

read_stroking, write_stroking = column_reader(Stroking), column_writer(Stroking)
read_parameters, write_parameters = column_reader(StrokeParameters), column_writer(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_tally, write_tally = column_reader(Tally), column_writer(Tally)
read_zone, write_zone = column_reader(Zone), column_writer(Zone)


RULES_FROM = len(Stroking._fields)  #: first column of the numbers of its rules in the row of a cycle

OWN_FROM = len(WheelState._fields)  #: first column of the memory of the process (`own`) in the row of a wheel
