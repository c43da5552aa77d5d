"""Fit the process model to a shop's measurements.

Input: a log of the spindle's power with its part program, or a table of settings. Result: constants with intervals.

| module | what it does |
| --- | --- |
| `columns.py` | finds the columns of a measured file (`shop/measurements`) by their names |
| `logs.py`, `gauge.py` | time and power of a log; measurements of each part |
| `pattern.py`, `align.py`, `alignment.py` | times of the strokes in the program, and their places in the log |
| `observe.py` | mean power of strokes or blocks above the power of the idling spindle |
| `table.py` | settings instead of a log |
| `parameters.py` | constants that may be fitted, with their priors |
| `solver.py`, `fit.py` | most probable values, their intervals, use of the free term, and the residual |
| `verdict.py` | whether the fit may be used, and for what |
| `calibration.py` | `calibrate`, from files to the result |
| `plan.py` | a program whose log determines more constants |
| `result.py`, `show.py` | the result as a catalogue file, and on the screen |
"""
