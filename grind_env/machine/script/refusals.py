"""Reasons why a program has no script: strokes depend on more than its words, or on words that may be chosen."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from grind_env.control import Programs
from grind_env.control.cycle_formulas import motion_time, pick_window
from grind_env.control.motion_paths import AXES
from grind_env.control.motion_profile import ramp_time
from grind_env.machine.job import Job
from grind_env.machine.script.block_settings import Ranges
from grind_env.machine.script.script_block import ScriptBlock, edge_of, script_error

#: requirements on a part that may differ from one to the next in a script
REQUIREMENTS = ("stock", "roughness_limit", "tolerance", "rise_allowance", "scrap_cost")


def refuse_led_elsewhere(
    programs: Programs, block: ScriptBlock, turned: ScriptBlock, across: ScriptBlock, both: ScriptBlock
) -> None:
    """Refuse a block whose place depends on chosen words, in the blocks before or in the block itself.

    In `turned` the table came to rest at its other end, in `across` crossovers ended at theirs, in `both` both.
    """
    line = block.plan.line
    if turned.start != block.start:
        raise script_error(programs, line, "its first stroke depends on where the table came to rest before")
    if across.start != block.start or both.start != block.start:
        raise script_error(
            programs, line, "its place depends on where the crossover before came to its end: on J and L"
        )
    motions, other = ([edge_of(motion.start, each.plan) for motion in each.side_motions] for each in (block, across))
    if other != motions or (block.gauged_on_the_way and across.end != block.end):
        raise script_error(
            programs, line, "the table strokes on where its crossover came to its end, which depends on J and L"
        )


def refuse_slow_picks(programs: Programs, job: Job, block: ScriptBlock, ranges: Ranges) -> None:
    """Refuse picks that are still under way in the middle of a stroke, or when a dress is due.

    A longer pick takes more time, so that the highest J decides.
    """
    plan, control = block.plan, job.control
    if not plan.plunges:
        return
    length, rate = abs(plan.primary - plan.secondary), min(plan.pick_feed, control.maximum_feed) / 60.0
    plunge = max([plan.primary_pick, plan.secondary_pick, *ranges.J])
    most = max(plunge, plan.primary_cross_pick, plan.secondary_cross_pick)
    seconds, plunging = (motion_time(pick, rate, control.acceleration) for pick in (most, plunge))
    for stroke in (length, abs(plan.primary - block.start[plan.axis])):
        for speed in _speeds_between(
            plan.feed / 60.0, [speed / 60.0 for speed in ranges.E], length, control.acceleration
        ):
            ramp, dwell = ramp_time(stroke, speed, control.acceleration), control.reversal_dwell
            at = f"at E{60.0 * speed:g} mm/min"
            if seconds > pick_window(ramp, dwell, motion_time(length, speed, control.acceleration)):
                reason = "a pick is still under way in the middle of the stroke after it"
                raise script_error(programs, plan.line, f"{reason}, one of {most:g} mm {at}")
            if block.takes_dresses and plunging > ramp + dwell:
                raise script_error(programs, plan.line, f"a dress waits for a pick to end, one of {plunge:g} mm {at}")


def _speeds_between(own: float, ends: Sequence[float], length: float, acceleration: float) -> Iterator[float]:
    """Yield table speeds, mm/s; one of them has the shortest time from a pick to the middle of a stroke."""
    yield own
    yield from ends
    if ends:
        # the least of ramp + half a stroke, 1.5 v/a + 0.5 length/v
        yield min(max(math.sqrt(acceleration * length / 3.0), min(ends)), max(ends))


def refuse_turns_inside(programs: Programs, job: Job, block: ScriptBlock) -> None:
    """Refuse strokes that do not pass over the whole length of the part."""
    plan, part = block.plan, job.part
    first = block.start[plan.axis]
    for ends in ((plan.primary, plan.secondary), (first, plan.primary)):
        if not (min(ends) <= part.start and part.start + part.length <= max(ends)):
            place = f"{AXES[plan.axis]} turns over the part or beside it"
            raise script_error(programs, plan.line, f"{place}, from {min(ends):g} to {max(ends):g} mm")


def refuse_unlike_parts(programs: Programs, job: Job) -> None:
    """Refuse parts that differ from the job's part in more than price and limits."""
    for number in range(1, len(job.parts) + 1):
        part, asked = job.of_part(number).part, {name: getattr(job.part, name) for name in REQUIREMENTS}
        if replace(part, **asked) != job.part:
            raise script_error(programs, 0, f"part {number} differs from part 1 in more than {', '.join(REQUIREMENTS)}")


def refuse_judged_twice(programs: Programs, job: Job, blocks: Sequence[ScriptBlock]) -> None:
    """Refuse stages that end without a cycle of their own."""
    left = len(job.of_part(1).part.stages)
    part = 1
    for block in blocks:
        ended = min(block.stops, left)
        if ended + block.ends_part > 1:
            raise script_error(programs, block.plan.line, "after this cycle the part is judged more than once")
        part += block.ends_part
        left = len(job.of_part(part).part.stages) if block.ends_part else left - ended
