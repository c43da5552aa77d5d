"""Errors of a calibration."""

from grind_env.errors import GrindError


class CalibrationError(GrindError):
    """Log, gauge file, map or choice of parameters from which nothing can be fitted."""


class WorseFit(CalibrationError):
    """Fit that predicts held-out measurements worse than the catalogue does."""

    status = 3
