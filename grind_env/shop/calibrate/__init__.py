"""Fit the process model to a shop's measurements.

From a log of the spindle's power beside its part program, or from a table of settings, to constants with intervals:

| module | what it does |
| --- | --- |
| `columns.py` | finds the columns of a measured file (`shop/measurements`) by their names |
| `logs.py`, `gauge.py` | time and power of a log; what was measured of each part |
| `pattern.py`, `align.py`, `alignment.py` | where the strokes of the program lie in time, and where in the log |
| `observe.py` | mean power of strokes or blocks above that of the idling spindle |
| `table.py` | settings instead of a log |
| `parameters.py` | what may be fitted, with its prior |
| `solver.py`, `fit.py` | the most probable values, their intervals, the use of the free term, and what is left open |
| `verdict.py` | whether the fit may be used, and for what |
| `calibration.py` | `calibrate`, from files to the result |
| `plan.py` | a program whose log tells more |
| `result.py`, `show.py` | the result as a catalogue file, and on the screen |
"""
