"""What stands in the way of moves outside the cycles, and feeds of theirs that the machine does not make."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from grind_env.control import Arc, Line, Motion, Source
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.machine import advice
from grind_env.machine.clearance import CRASH, Depths, into_part, into_table, pass_depths
from grind_env.machine.dress_program import DEEPEST_INFEED
from grind_env.machine.job import Job
from grind_env.machine.limits import beyond_feeds
from grind_env.machine.mounting import first_diameter
from grind_env.machine.part import PartRun
from grind_env.machine.wheel_body import over_diamond

WATCHED = (Source.PROGRAM, Source.COMPENSATION, Source.INTERRUPT)
"""Sources of the motions of the program itself, and of those that the operator asks for in between: of these it is only
known whether they grind the part."""


class FeedPass(NamedTuple):
    """A feed move of the program that grinds the part, which is not simulated."""

    line: int
    depths: Depths


def judged_moves(
    part: PartRun, job: Job, moves: Iterable[tuple[Motion, bool]], axis: int
) -> Iterator[tuple[int, str, str] | FeedPass]:
    """Line, subject and sentence of what is wrong with moves, and the passes among them.

    Of several that run into something, one after the other, the first is told, and of those of a dress program, whose
    way back is its way out.

    Args:
        part: on the machine.
        job: the job.
        moves: each with whether it is known where it begins.
        axis: the reciprocating axis.
    """
    inside, dressed = False, 0.0
    for move, found in moves:
        depths, below, text = ground_by(part, job, move, axis, found), -math.inf, ""
        if depths is not None:
            yield FeedPass(move.line, depths)
        elif move.source is not Source.INTERRUPT:
            below, text = _obstacle(part, job, move, axis, dressed, found)
        if text and not inside:
            yield move.line, "crash", text
        inside = depths is not None or bool(text) or (inside and move.source in (Source.DRESS, Source.RETRACE))
        if isinstance(move, Line) and move.source is not Source.INTERRUPT:
            dressed = max(dressed, below)
            beyond = beyond_feeds(move, axis, job.setup.machine)
            if beyond is not None:
                yield move.line, "feed", beyond


def ground_by(part: PartRun, job: Job, move: Motion, axis: int, found: bool) -> Depths | None:
    """Between which depths a move grinds the part, mm; None if it is no feed move, or one of a dress."""
    if not isinstance(move, Line | Arc) or move.source not in WATCHED:
        return None
    return pass_depths(part, move, axis, 0.5 * first_diameter(job), found=found)


def _obstacle(part: PartRun, job: Job, move: Motion, axis: int, dressed: float, found: bool) -> tuple[float, str]:
    """How far a move takes the wheel below the tip of the diamond, mm, and what to say of what stands in its way.

    Args:
        part: on the machine.
        job: the job.
        move: the move.
        axis: the reciprocating axis.
        dressed: how far moves before have taken the wheel below the tip, mm.
        found: whether it is known where it begins.
    """
    radius, below = 0.5 * first_diameter(job), -math.inf
    depth = into_part(part, move, axis, radius, found=found)
    if depth > CRASH + DEPTH_TOLERANCE:
        return below, advice.crash(depth, move)
    if found and (depth := into_table(part, move, axis)) > CRASH + DEPTH_TOLERANCE:
        return below, advice.table_crash(depth, move)
    if found and job.diamond is not None:
        below, _ = over_diamond(job.diamond.tip, move, axis, radius, job.setup.wheel.width)
        infeed = DEEPEST_INFEED if isinstance(move, Line) else CRASH
        if below > dressed + infeed + DEPTH_TOLERANCE:
            return below, advice.diamond_crash(below - dressed, move)
    return below, ""
