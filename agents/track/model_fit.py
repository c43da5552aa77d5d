"""Fit of the model to a log of shifts: the most probable factors on its constants, and exponents of its free term.

An ensemble follows every shift on a model (`grind_env.belief`), as a planner does, and forecasts each reading. Forecast
errors, in standard deviations, are least where the model is the machine (prediction error method: Ljung, System
Identification, chapter 3). Priors hold constants that readings do not determine. Bad parts tell about heat.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.belief.filter_quantities import Belief
from grind_env.envs.simulation import Simulation, with_start_of
from grind_env.plants import Plant
from grind_env.policies.mismatch_alarms import Watch, WatchedReading
from grind_env.policies.scripted.learned_laws import PowerLaw
from grind_env.policies.track import TrackShift
from grind_env.process.force_correction import CORRECTED, CorrectedOwn


class Constant(NamedTuple):
    """Fitted number: a factor on symbols of the process model, or an exponent of the free term."""

    symbols: tuple[str, ...]
    spread: float  #: standard deviation of the prior: of the logarithm of a factor, or of an exponent itself


CONSTANTS = (
    Constant(("u_ch",), 0.2),
    Constant(("kp",), 0.2),
    Constant(("pa", "pb"), 0.2),
    Constant(("kA",), 0.3),
    Constant(("ke",), 0.3),
    Constant(("RaRef",), 0.15),
    Constant(("Gref",), 0.3),
    Constant(("hf",), 0.3),
    Constant(("beta",), 0.1),
    Constant(("corrected_depth",), 0.2),
    Constant(("corrected_speed",), 0.2),
    Constant(("corrected_volume",), 0.1),
)
MISFIT = 4.0  #: factor on the standard deviation of a forecast, because no model equals the machine
CLIPPED = 4.0  #: largest forecast error that counts, in these increased standard deviations
LEAST_CHANCE = 0.01  #: probability that a part is bad, or good, for a reason that the model does not know
SIZED = 0.8  #: share of the tolerance beyond which the size explains a bad part
#: Gauss-Newton search: rounds, finite difference, halvings of a move, and bound, in standard deviations of the prior
ROUNDS, STEP, HALVINGS, FARTHEST = 3, 0.1, 3, 2.5


class Innovations(Watch):
    """Forecast errors of readings, without the corrections that a guard learns."""

    burnt: ClassVar[int] = Belief._fields.index("burnt")

    def _judge(self, seen: WatchedReading) -> None:
        self.seen = seen

    @property
    def off(self) -> Array:
        """Forecast errors in standard deviations, 0 where nothing is read, shape (N, readings)."""
        seen = self.seen
        return np.asarray(np.where(seen.new, (seen.read - seen.forecast) / seen.spread, 0.0))


def changed(model: Simulation, z: Array, *, full: bool = False) -> Simulation:
    """Return the model with constants moved by `z` standard deviations; `full` shows hidden values."""
    made: Any = model
    names = CorrectedOwn._fields
    moved = [(symbol, each.spread * x) for each, x in zip(CONSTANTS, z, strict=True) for symbol in each.symbols]
    exponents, before = {symbol: float(x) for symbol, x in moved if symbol in names}, made.task.factors
    factors = {symbol: before.get(symbol, 1.0) * math.exp(x) for symbol, x in moved if symbol not in names}
    task = replace(made.task, factors={**before, **factors})
    own = CORRECTED.own(**exponents)
    plant = Plant(name="fitted", process=CORRECTED, own=tuple(own))
    held: Simulation = with_start_of(type(made)(task, full=full, process=CORRECTED), plant)
    return held


def residuals(model: Simulation, shifts: Sequence[TrackShift]) -> Array:
    """Return the errors of the model's forecasts of readings and bad parts in the shifts, in one array."""
    watch, nothing = Innovations(model, len(shifts)), PowerLaw(len(shifts))
    seen = np.stack([each.observations for each in shifts], axis=1)
    bad = np.stack([each.bad for each in shifts], axis=1)
    found = []
    for block, observation in enumerate(seen):
        watch.update(observation, nothing)
        if block == 0:
            continue
        off = watch.off / MISFIT
        assert watch.belief is not None
        burnt = np.clip(watch.belief.beliefs[:, watch.burnt], LEAST_CHANCE, 1.0 - LEAST_CHANCE)
        chance = np.where(bad[block - 1], burnt, 1.0 - burnt)
        size, ends = watch.seen.read[:, 2], watch.seen.new[:, 2]
        told = ends & ~(bad[block - 1] & (size > SIZED * watch.seen.limit[:, 2]))
        heat = np.where(told, np.sqrt(-2.0 * np.log(chance)), 0.0)
        found.append(np.column_stack([np.clip(off, -CLIPPED, CLIPPED), heat]))
    return np.asarray(np.array(found).ravel())


def fitted(model: Simulation, shifts: Sequence[TrackShift], start: Array) -> Array:
    """Return the most probable constants, in standard deviations of their priors, by a search from `start`."""
    return least_squares(lambda z: residuals(changed(model, z), shifts), start)


def least_squares(off: Callable[[Array], Array], start: Array) -> Array:
    """Return z with the least sum of squares of `off(z)` and z, by Gauss-Newton with finite differences."""
    z = start.copy()
    here = off(z)
    for _ in range(ROUNDS):
        slopes = np.stack([(off(z + step) - here) / STEP for step in STEP * np.eye(len(z))], axis=1)
        move = -np.linalg.solve(slopes.T @ slopes + np.eye(len(z)), slopes.T @ here + z)
        for halving in range(HALVINGS):
            trial = np.clip(z + 0.5**halving * move, -FARTHEST, FARTHEST)
            there = off(trial)
            if there @ there + trial @ trial < here @ here + z @ z:
                z, here = trial, there
                break
        else:
            break
    return z
