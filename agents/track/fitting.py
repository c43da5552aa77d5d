"""The model as a log of shifts has it: factors on its constants and the free term, most probable by what was forecast.

An ensemble follows every shift on a model (`grind_env.belief`), as a planner does, and forecasts each reading before
it comes. What readings are off by, in standard deviations, is least where the model is the machine (prediction error
method: Ljung, System Identification, chapter 3); priors hold what readings do not tell. Whether parts are found to be
bad tells of heat.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from grind_env.arrays import Array
from grind_env.belief.hidden import Belief
from grind_env.envs.simulation import Simulation, with_start_of
from grind_env.plants import Plant
from grind_env.policies.scripted.learned_laws import PowerLaw
from grind_env.policies.track import TrackShift
from grind_env.policies.watch import Watch, WatchedReading
from grind_env.process.corrected import CORRECTED, CorrectedOwn


class Constant(NamedTuple):
    """What is fitted: a factor on symbols of the process model, or an exponent of the free term."""

    symbols: tuple[str, ...]
    spread: float
    """Standard deviation before measuring: of the logarithm of a factor, or of an exponent itself."""


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
MISFIT = 4.0
"""Times the spread of a forecast that a reading is off by, for no model is the machine."""
CLIPPED = 4.0
"""Of these; a reading that is farther off counts no more."""
LEAST_CHANCE = 0.01
"""That a part is bad, or good, for a reason that the model does not know."""
SIZED = 0.8
"""Of the tolerance, beyond which a bad part is so by its size."""
ROUNDS, STEP, HALVINGS, FARTHEST = 3, 0.1, 3, 2.5
"""Of Gauss and Newton; difference, and bound, in standard deviations of the prior."""


class Innovations(Watch):
    """What readings are off by, without what a guard learns of it."""

    burnt: ClassVar[int] = Belief._fields.index("burnt")

    def _judge(self, seen: WatchedReading) -> None:
        self.seen = seen

    @property
    def off(self) -> Array:
        """In standard deviations, 0 where nothing is read, shape (N, readings)."""
        seen = self.seen
        return np.asarray(np.where(seen.new, (seen.read - seen.forecast) / seen.spread, 0.0))


def changed(model: Simulation, z: Array) -> Simulation:
    """The model with constants so many standard deviations from what they were."""
    made: Any = model
    names = CorrectedOwn._fields
    moved = [(symbol, each.spread * x) for each, x in zip(CONSTANTS, z, strict=True) for symbol in each.symbols]
    exponents, before = {symbol: float(x) for symbol, x in moved if symbol in names}, made.task.factors
    factors = {symbol: before.get(symbol, 1.0) * math.exp(x) for symbol, x in moved if symbol not in names}
    task = replace(made.task, factors={**before, **factors})
    own = CORRECTED.own(**exponents)
    plant = Plant(name="fitted", process=CORRECTED, own=tuple(own))
    held: Simulation = with_start_of(type(made)(task, process=CORRECTED), plant)
    return held


def residuals(model: Simulation, shifts: Sequence[TrackShift]) -> Array:
    """What was read and found in the shifts, off what the model forecasts."""
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
    """The most probable constants, in standard deviations of their priors, from some on."""
    return least_squares(lambda z: residuals(changed(model, z), shifts), start)


def least_squares(off: Callable[[Array], Array], start: Array) -> Array:
    """Where the squares of what is off, and of z itself, are least: Gauss and Newton with differences."""
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
