"""The process model fitted to what a shop has measured.

From a log of the spindle's power beside its part program, or from a table of settings, to constants with intervals:

| module | what it does |
| --- | --- |
| `columns.py` | finds the columns of a measured file (`shop/measurements`) by their names |
| `logs.py`, `gauge.py` | time and power of a log; what was measured of each part |
| `pattern.py`, `align.py`, `alignment.py` | where the strokes of the program lie in time, and where in the log |
| `likeness.py` | how like the log is to them there, beside what lies around, as the meter shows it |
| `idle.py`, `meter.py` | power of the idling spindle under each stroke; the lag of the meter |
| `observe.py` | mean power of strokes or blocks |
| `table.py` | settings instead of a log |
| `parameters.py` | what may be fitted, with its prior |
| `forward.py` | the machine under the program, run again |
| `solver.py`, `fit.py`, `width.py` | the most probable values, their intervals, and how much of the free term is used |
| `verdict.py` | whether the fit may be used, and for what |
| `calibration.py` | `calibrate`, from files to the result |
| `uncertain.py`, `plan.py` | what is left open, and a program whose log tells more |
| `result.py`, `show.py`, `remarks.py` | the result as a catalogue file, on the screen, and what is to be known of it |
"""
