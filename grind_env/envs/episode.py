"""The noise tape: everything random in an episode, drawn at reset.

The same seed therefore means the same stock, lots, wheels and measurement noise, whatever the policy does, and
policies can be compared on common random numbers.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.contexts import Fixed, Given, from_ranges, materials
from grind_env.envs.tape import CUT, FACTORS, SCHEDULE, Sigmas, TapeRow, deal_orders, fill, fill_dates
from grind_env.envs.tasks import Task
from grind_env.machine.compiled import dressed_wheel
from grind_env.process.state import WheelState

__all__ = ["CUT", "FACTORS", "SCHEDULE", "Drawn", "EpisodeGenerator", "TapeRow"]

NORMALS = 9
"""Standard normal numbers drawn for a block; a row after the last block holds those of the episode."""
LOT_NORMALS = slice(2, 4)
EPISODE_NORMALS = slice(0, 5)


class Drawn(NamedTuple):
    """One episode."""

    tape: NDArray[np.float64]
    """Shape (blocks, fields of `TapeRow`)."""
    diamond_flat: float
    """First wear flat of the diamond, mm."""
    diameter: float
    """First diameter of the wheel, mm."""


class EpisodeGenerator:
    """Draws the episodes of a task."""

    def __init__(self, task: Task) -> None:
        self.task = task
        names = materials()
        self.stocks = np.array([kind.stock for kind in task.kinds])
        self.least = np.array([kind.least_stock for kind in task.kinds])
        self.starts = np.array([kind.starts_part for kind in task.kinds])
        self.materials = np.array([float(names.index(kind.material)) for kind in task.kinds])
        spread = {name: getattr(task.spread, name) for name in task.spread.__slots__}
        self.sigmas = Sigmas(**spread, ageing=task.setup.coolant_ageing)
        self.sequence = None if task.orders else np.array(task.numbers(task.sequence, ""))
        self.dates = task.blocks // task.due.blocks if task.due else 0
        speed = task.due.speed if task.due else 1.0
        self.nominal = np.array([task.nominal_seconds(kind, speed) for kind in task.kinds])
        self.diameter, self.lead, self.depth = task.wheel.diameter, task.dress_lead, task.dress.depth
        self.least_diameter = task.wheel.minimum_diameter
        self.parameters = task.parameters(task.kinds[0])

    def draw(self, rng: np.random.Generator, given: Given | None = None) -> Drawn:
        """One episode.

        The count of random numbers depends on the task only, never on what they turn out to be or on what is given.
        """
        given = Given() if given is None else given
        task, fixed = self.task, given.fixed
        blocks = task.blocks
        normals = rng.standard_normal((blocks + 1, NORMALS))
        uniforms = rng.random(blocks + 1)
        orders = rng.random((blocks, 2)) if task.orders else np.empty((0, 2))
        slack = rng.random(self.dates) if self.dates else np.empty(0)
        ageing = rng.random() if self.sigmas.ageing else 0.5
        left = rng.random() if task.start.executions_left else 0.0
        spare = rng.standard_normal(2) if task.wheel_change else np.zeros(2)
        if given.ranges:
            normals[:blocks, LOT_NORMALS] = from_ranges(normals[:blocks, LOT_NORMALS], given.ranges)
            normals[blocks, EPISODE_NORMALS] = from_ranges(normals[blocks, EPISODE_NORMALS], given.ranges)
            spare = from_ranges(spare, given.ranges)

        kinds, begins = self._blocks(orders, given)
        tape = np.empty((blocks, len(TapeRow._fields)))
        fill(
            tape,
            kinds,
            begins,
            self.stocks,
            self.least,
            self.starts,
            self.materials,
            normals,
            uniforms,
            ageing,
            spare,
            self.sigmas,
            fixed,
        )
        if task.due is not None:
            low, high = task.due.slack
            factors = low + (high - low) * slack if np.isnan(fixed.slack) else np.full(self.dates, fixed.slack)
            fill_dates(tape, kinds, self.nominal, factors)
        flat = (
            self.sigmas.diamond_flat * float(uniforms[blocks]) if np.isnan(fixed.diamond_flat) else fixed.diamond_flat
        )
        return Drawn(tape, flat, self._first_diameter(left, fixed))

    def _blocks(self, orders: NDArray[np.float64], given: Given) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Kind of every block, and whether it begins an order; without orders, only the first one does."""
        most = self.task.orders.most_parts if self.task.orders else 0
        kinds, begins = np.zeros(self.task.blocks, np.int64), np.zeros(self.task.blocks, np.bool_)
        begins[0] = True
        if given.kinds is not None:
            kinds[:] = given.kinds
            if most > 0:
                begins[1:] = kinds[1:] != kinds[:-1]
        elif self.sequence is not None:
            kinds[:] = self.sequence
        else:
            deal_orders(kinds, begins, orders, len(self.stocks), most)
        return kinds, begins

    def _first_diameter(self, left: float, fixed: Fixed) -> float:
        if self.task.start.executions_left is None:
            return self.diameter
        low, high = self.task.start.executions_left
        executions = low + (high - low) * left if np.isnan(fixed.executions_left) else fixed.executions_left
        return self.least_diameter + self.task.execution_depth * executions

    def wheel(self, diamond_flat: float, diameter: float | None = None) -> WheelState:
        """The wheel at the start of an episode, dressed with a diamond of that wear flat (mm); new if no diameter."""
        ds = self.diameter if diameter is None else diameter
        wheel = dressed_wheel(ds, diamond_flat, self.lead, self.depth, self.parameters)
        start = self.task.start
        area = start.wear_flat_area
        return wheel._replace(A=wheel.A if area is None else area, V=start.volume)
