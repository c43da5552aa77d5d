"""A script in numbers for compiled replays: a row for every cycle block and every motion beside the table."""

import itertools
import math
from collections import namedtuple
from collections.abc import Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.control import CyclePlan, Line, Position
from grind_env.control.cycle_formulas import INSTANT
from grind_env.control.cycles import RULES
from grind_env.machine.axis_roles import plunge_axis
from grind_env.machine.job import Job, Part
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS
from grind_env.machine.loops.concurrent_strokes import ENDS, GOES_ON, FeedMotion
from grind_env.machine.loops.zone_layout import EDGES, strip_centres, strip_zones, zones_of
from grind_env.machine.part.feed_moves import FEED
from grind_env.machine.script.block_settings import BlockSettings, own_settings
from grind_env.machine.script.script import Script
from grind_env.machine.script.script_block import ScriptBlock, edge_of, jobs_of, script_error
from grind_env.process.cost import Limits

NO_CYCLE = 0.0
NUMBERS = {code: float(number) for number, code in enumerate(CYCLE_KERNELS, 1)}  #: numbers of the cycles that plunge

SINGLE = "G82"  #: code of the cycle that stands for a feed move: one stroke from a wheel that stands at its depth

NO_BLOCK = -1.0
AS_PRIMARY = -1.0  #: value for a block without a Q


class BlockRow(NamedTuple):
    """A cycle block of a script in numbers. Depths are mm from the touched-off surface, into the part.

    `start` is mm into the part, too, but from the zero of the axes. `surface`, `bottom`, `cross_start` and `cross_end`
    are mm. The limits are `rise` in K, `power` in W, `roughness` and `size` in um.
    """

    cycle: float  #: number of its cycle in `NUMBERS`; `NO_CYCLE` if all its strokes lie beside motions
    first_length: float  #: distance from the start point to the primary point, mm
    starts_elsewhere: float  #: 1 if the table does not start at its secondary point, else 0
    stroke_length: float  #: distance between the reversal points, mm
    off: float  #: distance of the middle of the part from the middle of the reversal points, mm
    dwell: float  #: dwell at a reversal point, s
    acceleration: float  #: acceleration of the table, mm/s2
    #: depth at which the wheel stands when the cycle begins, mm; the next two are as in `cycle.Stroking`, too
    start: float
    surface: float
    bottom: float
    coverage: float  #: 1 if a pass over the part at full depth precedes those of L, else 0
    takes_dresses: float  #: 1 if the block may have a D word, else 0
    #: depth of the deepest stroke of its stage of the part with the words of the program, mm. With another E the last
    #: stroke beside an infeed, which no dwell follows, may lie elsewhere in a later block
    finish: float
    #: depth of the deepest stroke in the other blocks of that stage and of the stages before, mm
    finish_of_other_blocks: float
    reached: float  #: depth that strokes on the part have reached at the end of the block, mm
    width: float  #: width of the part, mm
    length: float  #: length of the part, mm
    place: float  #: coordinate of the middle of the part along the table, mm
    #: cross coordinate of the wheel's minus edge at the begin of the crossover, mm; the next field: at its end
    cross_start: float
    cross_end: float
    motion: float  #: index of its first motion beside the table; `NO_BLOCK` without any
    gauged_at: float  #: time in these motions at which the operator gauges the part, s; infinite without gauging
    to_secondary: float  #: 1 if the next cycle takes over the table, else 0
    starts_part: float  #: 1 if the block is the first on its part, else 0
    wait: float  #: least time from the stop before it, at which parts are loaded or gauged, until the block begins, s
    ends_part: float  #: 1 if the part is taken off after the block, else 0
    #: 1 if the operator gauges or takes off the part after the block, so that the wheel wear is known; else 0
    gauged: float
    judged: float  #: 1 if a stage of the part ends after the block, else 0
    counts_all: float  #: 1 if the heat of every plunge of the stage counts, else 0
    #: limit of the stage on the temperature rise, K; the next three limits are as in `process.cost.Limits`, too
    rise: float
    power: float
    roughness: float
    size: float
    #: stock to grind off by the end of the stage, mm; 0 at the end of the part, where the true stock counts
    stock: float


CYCLE = BlockRow._fields.index("cycle")

PLAN = ("depth", *(each.name for each in fields(CyclePlan) if each.type in (bool, int, float)))
PlanRow: Any = namedtuple("PlanRow", PLAN)  # type: ignore[misc]
"""The `CyclePlan` of a block in numbers; `cycle_of` of its rules makes the numbers of the rules from it.

`depth` is the depth of the strokes, rounded as they are. `secondary_pick` is `AS_PRIMARY` if the block has no Q, and
`pre_dress` is 1 for the .1 forms if there is a dress to run.
"""


class ScriptTables(NamedTuple):
    """A script in numbers. All fields are tables in the units of their columns."""

    blocks: Array  #: shape (blocks, fields of `BlockRow`)
    plans: Array  #: shape (blocks, fields of `PlanRow`)
    own_settings: Array  #: settings of the blocks in the program, shape (blocks, fields of `BlockSettings`)
    #: times from each block to the next one, as `ScriptBlock.rest_times`, shape (blocks, 4, fields of `RestTimes`)
    rest_times: Array
    motions: Array  #: motions of all blocks beside the moving table, shape (motions, fields of `FeedMotion`)
    #: a new part, shape (zones, 1 or blocks, fields of `Zone`); one zone if the wheel covers the part in every stroke.
    #: If parts are unlike, each block has its part
    zones: Array


def tables_of(script: Script) -> ScriptTables:
    """Return a script in numbers."""
    motions: list[FeedMotion] = []
    rows: list[BlockRow] = []
    depths: list[float] = []
    starts, reached, first_of_part, first_of_stage, stage = True, 0.0, 0, 0, 0
    for number, (block, job) in enumerate(zip(script.blocks, jobs_of(script.job, script.blocks), strict=True)):
        stages = job.part.stages
        if starts:
            reached, first_of_part, first_of_stage, stage = 0.0, number, number, 0
        gauged = number > 0 and script.blocks[number - 1].gauged_at_rest
        wait = job.times.load if starts and block.loads else job.times.gauge if gauged else 0.0
        beside = _motions_of(block, job)
        depths.append(_deepest(block, job))
        reached = max(reached, depths[-1])
        ends_stage = block.stops > 0 and stage < len(stages)
        judged = block.ends_part or ends_stage
        asked = stages[stage] if ends_stage else job.part
        motion, stock = float(len(motions)) if beside else NO_BLOCK, asked.stock if ends_stage else 0.0
        row = _row(block, job, job.limits_at(asked), reached, starts)
        rows.append(row._replace(motion=motion, wait=wait, judged=float(judged), stock=stock))
        motions += beside
        if judged:
            for k in range(first_of_stage, number + 1):
                others = depths[first_of_part:k] + depths[k + 1 :]
                rows[k] = rows[k]._replace(
                    finish=reached,
                    finish_of_other_blocks=max(others, default=0.0),
                    counts_all=float(asked.rise_allowance > 0.0),
                )
            first_of_stage, stage = number + 1, stage + 1
        starts = block.ends_part
    plans = [_plan_row(block, row) for block, row in zip(script.blocks, rows, strict=True)]
    own = [own_settings(block.plan, block.dress_plan) for block in script.blocks]
    rest_times = np.array([block.rest_times for block in script.blocks], np.float64).reshape(len(rows), 4, 2)
    zones = _zones(script, rows)
    blocks = _table(rows, BlockRow), _table(plans, PlanRow)
    return ScriptTables(*blocks, _table(own, BlockSettings), rest_times, _table(motions, FeedMotion), zones)


def is_covered(script: Script, tables: ScriptTables) -> bool:
    """Return whether the wheel covers the parts of a script in every stroke, and no cycle crosses."""
    wheel = script.job.setup.wheel

    def covers(block: ScriptBlock, job: Job) -> bool:
        # a single zone may also never be under the wheel
        middle, edge = strip_centres(job.part.across, job.part.width)[0], edge_of(block.start, block.plan)
        return block.plan.cross_axis is None and bool(edge <= middle < edge + wheel.width)

    jobs = jobs_of(script.job, script.blocks)
    return len(tables.zones) == 1 and all(itertools.starmap(covers, zip(script.blocks, jobs, strict=True)))


def _table(rows: list[Any], kind: type[Any]) -> Array:
    return np.array(rows, np.float64).reshape(len(rows), len(kind._fields))


def _row(block: ScriptBlock, job: Job, limits: Limits, reached: float, starts: bool) -> BlockRow:
    plan, part = block.plan, job.part
    first = block.start[plan.axis]
    stands = block.start[plunge_axis(plan.axis)]
    edge = edge_of(block.start, plan)
    crosses = plan.cross_axis is not None
    by_feed = plan.code == FEED
    return BlockRow(
        cycle=NUMBERS[SINGLE if by_feed else plan.code] if block.strokes_alone else NO_CYCLE,
        first_length=abs(plan.primary - first),
        starts_elsewhere=float(first != plan.secondary and not block.taken_over),
        stroke_length=abs(plan.primary - plan.secondary),
        off=part.off(plan.primary, plan.secondary),
        dwell=0.0 if by_feed else job.control.reversal_dwell,
        acceleration=job.control.acceleration,
        start=-stands,
        surface=part.surface,
        bottom=part.surface - _target(block),
        coverage=float(job.control.coverage_pass and not by_feed),
        takes_dresses=float(block.takes_dresses),
        finish=reached,
        finish_of_other_blocks=reached,
        reached=reached,
        width=part.width,
        length=part.length,
        place=part.start + 0.5 * part.length,
        cross_start=plan.cross_start if crosses else edge,
        cross_end=plan.cross_end if crosses else edge,
        motion=NO_BLOCK,
        gauged_at=sum(each.seconds for each in block.side_motions) + INSTANT if block.gauged_on_the_way else math.inf,
        to_secondary=float(block.to_secondary),
        starts_part=float(starts),
        wait=0.0,
        ends_part=float(block.ends_part),
        gauged=float(block.gauged),
        judged=0.0,
        counts_all=0.0,
        rise=limits.rise,
        power=limits.power,
        roughness=limits.roughness,
        size=limits.size,
        stock=0.0,
    )


def _plan_row(block: ScriptBlock, row: BlockRow) -> Any:
    numbers = {name: float(getattr(block.plan, name)) for name in PLAN}
    numbers["depth"] = -_target(block) - row.start
    has_own = any(word.letter == "Q" for word in block.block.words)
    numbers["secondary_pick"] = block.plan.secondary_pick if has_own else AS_PRIMARY
    numbers["pre_dress"] = float(block.plan.pre_dress and block.dress is not None)
    return PlanRow(**numbers)


def _target(block: ScriptBlock) -> float:
    return block.start[plunge_axis(block.plan.axis)] if block.plan.plunge_axis is None else block.plan.depth_target


def _deepest(block: ScriptBlock, job: Job) -> float:
    """Return the depth of the strokes of a block, mm; the depth of a cycle counts in any case, as in a run."""
    plan = block.plan
    return block.reached if plan.plunge_axis is None else max(block.reached, job.part.surface - plan.depth_target)


def _motions_of(block: ScriptBlock, job: Job) -> list[FeedMotion]:
    """Return the motions beside the table, in depth from the zero of the axes, and the rest after them."""
    plan, plunge, total = block.plan, plunge_axis(block.plan.axis), sum(motion.seconds for motion in block.side_motions)

    def leg(begin: float, seconds: float, start: Position, end: Position, rate: float, after: float) -> FeedMotion:
        depth, edge = -start[plunge], edge_of(start, plan)
        way, across = -end[plunge] - depth, edge_of(end, plan) - edge
        return FeedMotion(
            begin=begin,
            end=begin + seconds,
            depth=depth,
            way=way,
            cross=edge,
            cross_way=across,
            path=float(np.hypot(way, across)),
            rate=rate,
            last_begin=total - INSTANT,
            leg_seconds=total,
            after=after,
        )

    time, rows = 0.0, []
    for motion in block.side_motions:
        feed = motion.feed if isinstance(motion, Line) else job.control.rapid_feed
        rows.append(leg(time, motion.seconds, motion.start, motion.end, feed / 60.0, GOES_ON))
        time += motion.seconds
    if not (rows or block.to_secondary or block.gauged_on_the_way) and block.strokes_alone:
        return []
    end = block.side_motions[-1].end if rows else block.end
    return [*rows, leg(total, 0.0, end, end, 1.0, ENDS)]


def _zones(script: Script, rows: Sequence[BlockRow]) -> Array:
    """Return new parts in zones, as in `ScriptTables`; unlike stations must have equal numbers of strips or zones."""
    if not (script.job.stations and rows):
        return _zones_of(script.job, script.blocks, rows)[:, None]
    jobs, blocks = list(jobs_of(script.job, script.blocks)), dict[Part, list[int]]()
    for number, job in enumerate(jobs):
        blocks.setdefault(job.part, []).append(number)
    zones = {
        part: _zones_of(jobs[numbers[0]], [script.blocks[k] for k in numbers], [rows[k] for k in numbers])
        for part, numbers in blocks.items()
    }
    if len({len(each) for each in zones.values()}) > 1:
        reason = "the parts at its stations are ground in unlike numbers of strips"
        raise script_error(script.programs, 0, reason)
    return np.stack([zones[job.part] for job in jobs], axis=1)


def _zones_of(job: Job, blocks: Sequence[ScriptBlock], rows: Sequence[BlockRow]) -> Array:
    """Return a new part in zones; each strip is a zone if the wheel crosses beside the moving table."""
    part, wheel = job.part, job.setup.wheel
    centres, edges = strip_centres(part.across, part.width), set()
    for block, row in zip(blocks, rows, strict=True):
        places = {edge_of(each, block.plan) for motion in block.side_motions for each in (motion.start, motion.end)}
        if len(places) > 1:
            return strip_zones(centres)
        edges |= {row.cross_start, *places}
        if block.plan.cross_axis is not None:
            code, coverage = block.plan.code, job.control.coverage_pass
            edges |= set(EDGES[code](RULES[code].cycle_of(block.plan, coverage), row.cross_start, row.cross_end))
    return zones_of(centres, edges, wheel.width)
