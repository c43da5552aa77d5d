"""The script of a task: a row for every pair of kind and material; depths come from the noise tape."""

from dataclasses import replace

import numpy as np

from grind_env.array_types import Table
from grind_env.control import CycleAhead, CycleStart, Motion, execute, read
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.blocks.task_job import job_of
from grind_env.envs.blocks.task_program import CycleBlock, program_of
from grind_env.envs.tasks import Kind, Task
from grind_env.machine.script.block_settings import DRESS_PASSES, OWN_WORDS
from grind_env.machine.script.script import Script
from grind_env.machine.script.script_block import RestTimes, ScriptBlock
from grind_env.machine.script.script_tables import BlockRow, ScriptTables, is_covered, tables_of


def task_script(task: Task, kinds: Table) -> tuple[ScriptTables, Table, bool]:
    """Return the script of a task; `kinds` are the numbers of its kinds, shape (rows, fields of `KindRow`).

    The second value is the depth below the surface at which the cycle of each row begins, mm, shape (rows,). The third
    says whether the wheel covers the parts. The wheel moves to a block while the machine waits for the part.
    """
    scripts = [_script_of(task, kind) for kind in task.kinds]
    found = [tables_of(script) for script in scripts]
    rows = np.arange(len(kinds)) // len(task.materials)
    plans, own, rest_times = (np.concatenate([each[k] for each in found])[rows] for k in (1, 2, 3))
    # the mean infeed of a dress program is off by rounding
    own[:, DRESS_PASSES:] = task.dress.passes, task.dress_feed, task.dress.depth, task.dress_seconds
    blocks = [
        _row(task, task.kinds[k], BlockRow(*found[k].blocks[0]), KindRow(*row))
        for k, row in zip(rows.tolist(), kinds.tolist(), strict=True)
    ]
    zones = np.concatenate([found[k].zones for k in rows.tolist()], axis=1)
    tables = ScriptTables(np.array(blocks), plans, own, rest_times, found[0].motions, zones)
    lead = np.array([task.kinds[k].pick if task.cycle == "G82" else 0.0 for k in rows.tolist()])
    return tables, lead, all(map(is_covered, scripts, found))


def _script_of(task: Task, kind: Kind) -> Script:
    """Return the script of a block on a part of its own."""
    block = CycleBlock(replace(kind, starts_part=True), 0.0, kind.stock, task.action.speed_ends[0])
    programs, job, stands = read(program_of(task, [block])), job_of(task, [block]), (0.0, 0.0, 0.0)
    events = execute(programs, replace(job.control, announce_cycles=True))
    for event in events:
        if isinstance(event, Motion):
            stands = event.end
        elif isinstance(event, CycleAhead):
            text = event.block
        elif isinstance(event, CycleStart):
            plan = event.plan
            break
    rest_times = (RestTimes(),) * 4
    ground = ScriptBlock(text, False, plan, stands, stands, False, None, rest_times=rest_times, ends_part=True)
    return Script(programs, job, (ground,), 0.0, OWN_WORDS)


def _row(task: Task, kind: Kind, row: BlockRow, numbers: KindRow) -> BlockRow:
    """Return the script row of a kind; after each block the part is gauged and judged by the limits of the kind."""
    limits = {name: getattr(numbers, name) for name in ("rise", "power", "roughness", "size", "counts_all")}
    begins = {"starts_part": numbers.starts_part, "ends_part": numbers.ends_part, "wait": task.wait_seconds(kind)}
    return row._replace(**limits, **begins, gauged=1.0, judged=1.0, stock=0.0)
