"""The step of `grind/WidePlates-v0`; cost and memory of a block are those of `envs.blocks.step`."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.envs.blocks.step import Choices, block_stroking, draw_coming, floor_of
from grind_env.envs.drawing import TAPER, deviation, words_of
from grind_env.envs.observations import SIZE_NOISE
from grind_env.envs.step import Work, step_of
from grind_env.envs.tables import read_shop
from grind_env.envs.tape import KEY_0, KEY_1, NOISE_FACTOR, read_sigmas
from grind_env.kernel import entry
from grind_env.kernel.columns import column_writer, replacer
from grind_env.machine.loops.batch import NO_MOTIONS, longest_traverses
from grind_env.machine.loops.courses import COURSES
from grind_env.machine.loops.cycle import PartState, Stroking
from grind_env.machine.loops.loops import zoned_loops_of
from grind_env.machine.loops.rows import RULES_FROM, read_stroking, write_part, write_stroking
from grind_env.machine.part.gauging import gauge_zones
from grind_env.process.gauge import Gauge
from grind_env.process.process import Process

TAPER_NOISE = SIZE_NOISE * 2.0**0.5
"""um; standard deviation of a taper as gauged, the difference of two sizes."""

write_traverse = column_writer(TraverseCycle, RULES_FROM)
crossing = replacer(Stroking, "start", "cross_end")


class CrossTables(NamedTuple):
    """What the task is made of, and room for N cycles; the first seven as in `Tables`."""

    kinds: Any
    base: Any
    shops: Any
    drawn: Any
    spreads: Any
    cycles: Any
    parameters: Any
    surfaces: Any
    """Room for the parts, shape (N, zones, fields of `Zone`)."""
    zones: Any
    """A new one, shape (zones, fields of `Zone`)."""
    crossover: float
    """Way across of a traverse, mm."""
    cross_pick: float
    """K, mm."""


class CrossArrays(NamedTuple):
    """The state of N episodes, as in `simulation.CrossEpisodes`; the first seven as in `EpisodeArrays`.

    The depth S in `parts` is that where a part is farthest from its size.
    """

    tape: Any
    block: Any
    wheels: Any
    parts: Any
    memory: Any
    source: Any
    schedule: Any
    taper: Any
    """Of the last parts as gauged, um, shape (N,)."""


@functools.cache
def traverses_step(process: Process, gauge: Gauge) -> Callable[..., None]:
    """The compiled step of G83 blocks."""
    (begin, settle_one), grind_traverses = floor_of(process, gauge), zoned_loops_of(COURSES["G83"], process).lanes

    @entry
    def prepare(tables: CrossTables, episodes: CrossArrays, choices: Choices, active: Any, results: Any) -> None:
        """Write the cycles of the coming blocks, and lay new parts; every block is a part.

        The wheel sets out from the surface: the stroke to the primary point makes no cut, and each pick a traverse.
        """
        shop, zones = read_shop(tables.shops, 0), tables.zones
        for i in active:
            kind, row, drive = begin(i, tables, episodes, shop, choices.speeds[i], results)
            first = min(kind.pick, row.stock)
            stroking = block_stroking(kind, shop, drive, choices.speeds[i], first, row.stock)
            cycle = TraverseCycle(
                depth=row.stock,
                primary_pick=kind.pick,
                secondary_pick=kind.pick,
                width=abs(tables.crossover),
                primary_cross_pick=tables.cross_pick,
                secondary_cross_pick=tables.cross_pick,
                at_depth=kind.sparkout + 1.0,
                executions=choices.executions[i],
                pre_dress=choices.pre_dresses[i],
            )
            write_stroking(tables.cycles, i, crossing(stroking, (0.0, tables.crossover)))
            write_traverse(tables.cycles, i, cycle)
            for k in range(zones.shape[0]):
                for field in range(zones.shape[1]):
                    tables.surfaces[i, k, field] = zones[k, field]

    @entry
    def grind(tables: CrossTables, episodes: CrossArrays, choices: Choices, active: Any, results: Any) -> None:
        """Run the cycles."""
        order = np.empty(active.size, np.int64)
        longest_traverses(tables.cycles, active, order)
        grind_traverses(
            tables.cycles, tables.parameters, episodes.wheels, tables.surfaces, results, NO_MOTIONS, order, 0, 1
        )

    @entry
    def settle(
        tables: CrossTables, episodes: CrossArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
        """As for G82 blocks, on parts that are judged where they are worst."""
        shop, sigmas = read_shop(tables.shops, 0), read_sigmas(tables.spreads, 0)
        source = episodes.source
        for i in active:
            stock = read_stroking(tables.cycles, i).finish
            found = gauge_zones(tables.surfaces[i], stock)
            write_part(episodes.parts, i, PartState(Z=stock, S=stock - 0.001 * found.worst_error, Rs=found.Ra))
            word, _, _, _ = words_of(source[i, KEY_0], source[i, KEY_1], TAPER, episodes.block[i])
            spread = source[i, NOISE_FACTOR] * sigmas.measurement * TAPER_NOISE
            episodes.taper[i] = found.taper + deviation(spread, word)
            settle_one(i, tables, episodes, choices, shop, results, outcomes)
        draw_coming(tables, episodes, active)

    return step_of(Work(CrossTables, CrossArrays, Choices, prepare, grind, settle))
