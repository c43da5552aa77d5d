"""What an agent sees before a cycle block of the user's own job: gauges of the blocks before, and the coming block.

Names, scales and noise are those of `observations` wherever they mean the same.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.choice import Choice, Choices
from grind_env.envs.job_outline import BlockOutline
from grind_env.envs.job_tape import FACTORS, GAUGES
from grind_env.envs.observations import (
    GAUGE_EVERY,
    POWER_NOISE,
    POWER_NOISE_FLOOR,
    ROUGHNESS_NOISE,
    SIZE_NOISE,
    Reading,
)
from grind_env.envs.program_episode import BlockRun
from grind_env.machine.cycle import POWER_WINDOW
from grind_env.machine.job import Job
from grind_env.process.state import WheelState

CODES = ("G81", "G82", "G83")

FULL = 0.9
"""Least share of the deepest plunge of a G81 that counts as a full one; the other cycles have their picks."""

HIDDEN_FACTORS = dict(
    zip(FACTORS, ("growth", "pressure", "convection", "fracture", "wear", "roughness_scale"), strict=True)
)
"""Reading by stroke parameter."""


def readings(job: Job, choices: Choices, spread: float, *, full: bool) -> tuple[Reading, ...]:
    """The observation of a job, entry by entry.

    Args:
        job: the job.
        choices: what actions stand for.
        spread: factor on the noise of the readings.
        full: with the hidden state, for oracles and tests.
    """
    power, tolerance = job.setup.machine.power_limit, max(job.part.tolerance, 1.0)
    centre, half = (choices.high + choices.low) / 2000.0, (choices.high - choices.low) / 2000.0
    most = max(choices.most, 1)
    power_noise = f"{100.0 * POWER_NOISE * spread:g} % + {POWER_NOISE_FLOOR * spread:g} W"
    table = [
        Reading("mean_power", "W", 0.0, power, 0.0, 5.0, power_noise,
                "mean power above idle of the last (up to 6) full plunges since the last dress; 0 if none"),
        Reading("first_power", "W", 0.0, power, 0.0, 5.0, power_noise,
                "mean power of the first (up to 6) full plunges of the last block"),
        Reading("peak_power", "W", 0.0, power, 0.0, 5.0, power_noise, "highest power of the last block"),
        Reading("last_speed", "m/min", centre, half, -1.1, 1.0, "exact", "E of the last block"),
        Reading("last_executions", "", most / 2.0, most / 2.0, -1.0, 1.0, "exact", "D of the last block"),
        Reading("last_pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "greatest depth per stroke of the last block"),
        Reading("size_error", "um", 0.0, tolerance, -5.0, 5.0, f"{SIZE_NOISE * spread:g} um",
                "stock left on the last finished part"),
        Reading("roughness", "Ra/limit", 0.0, 1.0, 0.0, 5.0,
                f"{100.0 * ROUGHNESS_NOISE * spread:g} %, every third part, one part late",
                "Ra of the last gauged part over its limit; 0 without a limit"),
        Reading("parts_since_gauged", "", 0.0, 10.0, 0.0, 1.0, "exact", "parts since that gauging"),
        Reading("volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "exact",
                "volume programmed since the last dress per width of the wheel in use, by book-keeping"),
        Reading("blocks_since_dress", "", 0.0, 10.0, 0.0, 20.0, "exact", "blocks since the last dress"),
        Reading("dresses", "", 0.0, 50.0, 0.0, 10.0, "exact", "dress executions so far"),
        Reading("diameter", "mm", 220.0, 80.0, -2.5, 5.0, "exact", "wheel diameter (offset 33)"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "J of the coming block, 0 in a G81"),
        Reading("depth", "mm", 0.0, 0.3, 0.0, 5.0, "exact", "by which the part gets deeper until the following block"),
        Reading("sparkout", "", 0.0, 5.0, 0.0, 5.0, "exact", "L of the coming block"),
        Reading("takes_dresses", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block can have a D word"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming block begins the first part of a lot"),
        Reading("remaining", "of all", 0.0, 1.0, 0.0, 1.0, "exact", "blocks still to grind"),
        *(Reading(f"coming_{code}", "", 0.0, 1.0, 0.0, 1.0, "exact", f"1 if the coming block is a {code}")
          for code in CODES),
    ]  # fmt: skip
    hidden = [
        Reading("wear_flat", "", 0.0, 0.05, 0.0, 5.0, "hidden", "wear-flat area A"),
        Reading("loading", "", 0.0, 1.0, 0.0, 1.0, "hidden", "loading"),
        Reading("waviness", "um", 0.0, 1.0, 0.0, 5.0, "hidden", "waviness amplitude"),
        Reading("diamond_flat", "mm", 0.0, 0.2, 0.0, 20.0, "hidden", "wear flat of the diamond"),
        Reading("dressed_roughness", "um", 0.0, 1.0, 0.0, 5.0, "hidden", "roughness scale left by the dress"),
        Reading("dressed_density", "1/mm2", 0.0, 10.0, 0.0, 5.0, "hidden", "grain density left by the dress"),
        Reading("wheel_volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "hidden",
                "specific volume since the last dress as the wheel feels it: a dress leaves a part of it"),
        *(Reading(name, "", 1.0, 1.0, -1.0, 10.0, "hidden", f"factor on {parameter}, coming block")
          for parameter, name in HIDDEN_FACTORS.items()),
    ]  # fmt: skip
    return (*table, *hidden) if full else tuple(table)


@dataclass(slots=True)
class Gauges:
    """What the shop floor has seen so far, in physical units; noisy where a gauge is."""

    mean_power: float = 0.0
    first_power: float = 0.0
    peak_power: float = 0.0
    speed: float = 0.0
    executions: int = 0
    pick: float = 0.0
    size_error: float = 0.0
    roughness: float = 0.0
    gauged: float | None = None
    since_gauged: int = 0
    volume: float = 0.0
    blocks_since_dress: int = 0
    dresses: int = 0
    parts: int = 0

    def note(self, run: BlockRun, choice: Choice, job: Job, noise: NDArray[np.float64]) -> None:
        """Read the gauges after a block; `noise` is a row of `JobTape.noise`."""
        z = dict(zip(GAUGES, noise.tolist(), strict=True))
        power, plunges = run.strokes["power"], np.flatnonzero(_full(run))
        since = int(run.dresses["after"][-1]) if run.dresses.size else 0
        window = int(POWER_WINDOW)
        last = plunges[-window:]
        self.first_power = _measured(power[plunges[:window]], z["first_power"])
        self.mean_power = _measured(power[last[last >= since]], z["mean_power"])
        self.peak_power = _measured(power[power == power.max(initial=0.0)][:1], z["peak_power"])
        self.speed, self.executions = choice.speed, choice.executions
        self.pick = float(run.increments.max(initial=0.0))
        part, wheel = job.part, job.setup.wheel
        deeper = np.maximum(run.increments[since:], 0.0).sum() * part.length
        per_width = part.width / min(part.width, wheel.width)
        self.volume = float(deeper * per_width) + (0.0 if run.dresses.size else self.volume)
        self.blocks_since_dress = 0 if run.dresses.size else self.blocks_since_dress + 1
        self.dresses += run.dresses.size
        for finished in run.finished:
            self._gauge(float(finished["size_error"]), float(finished["Ra"]), part.roughness_limit, z)

    def _gauge(self, size_error: float, Ra: float, limit: float, z: dict[str, float]) -> None:
        """A part has been finished: its size is known at once, the roughness of every third one a part later."""
        self.size_error = size_error + SIZE_NOISE * z["size_error"]
        self.since_gauged += 1
        if self.gauged is not None:
            self.roughness, self.gauged, self.since_gauged = self.gauged, None, 1
        if self.parts % GAUGE_EVERY == 0:
            ratio = Ra / limit if limit > 0.0 else 0.0
            self.gauged = ratio * (1.0 + ROUGHNESS_NOISE * z["roughness"])
        self.parts += 1

    def values(self, wheel: WheelState) -> dict[str, float]:
        """The readings of the blocks before."""
        return {
            "mean_power": self.mean_power,
            "first_power": self.first_power,
            "peak_power": self.peak_power,
            "last_speed": self.speed / 1000.0,
            "last_executions": self.executions,
            "last_pick": self.pick,
            "size_error": self.size_error,
            "roughness": self.roughness,
            "parts_since_gauged": self.since_gauged,
            "volume": self.volume,
            "blocks_since_dress": self.blocks_since_dress,
            "dresses": self.dresses,
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
    return {
        "wear_flat": wheel.A,
        "loading": wheel.lam,
        "waviness": wheel.alw,
        "diamond_flat": wheel.wd,
        "dressed_roughness": wheel.Rd,
        "dressed_density": wheel.Cd,
        "wheel_volume": wheel.V,
        **{HIDDEN_FACTORS[name]: factor for name, factor in factors.items()},
    }


def scaled(values: dict[str, float], entries: tuple[Reading, ...]) -> NDArray[np.float32]:
    """An observation, shape (entries,): values scaled and cut at the range of their sensors; 0 for a missing value."""
    numbers = [(values[e.name] - e.offset) / e.scale if e.name in values else 0.0 for e in entries]
    low, high = [e.low for e in entries], [e.high for e in entries]
    return np.clip(numbers, low, high).astype(np.float32)


def _full(run: BlockRun) -> NDArray[np.bool_]:
    """Which strokes are full plunges."""
    plan = run.plan
    least = max(plan.primary_pick, plan.secondary_pick) - DEPTH_TOLERANCE
    if plan.code == "G81":
        least = FULL * run.increments.max(initial=0.0)
    return np.asarray((run.increments > DEPTH_TOLERANCE) & (run.increments >= least))


def _measured(power: NDArray[np.float64], z: float) -> float:
    """A power reading, W, of the mean of some strokes; 0 of none."""
    if not power.size:
        return 0.0
    return max(float(power.mean()) * (1.0 + POWER_NOISE * z) + POWER_NOISE_FLOOR * z, 0.0)
