"""Shop tools for a user's program, job and log: optimise, sweep, calibrate, advise, report.

The package builds on policies and machine; libraries of the extra `[shop]` are imported where they are used.
"""
