"""Errors of a calibration."""

from grind_env.errors import GrindError


class CalibrationError(GrindError):
    """A log, gauge file, map or choice of parameters from which nothing can be fitted."""


class WorseFit(CalibrationError):
    """A fit that predicts what took no part worse than the catalogue does."""

    status = 3
