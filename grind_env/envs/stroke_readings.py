"""What an agent sees before a stroke: what the machine measured in the strokes before, and the coming pick.

Names, scales and noise are those of `observations` wherever they mean the same.
"""

from collections import deque
from dataclasses import dataclass, field

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.observations import (
    GAUGE_EVERY,
    POWER_NOISE,
    POWER_NOISE_FLOOR,
    ROUGHNESS_NOISE,
    SIZE_NOISE,
    Reading,
)
from grind_env.envs.stroke_episode import StrokeEpisode, StrokeRun
from grind_env.envs.tasks import Task
from grind_env.machine.cycle import POWER_WINDOW
from grind_env.process.state import WheelState


def stroke_readings(task: Task, *, full: bool) -> tuple[Reading, ...]:
    """The observation of the task, entry by entry; `full` with the hidden state."""
    power, kind = task.machine.power_limit, task.kinds[0]
    low, high = task.action.speed_range or (3.0, 30.0)
    noise = f"{100.0 * POWER_NOISE:g} % + {POWER_NOISE_FLOOR:g} W"
    table = [
        Reading("power", "W", 0.0, power, 0.0, 5.0, noise, "power above idle of the last stroke"),
        Reading("mean_power", "W", 0.0, power, 0.0, 5.0, noise,
                "mean of the power readings of the last (up to 6) full plunges since the last dress; 0 if none"),
        Reading("peak_power", "W", 0.0, power, 0.0, 5.0, noise, "highest power reading on the part"),
        Reading("last_speed", "m/min", (low + high) / 2.0, (high - low) / 2.0, -1.3, 1.0, "exact",
                "E of the last stroke"),
        Reading("last_dress", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if there was a dress before the last stroke"),
        Reading("size_error", "um", 0.0, kind.tolerance, -5.0, 5.0, f"{SIZE_NOISE:g} um",
                "stock left on the last finished part"),
        Reading("roughness", "Ra/limit", 0.0, 1.0, 0.0, 5.0,
                f"{100.0 * ROUGHNESS_NOISE:g} %, every third part, one part late",
                "Ra of the last gauged part over its limit"),
        Reading("parts_since_gauged", "", 0.0, 10.0, 0.0, 1.0, "exact", "parts since that gauging"),
        Reading("volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "exact",
                "programmed depth times length since the last dress, by book-keeping"),
        Reading("dresses", "", 0.0, 50.0, 0.0, 10.0, "exact", "dress executions so far"),
        Reading("diameter", "mm", 220.0, 80.0, 0.0, 1.5, "exact", "wheel diameter (offset 33)"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "pick before the coming stroke; 0 in spark-out"),
        Reading("strokes_left", "", 0.0, 20.0, 0.0, 5.0, "exact", "strokes left on the part"),
        Reading("stock", "of nominal", 1.0, 1.0, -1.0, 3.0, "pre-gauge of the task", "stock of the part"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming stroke is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the part begins a new lot"),
        Reading("remaining", "of all", 0.0, 1.0, 0.0, 1.0, "exact", "parts not yet finished"),
    ]  # fmt: skip
    hidden = [
        Reading("wear_flat", "", 0.0, 0.05, 0.0, 5.0, "hidden", "wear-flat area A"),
        Reading("loading", "", 0.0, 1.0, 0.0, 1.0, "hidden", "loading"),
        Reading("waviness", "um", 0.0, 1.0, 0.0, 5.0, "hidden", "waviness amplitude"),
        Reading("diamond_flat", "mm", 0.0, 0.2, 0.0, 20.0, "hidden", "wear flat of the diamond"),
        Reading("wheel_volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "hidden",
                "specific volume since the last dress as the wheel feels it: a dress leaves a part of it"),
        Reading("growth", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat growth"),
        Reading("pressure", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat pressure"),
    ]  # fmt: skip
    return (*table, *hidden) if full else tuple(table)


@dataclass(slots=True)
class StrokeGauges:
    """What the shop floor has seen so far, in physical units; noisy where a gauge is."""

    power: float = 0.0
    peak_power: float = 0.0
    speed: float = 0.0
    dressed: bool = False
    size_error: float = 0.0
    roughness: float = 0.0
    gauged: float | None = None
    since_gauged: int = 0
    volume: float = 0.0
    dresses: int = 0
    parts: int = 0
    plunges: deque[float] = field(default_factory=lambda: deque(maxlen=int(POWER_WINDOW)))

    def note(self, run: StrokeRun, speed: float, dress: bool, z: float, episode: StrokeEpisode, number: int) -> None:
        """Read the gauges after a stroke.

        Args:
            run: the stroke.
            speed: E, mm/min.
            dress: whether there was a dress before it.
            z: noise of the power reading, standard normal.
            episode: the episode.
            number: of the part, from 0.
        """
        kind, row = episode.task.kinds[0], episode.tape[number]
        if dress:
            self.plunges.clear()
            self.volume = 0.0
        self.power = max(run.stroke.power * (1.0 + POWER_NOISE * z) + POWER_NOISE_FLOOR * z, 0.0)
        if run.pick >= kind.pick - DEPTH_TOLERANCE:
            self.plunges.append(self.power)
        self.peak_power = max(self.peak_power, self.power)
        self.speed, self.dressed = speed, dress
        self.dresses += dress
        self.volume += run.pick * kind.length
        if run.finished is not None:
            self.peak_power = 0.0
            self.size_error = float(run.finished["size_error"]) + SIZE_NOISE * row.size_noise
            self.since_gauged += 1
            if self.gauged is not None:
                self.roughness, self.gauged, self.since_gauged = self.gauged, None, 1
            if self.parts % GAUGE_EVERY == 0:
                ratio = float(run.finished["Ra"]) / kind.roughness_limit
                self.gauged = ratio * (1.0 + ROUGHNESS_NOISE * row.roughness_noise)
            self.parts += 1

    def values(self, episode: StrokeEpisode) -> dict[str, float]:
        """The readings before the coming stroke; after the last one the coming stroke reads as zeros."""
        wheel, row, plunges = episode.wheel, episode.row, self.plunges
        seen = {
            "power": self.power,
            "mean_power": sum(plunges) / len(plunges) if plunges else 0.0,
            "peak_power": self.peak_power,
            "last_speed": self.speed / 1000.0,
            "last_dress": float(self.dressed),
            "size_error": self.size_error,
            "roughness": self.roughness,
            "parts_since_gauged": self.since_gauged,
            "volume": self.volume,
            "dresses": self.dresses,
            "diameter": wheel.ds,
            "remaining": 1.0 - self.parts / len(episode.tape),
        }
        if episode.part is None:
            return seen | _hidden(wheel, row.kA, row.pm)
        coming = {
            "pick": episode.coming_pick,
            "strokes_left": episode.strokes - episode.made,
            "stock": row.gauged / episode.task.kinds[0].stock,
            "starts_part": float(episode.made == 0),
            "new_lot": row.new_lot,
        }
        return seen | coming | _hidden(wheel, row.kA, row.pm)


def _hidden(wheel: WheelState, growth: float, pressure: float) -> dict[str, float]:
    return {
        "wear_flat": wheel.A,
        "loading": wheel.lam,
        "waviness": wheel.alw,
        "diamond_flat": wheel.wd,
        "wheel_volume": wheel.V,
        "growth": growth,
        "pressure": pressure,
    }
