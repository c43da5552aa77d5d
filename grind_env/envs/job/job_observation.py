"""The observation before a cycle block of a user's job: readings of earlier blocks, and the coming block.

Names, scales and noise are as in `observations` for the same quantities.
"""

from collections.abc import Container, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grind_env.control.cycles import RULES
from grind_env.envs.job.job_noise_tape import spreads
from grind_env.envs.job.program_outline import BlockOutline
from grind_env.envs.observations import BOOK, PART_RISE, Reading, of_few_parts, readings
from grind_env.envs.task_gauges import ROUGHNESS_NOISE, SIZE_NOISE
from grind_env.envs.tasks import ActionRange, Kind, Spread, Task, load_task
from grind_env.envs.tasks.tables import USUAL_SPEEDS, Start
from grind_env.machine.job import Job, JobError, Part

SEEN = (
    *("mean_power", "first_power", "peak_power", "last_speed", "last_executions", "last_pick", "size_error"),
    *("roughness", "parts_since_gauged", "volume", "blocks_since_dress", "dresses", "diameter", "pick", "depth"),
    *("sparkout", "takes_dresses", "starts_part", "new_lot", "remaining"),
    *(f"coming_{code}" for code in RULES),
)
HIDDEN = (
    *("wear_flat", "loading", "diamond_flat", "dressed_roughness", "dressed_density", "wheel_volume", "growth"),
    *("pressure", "convection", "fracture", "wear", "roughness_scale", "part_rise"),
)


def job_readings(task: Task, constant: Container[str], *, full: bool) -> tuple[Reading, ...]:
    """Return the observation of a job, entry by entry, the hidden ones last."""
    spread = task.spread.measurement
    wheel_noise = f"{2.0 * SIZE_NOISE * spread:g} um" if spread > 0.0 else "to 1 um"
    ra_noise = f"{100.0 * ROUGHNESS_NOISE * spread:g} %, " if spread > 0.0 else ""
    own = [
        Reading("last_pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "greatest depth per stroke of the last block"),
        Reading("roughness", "Ra/limit", 0.0, 1.0, 0.0, 5.0, f"{ra_noise}every third part, one part late",
                "Ra of the last gauged part over its limit; 0 without a limit"),
        Reading("volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "exact",
                "volume programmed since the last dress per width of the wheel in use, by book-keeping"),
        Reading("diameter", "mm", 220.0, 80.0, -2.5, 5.0, wheel_noise, f"wheel diameter (offset 33), {BOOK}"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "J of the coming block, 0 in a G81"),
        Reading("depth", "mm", 0.0, 0.3, 0.0, 5.0, "exact", "by which the part gets deeper until the following block"),
        Reading("sparkout", "", 0.0, 5.0, 0.0, 5.0, "exact", "L of the coming block"),
        Reading("takes_dresses", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block can have a D word"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block begins the first part of a lot"),
        *(Reading(f"coming_{code}", "", 0.0, 1.0, 0.0, 1.0, "exact", f"1 if the coming block is a {code}")
          for code in RULES),
    ]  # fmt: skip
    known = {entry.name: entry for entry in (*readings(task, full=True), PART_RISE, *own)}
    return tuple(known[name] for name in ((*SEEN, *HIDDEN) if full else SEEN) if name not in constant)


def action_of(job: Job) -> ActionRange:
    """Return the usual E that the table reaches, above 1000 mm/min (else JobError), and D up to 3: more never paid."""
    slow, fast = USUAL_SPEEDS
    fastest = min(fast, job.setup.machine.maximum_table_speed)
    if fastest <= 1000.0:
        name = job.setup.machine.name
        raise JobError(f"maximum_table_speed of {name!r} is {fastest:g}, but E is chosen above 1000 mm/min: raise it")
    return ActionRange(executions=3, speed_range=(min(slow, max(1000.0, 0.5 * fastest)), fastest))


def job_task(name: str, job: Job, spread: float, file: str) -> Task:
    """Return a task with the limits and spreads of a job, and with the ranges that its actions and readings need.

    The other fields come from another task; the program decides the grinding.
    """
    task = load_task("power_limited")
    # a task asks for more of its parts than a job: whole micrometres, and no part wider than the wheel
    width = min(round(job.part.width, 3), task.wheel.width)
    return replace(
        task,
        name=name,
        title=name,
        file=file,
        action=action_of(job),
        setup=replace(task.setup, machine_overrides={"power_limit": job.setup.machine.power_limit}),
        kinds=(
            replace(
                task.kinds[0],
                stock=max(round(job.part.stock, 3), 0.001),
                width=width,
                length=round(job.part.length, 3),
                tolerance=job.part.tolerance,
                scrap=job.part.scrap_cost,
            ),
        ),
        spread=Spread(**spreads(job.lots, spread)),
        start=Start(volume=job.wheel.volume_since_dress or 0.0),
    )


def kinds_of(task: Task, blocks: Sequence[BlockOutline], job: Job) -> tuple[NDArray[np.int64], tuple[Kind, ...]]:
    """Return the kind of each block, and the kinds: equal texts at the same place of equal parts are one kind."""
    numbers, known, kinds, place = [], dict[tuple[int, str, Part], int](), list[Kind](), 0
    for block in blocks:
        place = 1 if block.starts_part else place + 1
        key = place, block.block.source.text, job.of_part(block.part + 1).part
        if key not in known:
            known[key] = len(kinds)
            # its numbers are in `numbers.kind_of`: a program may have values that a task may not, such as no pick
            kinds.append(replace(task.kinds[0], name=f"block_{len(kinds) + 1}"))
        numbers.append(known[key])
    return np.array(numbers), tuple(kinds)


def constant_readings(blocks: Sequence[BlockOutline], job: Job, spread: float, *, picks: bool) -> dict[str, float]:
    """Return the measured readings, with values, that no choice, draw or context changes in a job.

    Readings of the last block before the first block, and of the coming block after the last block, do not count.
    """
    said = [{"pick": block.plan.primary_pick, "sparkout": float(block.plan.spark_out), **_said_of(block)}
            for block in blocks]  # fmt: skip
    constant = {name: said[0][name] for name in said[0] if len({each[name] for each in said}) == 1}
    if not picks and constant.get("pick", 0.0) > 0.0:
        constant["last_pick"] = constant["pick"]
    if all(block.dress is None for block in blocks):
        constant["dresses"] = 0.0
    if not any(block.takes_dresses for block in blocks):
        constant["last_executions"] = 0.0
    parts = blocks[-1].part + 1
    constant |= of_few_parts(parts, gauged=job.limits.roughness > 0.0)
    if parts == 1 or spread == 0.0 or job.lots.probability == 0.0:
        constant["new_lot"] = 0.0
    return constant


def _said_of(block: BlockOutline) -> dict[str, float]:
    """Return the observation entries of a block that the program alone decides, by name."""
    return {
        "depth": block.depth,
        "takes_dresses": float(block.takes_dresses),
        "starts_part": float(block.starts_part),
        **{f"coming_{code}": float(block.plan.code == code) for code in RULES},
    }


def coming(blocks: Sequence[BlockOutline], entries: Sequence[Reading]) -> NDArray[np.float64]:
    """Return entries that the program decides, shape (blocks + 1, entries); NaN for other entries, 0 at the end."""
    table = np.full((len(blocks) + 1, len(entries)), np.nan)
    for number, block in enumerate(blocks):
        said = _said_of(block)
        for k, entry in enumerate(entries):
            if entry.name in said:
                table[number, k] = np.clip((said[entry.name] - entry.offset) / entry.scale, entry.low, entry.high)
                table[-1, k] = 0.0
    return table
