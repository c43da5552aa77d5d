"""Belief of the wear-flat area of the wheel and of the dulling rate of the lot, which no machine measures.

The belief is an ensemble filter. Every member is a wheel with its own factors. The same compiled cycle as for the true
wheel grinds each block with all members, from the programmed E and D and the pre-gauged stock. Then the members are
adjusted to the power readings (ensemble adjustment Kalman filter: Anderson, Mon. Weather Rev. 129 (2001) 2884). A new
lot draws new factors. In PowerLimited 512 weighted particles (bootstrap filter) followed the wear no better than 16
adjusted members, and were overconfident. The size gauge added no information.

The filter knows the task with its spreads and sensor noise, as the process engineer does. In an episode it sees only
the measured observation. It draws no random numbers: the members are rows of a fixed Latin hypercube, so the belief is
a function of the measurements, equal in single and vector environments.
"""

from collections.abc import Sequence
from statistics import NormalDist
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Numbers, Table
from grind_env.belief.ensemble_filter import DIAMETER, NEW_WHEEL, follow, write_factors
from grind_env.belief.filter_quantities import FACTORS, Belief, Hidden, Judged, Signals
from grind_env.errors import GrindError
from grind_env.machine.loops.stroke_totals import Tally

MEAN_POWER = slice(Tally._fields.index("power_1"), Tally._fields.index("power_6") + 1)
DRAWS = 64  #: number of samples in the hypercube; after the last one the filter starts again with the first


class BeliefError(GrindError):
    """An ensemble that is too small, or a simulation that a belief cannot follow."""


class Model(Protocol):
    """Interface of the filter to the task that it follows; `envs.filter_members` implements it."""

    base: Table  #: nominal parameters, shape (any, fields of `StrokeParameters`)
    sigmas: Hidden  #: scales of the hidden numbers
    ageing: float  #: log convection that the coolant loses with every part
    noise: float  #: factor on the noise of the sensors
    #: simulation of the members; `read` returns observations in physical units, `clear` starts members anew
    simulation: Any
    #: branches of the simulation: `coming_rows`, `first_wheels`, and `load`, which gives members their next block
    branches: Any
    dress: tuple[float, float]  #: traverse feed of the diamond, mm/s, and depth, mm, with which a new wheel is dressed

    def base_rows(self, rows: Numbers) -> Numbers:
        """Return the row in `base` for each of these rows in the table of kinds, shape (N,)."""

    def judged(self, rows: Numbers) -> Table:
        """Return flags and limits of blocks of these rows in the table of kinds, shape (N, fields of `Judged`)."""

    def empty_episodes(self, n: int) -> Any:
        """Return arrays for N members: episodes of one block, with `wheels` and more."""

    def write_factors(self, members: Any, index: Numbers, factors: Table) -> None:
        """Write the factors of the members at `index`, in the order of `FACTORS`, shape (index, factors)."""

    def rest(self, members: Any, index: Numbers, rows: Numbers) -> None:
        """Let the members at `index` rest during a wheel change, after blocks of these rows in the table of kinds."""

    def grind(self, members: Any, choice: Sequence[Table], index: Numbers) -> tuple[Table, Table]:
        """Grind the next block of the members at `index` with E in mm/min, D and pre-dresses.

        Returns:
            Results, shape (members, fields of `Tally`); size error, um, and Ra over its limit, shape (members, 2).
        """


class Forecast(NamedTuple):
    """Expected readings of the last block, by member, each shape (N, M)."""

    mean_power: Any  #: mean power, W; 0 where there is nothing to read
    peak_power: Any  #: peak power, W
    size_error: Any  #: size error, um
    roughness: Any  #: ratio of Ra to its limit
    burn_ratio: Any  #: highest burn ratio of the block (`equations.burn_ratio`); 0 where no heat counts


def hypercube(rows: int, members: int) -> Table:
    """Return Latin hypercube samples of standard normal numbers, shape (rows, members, fields of `Hidden`)."""
    rng = np.random.default_rng(0)
    normal = NormalDist()
    levels = np.array([normal.inv_cdf((k + 0.5) / members) for k in range(members)])
    # without this division the spread is too small, because the levels are the middles of the layers
    columns = np.broadcast_to(levels / np.std(levels, ddof=1), (rows, len(Hidden._fields), members))
    samples: Table = np.ascontiguousarray(rng.permuted(columns, axis=2).swapaxes(1, 2))
    return samples


class WheelBelief:
    """Beliefs of N episodes, updated from block to block.

    Args:
        model: model of the task that the filter follows.
        members: number of ensemble members of an episode; the kernel runs eight at a time.

    Raises:
        BeliefError: if there are fewer than two members.
    """

    def __init__(self, model: Model, members: int = 16) -> None:
        if members < 2:
            raise BeliefError(f"members is {members}, but must be at least 2: their spread is what they know")
        self.model, self.size = model, members
        self.draws = hypercube(DRAWS, members)
        self.first = model.branches.first_wheels(members)
        self.begin(0)

    def begin(self, n: int) -> None:
        self.fresh = np.ones(n, bool)
        self.updates = np.zeros(n, np.int64)
        self.ground = np.zeros(n)
        self.rows = np.zeros(n, np.int64)
        self.members = self.model.empty_episodes(n * self.size)
        self.hidden = np.empty((n, self.size, len(Hidden._fields)))
        self.forecast = Forecast(*np.zeros((len(Forecast._fields), n, self.size)))
        self.beliefs = np.zeros((n, len(Belief._fields)))

    def restart(self, mask: NDArray[np.bool_]) -> None:
        """Restart the episodes in `mask`, shape (N,), with their next observation."""
        self.fresh |= mask

    @property
    def wheels(self) -> Table:
        """Return the wheels of the members, shape (N, M, fields of `WheelState`): a view."""
        wheels: Table = self.members.wheels.reshape(len(self.fresh), self.size, -1)
        return wheels

    def factors(self) -> Table:
        """Return the factors of the members for the coming block, shape (N, M, factors)."""
        drawn = np.empty((*self.hidden.shape[:2], len(FACTORS)))
        write_factors(self.hidden, self.model.sigmas, self.model.ageing, self.ground, np.arange(len(drawn)), drawn)
        return drawn

    def update(self, observation: NDArray[np.float32], mask: NDArray[np.bool_] | None = None) -> Belief:
        """Update the beliefs with the observations before a block.

        Args:
            observation: observations, shape (N, entries); hidden entries are not read.
            mask: the episodes to update, shape (N,); all by default.

        Returns:
            The beliefs of all episodes; each field of shape (N,).
        """
        model, n = self.model, len(observation)
        chosen = np.ones(n, bool) if mask is None else mask
        seen = model.simulation.read(observation)
        new = np.flatnonzero(chosen & self.fresh)
        self.updates[new] = 0
        self.ground[new] = 0.0
        self.wheels[new, :, : self.first.shape[1]] = self.first
        model.simulation.clear(self.members, self._of(new))
        self.hidden[new] = self.draws[0]
        signals = Signals(
            mean_power=seen["mean_power"],
            first_power=seen["first_power"],
            peak_power=seen["peak_power"],
            speed=seen["last_speed"],
            # rounded, because single precision may have changed a whole number
            executions=np.round(seen["last_executions"]),
            pre_dress=seen.get("last_pre_dress", np.zeros(n)),
            diameter=seen["diameter"],
            new_lot=seen["new_lot"],
        )
        found = self._ground(np.flatnonzero(chosen & ~self.fresh), signals)
        changed = np.flatnonzero(chosen & ~self.fresh & (signals.diameter > self.wheels[:, 0, DIAMETER] + NEW_WHEEL))
        if changed.size:
            model.rest(self.members, self._of(changed), np.repeat(self.rows[changed], self.size))
        follow(
            model.judged(self.rows),
            np.stack(signals, axis=1),
            model.noise,
            model.base,
            model.base_rows(self.rows),
            *model.dress,
            model.sigmas,
            self.draws,
            np.flatnonzero(chosen),
            self.fresh,
            self.updates,
            self.ground,
            found,
            self.wheels,
            self.hidden,
            self.beliefs,
        )
        self.fresh &= ~chosen
        # in the next observation the coming block will be the last one
        coming = np.flatnonzero(chosen)
        self.rows[coming] = model.branches.coming_rows(seen)[coming]
        stocks = np.repeat(seen["stock"][coming], self.size)
        model.branches.load(self.members, self._of(coming), np.repeat(self.rows[coming], self.size), stocks)
        return Belief(*self.beliefs.T.copy())

    def _of(self, episodes: Numbers) -> Numbers:
        return (episodes[:, None] * self.size + np.arange(self.size)).ravel()

    def _ground(self, episodes: Numbers, signals: Signals) -> Table:
        """Return the results of the members of some episodes in their last block, shape (N, M, fields of `Tally`)."""
        index = self._of(episodes)
        self.model.write_factors(self.members, index, self.factors().reshape(-1, len(FACTORS))[index])
        choice = [np.repeat(each, self.size) for each in (signals.speed, signals.executions, signals.pre_dress)]
        found, made = self.model.grind(self.members, choice, index)
        tally, shape = Tally(*found.T), self.hidden.shape[:2]
        power = np.sum(tally[MEAN_POWER], axis=0) / np.maximum(tally.last_count, 1.0)
        heats = np.repeat(Judged(*self.model.judged(self.rows).T).counts_all > 0.0, self.size) | (
            tally.finish_rise > 0.0
        )
        expected = power, tally.peak_load, *made.T, np.where(heats, tally.burn_ratio, 0.0)
        self.forecast = Forecast(*(each.reshape(shape) for each in expected))
        return found.reshape(*shape, -1)
