"""What can be believed of the wear-flat area of the wheel and of the severity of the lot, which no machine measures.

An ensemble filter. Every member is a whole wheel with factors of its own. With each block it is ground by the same
compiled cycle as the true one, from the programmed E and D and the pre-gauged stock; then all members are adjusted to
the power readings (ensemble adjustment Kalman filter: Anderson, Mon. Weather Rev. 129 (2001) 2884). A new lot draws
its factors anew. Moving the members instead of weighing them matters: in PowerLimited a bootstrap filter of 512 weighed
particles followed the wear no better than 16 moved ones, and was too sure of itself. The size gauge told nothing more.
tests/envs/belief_accuracy.py measures how well the wear is followed.

The filter knows the task with its spreads and the noise of its sensors, as the process engineer does who sets it up;
of an episode it knows the measured observation alone. It draws no random numbers: the members are rows of a fixed
Latin hypercube, so that the belief is a function of what was measured, and the same in every form of environment.
"""

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.belief_kernel import follow
from grind_env.envs.belief_rows import Belief, Hidden, Signals
from grind_env.envs.episode import EpisodeGenerator
from grind_env.envs.observations import Reading, physical, readings
from grind_env.envs.rows import kind_table, parameter_table, shop_row
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError
from grind_env.machine.cycle import PartState
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import WheelState

Table = NDArray[np.float64]

DRAWS = 64
"""Samples of the hypercube after which the filter begins again with the first."""

STOCK = TapeRow._fields.index("stock")


class BeliefError(GrindError):
    """An ensemble that cannot be."""


def belief_entries() -> tuple[Reading, ...]:
    """How a belief stands in an observation."""
    return (
        Reading("belief_wear_flat", "", 0.0, 0.05, 0.0, 5.0, "belief", "mean of the wear-flat area A"),
        Reading("belief_wear_flat_spread", "", 0.0, 0.05, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_growth", "ln", 0.0, 1.0, -5.0, 5.0, "belief", "mean log factor on wear-flat growth"),
        Reading("belief_growth_spread", "ln", 0.0, 1.0, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_pressure", "ln", 0.0, 1.0, -5.0, 5.0, "belief", "mean log factor on wear-flat pressure"),
        Reading("belief_pressure_spread", "ln", 0.0, 1.0, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_burnt", "", 0.0, 1.0, 0.0, 1.0, "belief", "probability that the last block burnt the part"),
    )


def hypercube(rows: int, members: int) -> Table:
    """Latin hypercube samples of standard normal numbers, shape (rows, members, fields of `Hidden`)."""
    rng = np.random.default_rng(0)
    normal = NormalDist()
    levels = np.array([normal.inv_cdf((k + 0.5) / members) for k in range(members)])
    # the middles of the layers have too small a spread
    columns = np.broadcast_to(levels / np.std(levels, ddof=1), (rows, len(Hidden._fields), members))
    samples: Table = np.ascontiguousarray(rng.permuted(columns, axis=2).swapaxes(1, 2))
    return samples


class WheelBelief:
    """The beliefs of N episodes of a task, from block to block.

    Args:
        task: the task.
        members: members of the ensemble of an episode; the kernel runs eight at a time.
        entries: entries of the observation; by default what a machine measures. Nothing hidden is read.

    Raises:
        BeliefError: if there are fewer than two members.
    """

    def __init__(self, task: Task, members: int = 16, entries: tuple[Reading, ...] | None = None) -> None:
        if members < 2:
            raise BeliefError(f"members is {members}, but must be at least 2: their spread is what they know")
        self.members = members
        self.entries = readings(task, full=False) if entries is None else entries
        self.kinds, self.base = kind_table(task), parameter_table(task)
        self.shop = shop_row(task)
        self.names = [kind.name for kind in task.kinds]
        self.stocks = np.array([kind.stock for kind in task.kinds])
        self.materials = task.materials
        self.usual = np.array([self.materials.index(kind.material) for kind in task.kinds])
        self.ageing = task.setup.coolant_ageing
        spread = task.spread
        self.sigmas = Hidden(
            spread.wheel_growth,
            spread.fracture_force,
            spread.g_ratio,
            spread.convection,
            spread.coolant_ageing,
            spread.lot_growth,
            spread.lot_pressure,
        )
        self.noise = spread.measurement
        self.draws = hypercube(DRAWS, members)
        generator = EpisodeGenerator(task)
        flats = spread.diamond_flat * (np.arange(members) + 0.5) / members
        self.first = np.array([generator.wheel(float(flat)) for flat in flats])
        self.begin(0)

    def begin(self, n: int) -> None:
        """N episodes begin."""
        m = self.members
        self.fresh = np.ones(n, bool)
        self.updates = np.zeros(n, np.int64)
        self.ground = np.zeros(n)
        self.kind = np.zeros(n, np.int64)
        self.rows = np.zeros((n, len(TapeRow._fields)))
        self.wheels = np.empty((n, m, len(WheelState._fields)))
        self.parts = np.empty((n, m, len(PartState._fields)))
        self.hidden = np.empty((n, m, len(Hidden._fields)))
        self.beliefs = np.zeros((n, len(Belief._fields)))

    def restart(self, mask: NDArray[np.bool_]) -> None:
        """The episodes in `mask`, shape (N,), begin anew with their next observation."""
        self.fresh |= mask

    def update(self, observation: NDArray[np.float32], mask: NDArray[np.bool_] | None = None) -> Belief:
        """Take in the observations before a block.

        Args:
            observation: shape (N, entries).
            mask: the episodes to update, shape (N,); all by default.

        Returns:
            The beliefs of all episodes; each field of shape (N,).
        """
        chosen = np.ones(len(observation), bool) if mask is None else mask
        seen = physical(observation, self.entries)
        new = np.flatnonzero(chosen & self.fresh)
        self.updates[new] = 0
        self.ground[new] = 0.0
        self.wheels[new] = self.first
        self.parts[new] = PartState(Z=0.0, S=0.0, Rs=INITIAL_ROUGHNESS)
        self.hidden[new] = self.draws[0]
        signals = Signals(
            seen["mean_power"],
            seen["first_power"],
            seen["peak_power"],
            1000.0 * seen["last_speed"],
            # a whole number again, which the single precision of the observation may have missed
            np.round(seen["last_executions"]),
            seen.get("last_pre_dress", np.zeros(len(observation))),
            seen["diameter"],
            seen["new_lot"],
        )
        follow(
            self.kinds,
            self.base,
            self.shop,
            self.sigmas,
            self.ageing,
            self.noise,
            self.draws,
            self.rows,
            self.kind,
            np.stack(signals, axis=1),
            np.flatnonzero(chosen),
            self.fresh,
            self.updates,
            self.ground,
            self.wheels,
            self.parts,
            self.hidden,
            self.beliefs,
        )
        self.fresh &= ~chosen
        self._remember(seen, chosen)
        return Belief(*self.beliefs.T.copy())

    def _remember(self, seen: dict[str, Table], chosen: NDArray[np.bool_]) -> None:
        """Keep kind and stock of the coming block: the next observation speaks of that block as the last one."""
        kind = np.zeros(len(chosen), np.int64)
        if len(self.names) > 1:
            kind = np.argmax([seen[f"coming_{name}"] for name in self.names], axis=0)
        material = self.usual[kind]
        for number, name in enumerate(self.materials):
            material = np.where(seen.get(f"material_{name}", np.zeros(len(chosen))) > 0.5, number, material)
        stock = np.round(1000.0 * seen["stock"] * self.stocks[kind]) / 1000.0
        self.kind[chosen] = (kind * len(self.materials) + material)[chosen]
        self.rows[chosen, STOCK] = stock[chosen]
