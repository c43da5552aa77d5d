"""The script of a program that is run for many parts, from that of a few runs of it, where these are alike.

A control that begins a run where it began the one before it, in a program whose blocks are the same in every run, does
the same in all that follow.
"""

import re
from dataclasses import fields, replace

from grind_env.control import Line, Motion, Programs
from grind_env.machine.axes import plunge_axis
from grind_env.machine.job import Job
from grind_env.machine.script.block import ScriptBlock, edge_of
from grind_env.machine.script.parts import met_by
from grind_env.machine.script.script import Script

FEW = 4
"""Runs that show what all do: the first one, which may begin elsewhere, two that are to be alike, and the last one."""

_COMMENT = re.compile(r"\([^()]*\)")
_CARRIES = re.compile(r"#|GOTO|G[ \t]*0*10(?![0-9.])", re.IGNORECASE)
"""What may tell one run of a program from the next: variables, jumps, and entries of tables that add up."""


def is_straight(programs: Programs) -> bool:
    """Whether a program executes the same blocks in every run, with the same numbers."""
    return not any(_CARRIES.search(_COMMENT.sub("", source.text)) for program in programs for source in program.blocks)


def repeated(script: Script, runs: int) -> Script | None:
    """The script of so many runs of a program, from that of `FEW`; None if it may do something else in one of them."""
    count, left = divmod(len(script.blocks), FEW)
    first, second, third, last = (script.blocks[k * count : (k + 1) * count] for k in range(FEW))
    if left or not is_straight(script.programs) or [*map(_done, second)] != [*map(_done, third)]:
        return None
    return replace(script, blocks=(*first, *(runs - 2) * second, *last))


def with_job(script: Script, job: Job) -> Script:
    """The same for a job that asks for something else of its parts, or has a stronger spindle."""
    return replace(script, job=replace(job, met=met_by(script.programs, job, script.blocks)))


def _done(block: ScriptBlock) -> list[object]:
    """What a block does, wherever it stands in a text and whenever it begins."""
    beside = [_moved(motion, block) for motion in block.beside]
    others = [getattr(block, each.name) for each in fields(block) if each.name not in ("block", "plan", "beside")]
    return [block.block.words, replace(block.plan, block=0, line=0), beside, *others]


def _moved(motion: Motion, block: ScriptBlock) -> tuple[object, ...]:
    """What a motion does beside the table, which may be anywhere."""
    plunge, plan = plunge_axis(block.plan.axis), block.plan
    ends = [(each[plunge], edge_of(each, plan)) for each in (motion.start, motion.end)]
    return type(motion), motion.seconds, motion.feed if isinstance(motion, Line) else 0.0, *ends
