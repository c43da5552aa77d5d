"""Numbers of a job, its blocks and its possible machines, for costs and gauges."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grind_env.array_types import Table
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Shop
from grind_env.envs.job.program_outline import BlockOutline
from grind_env.envs.program_episode import BlockRun
from grind_env.machine.dress.mounted_wheel import first_wheel
from grind_env.machine.job import Job
from grind_env.machine.loops.concurrent_strokes import FULL
from grind_env.machine.loops.stroke_totals import NOTHING, POWER_WINDOW, Tally
from grind_env.machine.part.gauging import counted_rise

STROKES_AT_MOST = int(POWER_WINDOW)


def kind_of(block: BlockOutline, job: Job) -> KindRow:
    """Return the numbers of a block that cost and gauges need; the time of the script includes the loading."""
    part = job.part
    return KindRow(
        stock=part.stock,
        pick=block.plan.primary_pick,
        sparkout=float(block.plan.spark_out),
        width=part.width,
        # the volume since a dress is per width of the wheel in use
        length=part.length * part.width / min(part.width, job.setup.wheel.width),
        scrap=part.scrap_cost,
        starts_part=float(block.starts_part),
        ends_part=float(block.finished),
        counts_all=float(block.counts_all),
        **block.limits._asdict(),
    )


def shop_of(job: Job, reference_cost: float) -> Shop:
    """Return the numbers of a job that are equal for all blocks; each block has its own dress program."""
    rates, change = job.rates, job.times.wheel_change
    return Shop(
        hourly=rates.hourly,
        wheel_price=rates.wheel,
        dress_price=rates.dress,
        reference_cost=reference_cost,
        least_diameter=0.0 if change is None else job.setup.wheel.minimum_diameter,
        wheel_width=job.setup.wheel.width,
        new_diameter=job.setup.wheel.diameter,
        change_seconds=change or 0.0,
    )


def tally_of(run: BlockRun, job: Job, finish: float) -> Tally:
    """Return the tally of an executed block, up to the next block.

    The temperature rise of a block that finishes a part is that of the judged part. Otherwise it is the rise that
    counts if the stage ends at a depth of `finish`, mm.
    """
    strokes, plan = run.strokes, run.plan
    table, power = strokes["groove"] == 0, strokes["mean_load"]
    least = max(plan.primary_pick, plan.secondary_pick) - DEPTH_TOLERANCE
    if not plan.plunges:
        least = FULL * run.increments[table].max(initial=0.0)
    full = np.flatnonzero(table & (run.increments > DEPTH_TOLERANCE) & (run.increments >= least))
    since = int(run.dresses["after"][-1]) if run.dresses.size else 0
    first, last = full[:STROKES_AT_MOST], full[-STROKES_AT_MOST:]
    last = last[last >= since]
    ground = table | job.setup.grooving_wheel
    plunges = list(zip(*(strokes[name][run.plunged & table].tolist() for name in ("Z", "T")), strict=True))
    rise = [counted_rise(plunges, finish, every) for every in (True, False)]
    if run.finished.size:
        rise = [float(run.finished["rise"][-1])] * 2
    return NOTHING._replace(
        seconds=run.seconds,
        strokes=float(len(strokes)),
        dresses=float(run.dresses.size),
        first_power=float(power[first].sum()),
        first_count=float(first.size),
        power_1=float(power[last].sum()),
        last_count=float(last.size),
        deepened=float(np.maximum(run.increments[since:][ground[since:]], 0.0).sum()),
        peak_load=float(strokes["load"].max(initial=0.0)),
        peak_torque=float(strokes["torque"].max(initial=0.0)),
        plunge_rise=rise[0],
        finish_rise=rise[1],
        burn_ratio=float(strokes["burn_ratio"][run.plunged].max(initial=0.0)),
        worn=float(strokes["worn"].sum()),
        dressed_off=float(run.dresses["removed"].sum()),
    )


class JobMachines(NamedTuple):
    """M machines of one process, which may differ from the process of the job."""

    jobs: tuple[Job, ...]
    base: Table  #: parameters, shape (M, 1 or blocks, fields of `StrokeParameters`)
    cooler: Table  #: limits of temperature less those of the nominal job, K, shape (M, 1 or blocks)
    starts: Table  #: wheel before the first block, followed by the memory of the process, shape (M, fields of both)


def machines_of(jobs: Sequence[Job], blocks: Sequence[BlockOutline], nominal: Job) -> JobMachines:
    """Return the numbers of jobs that differ from a nominal one in their entries, for the program's blocks."""
    limits, first = _rises(nominal, blocks), blocks[0]
    wheels = [first_wheel(job, first.dress, job.of_part(first.part + 1).parameters) for job in jobs]
    return JobMachines(
        jobs=tuple(jobs),
        base=np.array([[each.parameters for each in _by_block(job, blocks)] for job in jobs]),
        cooler=np.array([np.subtract(_rises(job, blocks), limits) for job in jobs]),
        starts=np.array([(*wheel, *job.own_at_start) for wheel, job in zip(wheels, jobs, strict=True)]),
    )


def _by_block(job: Job, blocks: Sequence[BlockOutline]) -> list[Job]:
    """Return the job of each block if parts may differ, else a list of the one job."""
    return [job.of_part(block.part + 1) for block in blocks] if job.stations else [job]


def _rises(job: Job, blocks: Sequence[BlockOutline]) -> list[float]:
    return [each.limits.rise for each in _by_block(job, blocks)]
