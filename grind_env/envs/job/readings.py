"""What an agent sees before a cycle block of the user's own job: gauges of the blocks before, and the coming block.

Names, scales and noise are those of `observations` wherever they mean the same.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.gauges import PartGauges, entries_of, scaled, wheel_values
from grind_env.envs.job.outline import BlockOutline, Choice
from grind_env.envs.job.tape import GAUGES
from grind_env.envs.observations import ROUGHNESS_NOISE, Reading, measured_power
from grind_env.envs.program_episode import BlockRun
from grind_env.envs.tape import FACTORS
from grind_env.envs.tasks import ActionRange, Spread, Task, load_task
from grind_env.machine.job import Job
from grind_env.machine.tally import POWER_WINDOW
from grind_env.process.state import WheelState

__all__ = ["Gauges", "coming", "hidden", "job_task", "readings", "scaled"]

ACTION = ActionRange(executions=3, speed_range=(3.0, 30.0))
"""The table speeds of nearly every scenario (scenarios, section 1); a higher D was never worthwhile (section 5)."""

CODES = ("G81", "G82", "G83")

FULL = 0.9
"""Least share of the deepest plunge of a G81 that counts as a full one; the other cycles have their picks."""

HIDDEN_FACTORS = dict(
    zip(FACTORS, ("growth", "pressure", "convection", "fracture", "wear", "roughness_scale"), strict=True)
)
"""Reading by stroke parameter."""

SEEN = (
    "mean_power",
    "first_power",
    "peak_power",
    "last_speed",
    "last_executions",
    "last_pick",
    "size_error",
    "roughness",
    "parts_since_gauged",
    "volume",
    "blocks_since_dress",
    "dresses",
    "diameter",
    "pick",
    "depth",
    "sparkout",
    "takes_dresses",
    "starts_part",
    "new_lot",
    "remaining",
    *(f"coming_{code}" for code in CODES),
)
HIDDEN = (
    "wear_flat",
    "loading",
    "waviness",
    "diamond_flat",
    "dressed_roughness",
    "dressed_density",
    "wheel_volume",
    *HIDDEN_FACTORS.values(),
)


def readings(task: Task, *, full: bool) -> tuple[Reading, ...]:
    """The observation of a job, entry by entry.

    Args:
        task: of the job, see `job_task`.
        full: with the hidden state, for oracles and tests.
    """
    spread = task.spread.measurement
    ra_noise = f"{100.0 * ROUGHNESS_NOISE * spread:g} %, " if spread > 0.0 else ""
    own = [
        Reading("last_pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "greatest depth per stroke of the last block"),
        Reading("roughness", "Ra/limit", 0.0, 1.0, 0.0, 5.0, f"{ra_noise}every third part, one part late",
                "Ra of the last gauged part over its limit; 0 without a limit"),
        Reading("volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "exact",
                "volume programmed since the last dress per width of the wheel in use, by book-keeping"),
        Reading("diameter", "mm", 220.0, 80.0, -2.5, 5.0, "exact", "wheel diameter (offset 33)"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "J of the coming block, 0 in a G81"),
        Reading("depth", "mm", 0.0, 0.3, 0.0, 5.0, "exact", "by which the part gets deeper until the following block"),
        Reading("sparkout", "", 0.0, 5.0, 0.0, 5.0, "exact", "L of the coming block"),
        Reading("takes_dresses", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block can have a D word"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block begins the first part of a lot"),
        *(Reading(f"coming_{code}", "", 0.0, 1.0, 0.0, 1.0, "exact", f"1 if the coming block is a {code}")
          for code in CODES),
    ]  # fmt: skip
    return entries_of(task, own, (*SEEN, *HIDDEN) if full else SEEN)


def job_task(job: Job, spread: float) -> Task:
    """A task with the limits and the noise of a job, whose actions and readings have the ranges that the job needs.

    The rest of it is that of another task: the program, not the task, says what is ground.

    Args:
        job: the job.
        spread: factor on the noise of the readings.
    """
    task = load_task("power_limited")
    return replace(
        task,
        action=ACTION,
        setup=replace(task.setup, machine_changes={"power_limit": job.setup.machine.power_limit}),
        kinds=(replace(task.kinds[0], tolerance=job.part.tolerance),),
        spread=Spread(measurement=spread),
    )


@dataclass(slots=True)
class Gauges(PartGauges):
    """What the shop floor has seen so far, in physical units; noisy where a gauge is."""

    mean_power: float = 0.0
    first_power: float = 0.0
    peak_power: float = 0.0
    speed: float = 0.0
    executions: int = 0
    pick: float = 0.0
    volume: float = 0.0
    blocks_since_dress: int = 0
    dresses: int = 0

    def note(self, run: BlockRun, choice: Choice, job: Job, noise: NDArray[np.float64]) -> None:
        """Read the gauges after a block; `noise` is a row of `JobTape.noise`."""
        z = dict(zip(GAUGES, noise.tolist(), strict=True))
        power, plunges = run.strokes["power"], np.flatnonzero(_full(run))
        table = run.strokes["groove"] == 0
        since = int(run.dresses["after"][-1]) if run.dresses.size else 0
        window = int(POWER_WINDOW)
        last = plunges[-window:]
        self.first_power = _measured(power[plunges[:window]], z["first_power"])
        self.mean_power = _measured(power[last[last >= since]], z["mean_power"])
        self.peak_power = _measured(power[power == power.max(initial=0.0)][:1], z["peak_power"])
        self.speed, self.executions = choice.speed, choice.executions
        self.pick = float(run.increments[table].max(initial=0.0))
        part, wheel = job.part, job.setup.wheel
        ground = table | job.setup.grooving_wheel
        deeper = np.maximum(run.increments[since:][ground[since:]], 0.0).sum() * part.length
        per_width = part.width / min(part.width, wheel.width)
        self.volume = float(deeper * per_width) + (0.0 if run.dresses.size else self.volume)
        self.blocks_since_dress = 0 if run.dresses.size else self.blocks_since_dress + 1
        self.dresses += run.dresses.size
        for finished in run.finished:
            self.gauge(finished, part.roughness_limit, z["size_error"], z["roughness"])

    def values(self, wheel: WheelState) -> dict[str, float]:
        """The readings of the blocks before."""
        return {
            "mean_power": self.mean_power,
            "first_power": self.first_power,
            "peak_power": self.peak_power,
            "last_speed": self.speed / 1000.0,
            "last_executions": self.executions,
            "last_pick": self.pick,
            "volume": self.volume,
            "blocks_since_dress": self.blocks_since_dress,
            "dresses": self.dresses,
            **self.part_values(),
            "diameter": wheel.ds,
        }


def coming(block: BlockOutline) -> dict[str, float]:
    """The readings of the coming block."""
    plan = block.plan
    return {
        "pick": plan.primary_pick,
        "depth": block.depth,
        "sparkout": plan.spark_out,
        "takes_dresses": float(block.takes_dresses),
        "starts_part": float(block.starts_part),
        **{f"coming_{code}": float(plan.code == code) for code in CODES},
    }


def hidden(wheel: WheelState, factors: dict[str, float]) -> dict[str, float]:
    """The hidden readings; `factors` are those of the coming part, by stroke parameter."""
    return wheel_values(wheel) | {HIDDEN_FACTORS[name]: factor for name, factor in factors.items()}


def _full(run: BlockRun) -> NDArray[np.bool_]:
    """Which strokes are full plunges of the table; infeeds of grooves are none."""
    plan, table = run.plan, run.strokes["groove"] == 0
    least = max(plan.primary_pick, plan.secondary_pick) - DEPTH_TOLERANCE
    if plan.code == "G81":
        least = FULL * run.increments[table].max(initial=0.0)
    return np.asarray(table & (run.increments > DEPTH_TOLERANCE) & (run.increments >= least))


def _measured(power: NDArray[np.float64], z: float) -> float:
    """A power reading, W, of the mean of some strokes; 0 of none."""
    if not power.size:
        return 0.0
    return measured_power(float(power.mean()), z)
