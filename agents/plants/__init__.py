"""Study of calibration, search and adviser on out-of-model machines of all families."""
