"""How episodes begin: the key of each, its first wheel, and the first rows of its noise tape."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.contexts import Fixed, Given, apart
from grind_env.envs.drawing import EPISODE, ORDER, keys_of, unless, words_of
from grind_env.envs.episodes import Episodes
from grind_env.envs.splits import Draws, draws_of
from grind_env.envs.tape import DrawnKind, Origin, Sigmas, draw_rows, origin_of, read_origin, read_sigmas, write_origin
from grind_env.envs.tasks import Task
from grind_env.envs.tasks.others import OtherWheel, other_materials, other_wheels
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader
from grind_env.kernel.random import uniform
from grind_env.machine.loops.rows import read_parameters, write_wheel
from grind_env.process.state import WheelState
from grind_env.process.stroke import dressed_wheel

DEALT = -1
"""Kind of a block that the orders decide."""

read_fixed, read_draws = column_reader(Fixed), column_reader(Draws)


class Opening(NamedTuple):
    """How the episodes of a task begin."""

    diameter: float
    """Of the wheel where nothing is drawn, mm."""
    least_diameter: float
    execution_depth: float
    """Diameter that one dress execution takes off, mm."""
    least_left: float
    """Fewest dress executions left; NaN if the diameter is not drawn."""
    most_left: float
    lead: float
    """Of the dress before the first block, mm."""
    depth: float
    wear_flat_area: float
    """NaN for that of a dressed wheel."""
    volume: float
    """Ground since that dress, mm3/mm."""


@inlined
def write_schedule(schedule: Any, i: int, sequence: Any, count: int, most_parts: int, origin: Origin) -> None:
    """Write the kinds of the blocks of episode i: those of a sequence, or orders with 1 to `most_parts` parts each."""
    before, left = DEALT, 0
    for k in range(sequence.size):
        kind = int(sequence[k])
        begins = k == 0 or (most_parts > 0 and kind != before)
        if kind == DEALT:
            begins = left == 0
            kind = before
            if begins:
                kind_word, size_word, _, _ = words_of(origin.key_0, origin.key_1, ORDER, k)
                kind, left = int(uniform(kind_word) * count), 1 + int(uniform(size_word) * most_parts)
            left -= 1
        schedule[i, k] = 2 * kind + (1 if begins else 0)
        before = kind


@entry
def begin_episodes(
    tape: Any,
    block: Any,
    wheels: Any,
    source: Any,
    schedule: Any,
    index: Any,
    keys: Any,
    which: Any,
    fixed: Any,
    splits: Any,
    sequences: Any,
    kinds: Any,
    spreads: Any,
    materials: Any,
    other_wheels: Any,
    most_parts: int,
    opening: Opening,
    parameters: Any,
) -> None:
    """Write what M episodes are drawn from, their first rows and their first wheels.

    Args:
        tape: as for `draw_rows`; written in the rows `index`, like the next four.
        block: as for `draw_rows`.
        wheels: shape (N, fields of `WheelState`).
        source: as for `draw_rows`.
        schedule: as for `draw_rows`.
        index: episodes that begin, shape (M,).
        keys: two uniform numbers for each, shape (M, 2).
        which: number of what is given of each, shape (M,).
        fixed: what a context fixes, by that number, shape (any, fields of `Fixed`).
        splits: of the split likewise, shape (any, fields of `Draws`).
        sequences: kinds of the blocks likewise, shape (any, blocks); `DEALT` where orders deal them.
        kinds: shape (kinds, fields of `DrawnKind`).
        spreads: shape (1, fields of `Sigmas`).
        materials: of a foreign split, as for `origin_of`.
        other_wheels: likewise.
        most_parts: of an order; 0 in a task without orders.
        opening: how the episodes of the task begin.
        parameters: of the dress before the first block, shape (1, fields of `StrokeParameters`).
    """
    sigmas, p = read_sigmas(spreads, 0), read_parameters(parameters, 0)
    for j in range(index.size):
        i, given, split = index[j], read_fixed(fixed, which[j]), read_draws(splits, which[j])
        u_0, u_1, blocks = keys[j, 0], keys[j, 1], schedule.shape[1]
        write_origin(source, i, origin_of(u_0, u_1, blocks, given, split, sigmas, materials, other_wheels))
        origin = read_origin(source, i)
        write_schedule(schedule, i, sequences[which[j]], kinds.shape[0], most_parts, origin)
        block[i] = 0
        _, _, flat_word, left_word = words_of(origin.key_0, origin.key_1, EPISODE, 1)
        left = opening.least_left + (opening.most_left - opening.least_left) * uniform(left_word)
        found = opening.least_diameter + opening.execution_depth * unless(given.executions_left, left)
        ds = opening.diameter if np.isnan(opening.least_left) else found
        flat = unless(given.diamond_flat, sigmas.diamond_flat * uniform(flat_word))
        wheel = dressed_wheel(ds, flat, opening.lead, opening.depth, p)
        A = unless(opening.wear_flat_area, wheel.A)
        write_wheel(
            wheels,
            i,
            WheelState(
                ds=wheel.ds,
                A=A,
                lam=wheel.lam,
                V=opening.volume,
                Rd=wheel.Rd,
                Cd=wheel.Cd,
                W=wheel.W,
                wd=wheel.wd,
            ),
        )
    draw_rows(tape, block, source, schedule, kinds, spreads, index)


class EpisodeGenerator:
    """Draws the episodes of a task.

    Attributes:
        kinds: numbers of its kinds of blocks, shape (kinds, fields of `DrawnKind`).
        spreads: shape (1, fields of `Sigmas`).
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        self.kinds, self.spreads = np.array(_drawn_kinds(task)), np.array([_sigmas(task)])
        self.sequence = (DEALT,) * task.blocks if task.orders else task.numbers(task.sequence, "")
        self.most_parts = task.orders.most_parts if task.orders else 0
        self.parameters = task.parameters(task.kinds[0])
        self.opening = _opening(task)
        self._parameter_row = np.array([self.parameters])
        self._materials = np.array([float(task.materials.index(name)) for name in other_materials(task)])
        self._wheels = np.array(other_wheels(task)).reshape(-1, len(OtherWheel._fields))

    def begin(
        self,
        episodes: Episodes,
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """Begin an episode with a key from each of M generators; whatever is given, each draws two numbers.

        Args:
            episodes: tape, source, schedule and first wheel are written in the rows `index`.
            index: rows of the new episodes, shape (M,).
            rngs: their generators.
            given: what is given of each.
        """
        each, which = apart(given)
        begin_episodes(
            episodes.tape,
            episodes.block,
            episodes.wheels,
            episodes.source,
            episodes.schedule,
            index,
            keys_of(rngs),
            which,
            np.array([one.fixed for one in each]),
            np.array([draws_of(one.split) for one in each]),
            np.array([self.sequence if one.kinds is None else one.kinds for one in each]),
            self.kinds,
            self.spreads,
            self._materials,
            self._wheels,
            self.most_parts,
            self.opening,
            self._parameter_row,
        )

    def draw(self, episodes: Episodes) -> None:
        """Draw the rows that the tapes have room for."""
        everyone = np.arange(len(episodes.block))
        drawn_from = episodes.source, episodes.schedule, self.kinds, self.spreads
        draw_rows(episodes.tape, episodes.block, *drawn_from, everyone)

    def wheel(self, diamond_flat: float) -> WheelState:
        """The new wheel at the start of an episode, dressed with a diamond of that wear flat, mm."""
        opening = self.opening
        wheel = dressed_wheel(opening.diameter, diamond_flat, opening.lead, opening.depth, self.parameters)
        area = opening.wear_flat_area
        return wheel._replace(A=wheel.A if math.isnan(area) else area, V=opening.volume)


def _drawn_kinds(task: Task) -> list[DrawnKind]:
    speed = task.due.speed if task.due else 1.0
    return [
        DrawnKind(
            stock=kind.stock,
            least_stock=kind.least_stock,
            starts_part=float(kind.starts_part),
            material=float(task.materials.index(kind.material)),
            seconds=task.nominal_seconds(kind, speed),
        )
        for kind in task.kinds
    ]


def _sigmas(task: Task) -> Sigmas:
    spread = {name: getattr(task.spread, name) for name in task.spread.__slots__}
    least, most = task.due.slack if task.due else (1.0, 1.0)
    period = float(task.due.blocks) if task.due else 0.0
    return Sigmas(**spread, ageing=task.setup.coolant_ageing, due_blocks=period, least_slack=least, most_slack=most)


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
