"""The start of the episodes of a task: their random draws and first wheels."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Table
from grind_env.envs.disturbances import DEALT, Disturbances, read_fixed
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import KEY_0, KEY_1, DrawnKind, Sigmas, read_sigmas
from grind_env.envs.random_numbers import EPISODE, unless, words_of
from grind_env.envs.tasks import Task
from grind_env.envs.tasks.unseen_entries import OtherWheel, other_materials, other_wheels
from grind_env.kernel import entry
from grind_env.kernel.random import uniform
from grind_env.kernel.row_accessors import replacer
from grind_env.machine.loops.row_io import read_parameters, write_wheel
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import WheelState

used = replacer(WheelState, "A", "V")


class Opening(NamedTuple):
    """Start of the episodes of a task."""

    diameter: float  #: diameter of the wheel where nothing is drawn, mm
    least_diameter: float
    execution_depth: float  #: diameter that one dress execution takes off, mm
    least_left: float  #: fewest dress executions left; NaN if the diameter is not drawn
    most_left: float
    lead: float  #: lead of the dress before the first block, mm
    depth: float
    wear_flat_area: float  #: wear-flat area A as a fraction of the wheel face; NaN for a freshly dressed wheel
    volume: float  #: volume ground since the dress before the first block, mm3/mm


@entry
def mount_wheels(
    wheels: Any, source: Any, index: Any, which: Any, fixed: Any, spreads: Any, opening: Opening, parameters: Any
) -> None:
    """Write the first wheels of M episodes, shape (N, fields of `WheelState`); arguments as for `begin_episodes`.

    `parameters` are the stroke parameters of the dress before the first block, shape (1, fields of `StrokeParameters`).
    """
    sigmas, p = read_sigmas(spreads, 0), read_parameters(parameters, 0)
    for j in range(index.size):
        i, given = index[j], read_fixed(fixed, which[j])
        _, _, flat_word, left_word = words_of(source[i, KEY_0], source[i, KEY_1], EPISODE, 1)
        left = opening.least_left + (opening.most_left - opening.least_left) * uniform(left_word)
        found = opening.least_diameter + opening.execution_depth * unless(given.executions_left, left)
        ds = opening.diameter if np.isnan(opening.least_left) else found
        flat = unless(given.diamond_flat, sigmas.diamond_flat * uniform(flat_word))
        wheel = dressed_wheel(ds, flat, opening.lead, opening.depth, p)
        write_wheel(wheels, i, used(wheel, (unless(opening.wear_flat_area, wheel.A), opening.volume)))


class EpisodeGenerator(Disturbances):
    """Generator of the episodes of a task."""

    def __init__(self, task: Task) -> None:
        sequence = (DEALT,) * task.blocks if task.orders else task.numbers(task.sequence, "")
        super().__init__(_drawn_kinds(task), _sigmas(task), sequence)
        self.most_parts = task.orders.most_parts if task.orders else 0
        self.parameters, self.opening = task.parameters(task.kinds[0]), _opening(task)
        self._parameter_row = np.array([self.parameters])
        self.materials = np.array([float(task.materials.index(name)) for name in other_materials(task)])
        self.wheels = np.array(other_wheels(task)).reshape(-1, len(OtherWheel._fields))

    def mount(self, episodes: Episodes, index: NDArray[np.int64], which: NDArray[np.int64], fixed: Table) -> None:
        drawn = episodes.source, index, which, fixed, self.spreads
        mount_wheels(episodes.wheels, *drawn, self.opening, self._parameter_row)

    def wheel(self, diamond_flat: float) -> WheelState:
        """Return the new wheel at the start of an episode, dressed with a diamond of that wear flat, mm."""
        opening = self.opening
        wheel = dressed_wheel(opening.diameter, diamond_flat, opening.lead, opening.depth, self.parameters)
        area = opening.wear_flat_area
        return wheel._replace(A=wheel.A if math.isnan(area) else area, V=opening.volume)


def _drawn_kinds(task: Task) -> list[DrawnKind]:
    speed = task.due.speed if task.due else 1000.0
    return [
        DrawnKind(
            stock=kind.stock,
            least_stock=kind.least_stock,
            starts_part=float(kind.starts_part),
            material=float(task.materials.index(kind.material)),
            seconds=task.nominal_seconds(kind, speed),
            part=-1.0,
        )
        for kind in task.kinds
    ]


def _sigmas(task: Task) -> Sigmas:
    spread = {name: getattr(task.spread, name) for name in task.spread.__slots__}
    least, most = task.due.slack if task.due else (1.0, 1.0)
    period = float(task.due.blocks) if task.due else 0.0
    return Sigmas(
        **spread,
        ageing=task.setup.coolant_ageing,
        due_blocks=period,
        least_slack=least,
        most_slack=most,
        whole_micrometres=1.0,
        new_wheels=1.0,
    )


def _opening(task: Task) -> Opening:
    left = task.start.executions_left or (math.nan, math.nan)
    area = task.start.wear_flat_area
    return Opening(
        task.wheel.diameter,
        task.wheel.minimum_diameter,
        task.execution_depth,
        float(left[0]),
        float(left[1]),
        task.dress_lead,
        task.dress.depth,
        math.nan if area is None else area,
        task.start.volume,
    )
