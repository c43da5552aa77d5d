"""Shop tools for a user's program, job and log: optimise, sweep, calibrate, advise, report.

Stands on policies and machine, below the command line; libraries of the extra `[shop]` are imported where used.
"""
