"""Estimates of sharpness and dulling rate from measured power and nominal constants.

The mean power of a block, minus the nominal power of chips and ploughing, is the friction power of the wear flats.
Friction and nominal pressure give the area of the flats (Malkin).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.block_rollouts import coming_kinds
from grind_env.envs.simulation import Simulation
from grind_env.kernel import entry, log
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.process.equations import chip_force, wear_flat_pressure, wheel_speed
from grind_env.process.stroke_and_dress import stroke_constants
from grind_env.process.stroke_types import StrokeParameters

FRESH = 0.0095  #: assumed wear-flat area when nothing has been ground since the dress
LEAST = 0.004  #: least wear-flat area that a noisy reading may give
DRESSED = 0.0085  #: wear-flat area of a dressed wheel, from which dulling is counted
LEAST_GROWTH = 0.0004
DULLING_RATE = 2.5e-5  #: nominal growth of the wear-flat area per specific volume, mm/mm3
LEAST_VOLUME = 15.0  #: specific volume, mm3/mm, below which growth since the dress drowns in noise
LARGEST_TERM = 2.0
LEAST_EXECUTIONS = 0.5
MEMORY = 4.0  #: number of blocks after which the mean over a lot becomes a running mean


class Estimate(NamedTuple):
    """Estimates from the measurements before a block; each shape (N,)."""

    wear_flat: Any  #: apparent wear-flat area: the true one times the hidden factor on the pressure
    volume: Any  #: specific volume removed since the last dress, mm3/mm
    severity: Any  #: log of the dulling rate over the nominal rate, mean over the lot; 0 before the first reading
    stock: Any  #: pre-gauged stock of the coming block over its nominal stock
    kind: Any  #: index of the kind of the coming block
    pressed: Any  #: log of the nominal work up to the next due date over the time left; 0 in a task without due dates
    thrift: Any  #: log of the dress executions left over the blocks left; 0 in a task whose wheel is never changed


class Signals(NamedTuple):
    """Readings for the estimates, in physical units, one row per episode."""

    power: Any  #: mean power of the last block, W; 0 without a reading
    speed: Any  #: E of the last block, mm/min
    pick: Any
    width: Any
    diameter: Any
    volume: Any
    new_lot: Any
    stock: Any
    kind: Any
    last_kind: Any
    pressed: Any
    thrift: Any


class LotMemory(NamedTuple):
    """Mean severity of a lot so far."""

    severity: float
    blocks: float  #: number of blocks in the mean


read_parameters, read_signals = column_reader(StrokeParameters), column_reader(Signals)
read_memory, write_memory = column_reader(LotMemory), column_writer(LotMemory)
write_estimate = column_writer(Estimate)


class SharpnessEstimator:
    """Estimator of sharpness and lot severity of N episodes from block to block.

    It reads only the measured observation, which is the beginning of the full observation.
    """

    def __init__(self, simulation: Simulation, episodes: int = 0) -> None:
        self.task, self.simulation = simulation.task, simulation
        self.parameters = simulation.branches.nominal
        self.begin(episodes)

    def begin(self, n: int) -> None:
        self.memory = np.zeros((n, len(LotMemory._fields)))
        self.kind = np.zeros(n)

    def restart(self, mask: NDArray[np.bool_]) -> None:
        """Forget the episodes in `mask`, shape (N,); call it before the update with their first observation."""
        self.memory[mask] = 0.0
        self.kind[mask] = 0.0

    def update(self, observation: NDArray[np.float32]) -> Estimate:
        """Return the estimates after the observation before a block, shape (N, entries)."""
        seen = self.simulation.read(observation)
        kind = coming_kinds(self.simulation.branches, seen).astype(np.float64)
        nothing = np.zeros(len(observation))
        signals = Signals(
            power=seen["mean_power"],
            speed=seen["last_speed"],
            pick=seen["last_pick"],
            width=seen["last_width"],
            diameter=seen["diameter"],
            volume=seen["volume"],
            new_lot=seen["new_lot"],
            stock=seen["stock"],
            kind=kind,
            last_kind=self.kind,
            pressed=nothing if self.task.due is None else -seen["slack"],
            thrift=(
                nothing
                if self.task.wheel_change is None
                else thrift(seen["executions_left"], self.task.blocks * seen["remaining"])
            ),
        )
        estimates = np.empty((len(observation), len(Estimate._fields)))
        _update(self.parameters, np.stack(signals, axis=1), self.memory, estimates)
        self.kind = kind
        return Estimate(*estimates.T)


def thrift(executions: ArrayLike, blocks: ArrayLike) -> NDArray[np.float64]:
    """Return the log of the dress executions left, at least half an execution, over the blocks left."""
    # after the last block no blocks are left, but that decision is not used
    return np.asarray(np.log(np.maximum(executions, LEAST_EXECUTIONS) / np.maximum(blocks, 1.0)))


@entry
def _update(parameters: Any, signals: Any, memory: Any, estimates: Any) -> None:
    for i in range(signals.shape[0]):
        seen, lot = read_signals(signals, i), read_memory(memory, i)
        p = read_parameters(parameters, int(seen.last_kind))
        area = FRESH
        if seen.power > 0.0:
            vw = seen.speed / 60.0
            vs = wheel_speed(seen.diameter, p.n, p.vs_set)
            force = seen.power / (seen.width * vs)
            k = stroke_constants(p, vw, 1.0)
            pressure = wear_flat_pressure(1.0 / (seen.diameter * vs), k.pa, k.pb)
            contact = math.sqrt(seen.diameter * (seen.pick + p.a0))
            friction = force - chip_force(seen.pick * vw, 1.0 / vs, p.u_ch) - p.kp * contact
            area = max(friction / (p.mu * pressure * contact), LEAST)
            if seen.volume > LEAST_VOLUME:
                growth = max(area - DRESSED, LEAST_GROWTH) / seen.volume
                term = min(max(log(growth / DULLING_RATE), -LARGEST_TERM), LARGEST_TERM)
                blocks = lot.blocks + 1.0
                weight = 1.0 / (min(blocks, MEMORY) + 0.5)
                lot = LotMemory(lot.severity + weight * (term - lot.severity), blocks)
        # the flag belongs to the coming block, the power to the last one
        if seen.new_lot > 0.5:
            lot = LotMemory(0.0, 0.0)
        write_memory(memory, i, lot)
        write_estimate(
            estimates, i, Estimate(area, seen.volume, lot.severity, seen.stock, seen.kind, seen.pressed, seen.thrift)
        )
