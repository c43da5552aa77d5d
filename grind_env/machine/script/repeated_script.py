"""The script of a program for many parts, extended from a few runs that are alike.

If a run begins in the state of the run before, and the blocks are equal in every run, the control does the same in all
later runs.
"""

from dataclasses import fields, replace

from grind_env.control import ControlError, Line, Motion, Programs
from grind_env.control.block_words import read_block
from grind_env.control.numbers import g_code
from grind_env.control.program_scanner import SourceText
from grind_env.machine.axis_roles import plunge_axis
from grind_env.machine.job import Job
from grind_env.machine.script.script import Script, stations_of_parts
from grind_env.machine.script.script_block import ScriptBlock, edge_of

#: number of runs that represent all: the first, which may begin elsewhere, two that must be equal, and the last
SAMPLE_RUNS = 4


def is_straight(programs: Programs) -> bool:
    """Return whether a program executes the same blocks with the same numbers in every run.

    Such a program has no variables and no jumps. It has no G10 either, because its table entries may add up.
    """
    return all(_is_straight(source) for program in programs for source in program.blocks)


def _is_straight(source: SourceText) -> bool:
    try:
        block = read_block(source)
        return block.is_plain and "G10" not in [g_code(block, word) for word in block.words if word.letter == "G"]
    except ControlError:  # it is refused when it is executed
        return False


def repeated(script: Script, runs: int) -> Script | None:
    """Return the script of many runs of a program, from the script of `SAMPLE_RUNS`; None if a run may differ.

    The text is checked here, because programs in other files are known only after their execution.
    """
    count, left = divmod(len(script.blocks), SAMPLE_RUNS)
    first, second, third, last = (script.blocks[k * count : (k + 1) * count] for k in range(SAMPLE_RUNS))
    if left or not is_straight(script.programs) or [*map(_comparable, second)] != [*map(_comparable, third)]:
        return None
    for block in script.blocks:
        plunge = plunge_axis(block.plan.axis)
        if any(motion.start[plunge] != motion.end[plunge] for motion in block.side_motions):
            return None  # the rounding of the depth of strokes changes with time
    return replace(script, blocks=(*first, *(runs - 2) * second, *last))


def with_job(script: Script, job: Job) -> Script:
    """Return the script for a job with other requirements on its parts, or with a stronger spindle."""
    return replace(script, job=replace(job, part_stations=stations_of_parts(script.programs, job, script.blocks)))


def _comparable(block: ScriptBlock) -> list[object]:
    motions = [_moved(motion, block) for motion in block.side_motions]
    others = [getattr(block, each.name) for each in fields(block) if each.name not in ("block", "plan", "side_motions")]
    return [block.block.words, replace(block.plan, block=0, line=0), motions, *others]


def _moved(motion: Motion, block: ScriptBlock) -> tuple[object, ...]:
    plunge, plan = plunge_axis(block.plan.axis), block.plan
    ends = [(each[plunge], edge_of(each, plan)) for each in (motion.start, motion.end)]
    return type(motion), motion.seconds, motion.feed if isinstance(motion, Line) else 0.0, *ends
