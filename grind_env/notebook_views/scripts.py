"""View of a machine script: a row for each cycle block."""

from grind_env.machine.axis_roles import plunge_axis
from grind_env.machine.script.block_settings import own_settings
from grind_env.machine.script.script import Script
from grind_env.machine.script.script_block import ScriptBlock
from grind_env.notebook_views.markup import fragment, paragraphs, table

HEADINGS = ("block", "cycle", "depth at end, mm", "E, mm/min", "D", "J, mm", "L", "dress program", "a dress, s")


def html(script: Script) -> str:
    """Return the blocks of a script as HTML, in the order in which they run."""
    count, parts = len(script.blocks), sum(block.ends_part for block in script.blocks)
    said = f"{_counted(count, 'cycle block')}, {_counted(parts, 'part')}; {script.approach:.1f} s up to the first block"
    rows = [_row(block, script) for block in script.blocks]
    return fragment(f"script of {script.programs.name}", table(HEADINGS, rows, left=2), paragraphs([said]))


def _row(block: ScriptBlock, script: Script) -> list[str]:
    plan, settings = block.plan, own_settings(block.plan, block.dress_plan)
    words = [f"{settings.J:g}", f"{settings.L:g}"] if plan.plunges else ["", ""]
    dress = ["", ""] if block.dress is None else [f"O{plan.program}", f"{settings.dress_seconds:.1f}"]
    depth = f"{script.job.part.surface - block.end[plunge_axis(plan.axis)]:.4g}"
    return [f"N{plan.block}", plan.code, depth, f"{settings.E:g}", f"{settings.D:g}", *words, *dress]


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'s' * (count != 1)}"
