"""Which alignment is right: the one that the model can agree with best."""

import itertools
import math

import numpy as np

from grind_env.control import Programs
from grind_env.machine.job import Job
from grind_env.machine.job.entries import with_entries
from grind_env.shop.calibrate.alignment import Alignment
from grind_env.shop.calibrate.forward import Forward, powers
from grind_env.shop.calibrate.likeness import shifted
from grind_env.shop.calibrate.logs import Log
from grind_env.shop.calibrate.observe import DISCREPANCY, observe
from grind_env.shop.calibrate.parameters import Parameter
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.calibrate.sheet import Floats
from grind_env.shop.calibrate.solver import changes_of

LINEAR_STEP = 0.5
"""Spreads of the prior over which the effect of a constant is taken to be linear."""
CLEARLY = 0.8
"""Of the misfit of a place: what another one must have to be preferred."""


def best_place(
    log: Log,
    pattern: Pattern,
    expected: Floats,
    found: Alignment,
    job: Job,
    programs: Programs,
    parameters: tuple[Parameter, ...],
) -> Alignment:
    """The alignment that the model can agree with best, among those in which a run begins a stroke sooner or later.

    With constants of the catalogue a run may look more like the log one stroke beside its place. What other constants
    do is taken to be linear.
    """
    forward = Forward(programs, job, found.executions, found.overrides(pattern))
    nominal = powers(forward.run(job))
    moved = [
        powers(forward.run(with_entries(job, changes_of((each,), np.array([LINEAR_STEP]))))) for each in parameters
    ]
    slopes = np.column_stack([nominal, *((each - nominal) / LINEAR_STEP for each in moved)])

    def misfit(place: Alignment) -> float:
        seen = observe(log, pattern, place, found.sure)  # a place is no better because it has fewer runs
        observed = seen.weights @ slopes
        scale = float(observed[:, 0] @ seen.power / (observed[:, 0] @ observed[:, 0])) if not log.known_scale else 1.0
        error = np.hypot(seen.error / scale, DISCREPANCY * np.abs(observed[:, 0]).max())[:, None]
        columns = np.column_stack([log.scale_spread * observed[:, 0], observed[:, 1:]]) / error
        rest = (seen.power / scale - observed[:, 0]) / error[:, 0]
        count = columns.shape[1]
        z = np.linalg.solve(columns.T @ columns + np.eye(count), columns.T @ rest)
        return float((np.square(rest - columns @ z).sum() + z @ z) / rest.size)

    best, least = found, misfit(found)
    for run, strokes in itertools.product(range(pattern.runs), (-1, 1)):
        other = shifted(found, log, pattern, expected, run, strokes)
        value = math.inf if other is None else misfit(other)
        if other is not None and value < CLEARLY * least:
            best, least = other, value
    return best
