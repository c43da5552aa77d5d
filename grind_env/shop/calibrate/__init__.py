"""The process model fitted to what a shop has measured.

From a log of the spindle's power beside its part program, or from a table of settings, to constants with intervals::

    sheet.py        a text as a shop exports it -> cells            columns.py   whose columns are found by their names
    logs.py         -> time and power                               gauge.py     -> what was measured of each part
    pattern.py      where the program's strokes lie in time         align.py     -> where they lie in the log
    meter.py        what its meter makes of the power
    idle.py         power of the idling spindle under each stroke   observe.py   -> mean power of strokes or blocks
    parameters.py   what may be fitted, with its prior              forward.py   the machine under the program, run
    again table.py        settings instead of a log                       fit.py       -> the most probable values,
    intervals
    calibration.py  `calibrate`, from files to the result           result.py    what it finds, as a catalogue file
    show.py         the result on the screen                        remarks.py   and what is to be known beside it
"""
