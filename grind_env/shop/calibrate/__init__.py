"""Fit the process model to a shop's measurements.

Input: a log of the spindle's power with its part program, or a table of settings. Result: constants with intervals.

| module | what it does |
| --- | --- |
| `column_names.py` | finds the columns of a measured file (`shop/measurements`) by their names |
| `power_logs.py`, `gauged_parts.py` | time and power of a log; measurements of each part |
| `stroke_schedule.py`, `stroke_matching.py`, `log_alignment.py` | strokes of the program, and their places in the log |
| `stroke_power.py` | mean power of strokes or blocks above the power of the idling spindle |
| `table_calibration.py` | settings instead of a log |
| `fitted_constants.py` | constants that may be fitted, with their priors |
| `least_squares.py`, `fit.py` | most probable values, their intervals, use of the free term, and the residual |
| `verdict.py` | whether the fit may be used, and for what |
| `log_calibration.py` | `calibrate`, from files to the result |
| `experiment_program.py` | a program whose log determines more constants |
| `result.py`, `calibration_output.py` | the result as a catalogue file, and on the screen |
"""
