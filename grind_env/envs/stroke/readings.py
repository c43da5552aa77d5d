"""What an agent sees before a stroke: what the machine measured in the strokes before, and the coming pick.

Names, scales and noise are those of `observations` wherever they mean the same.
"""

from collections import deque
from dataclasses import dataclass, field

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.gauges import PartGauges, entries_of, wheel_values
from grind_env.envs.observations import POWER_NOISE, POWER_NOISE_FLOOR, POWER_RANGE, Reading, measured_power
from grind_env.envs.stroke.episode import StrokeEpisode, StrokeRun
from grind_env.envs.tasks import Task
from grind_env.machine.tally import POWER_WINDOW

SEEN = (
    "power",
    "mean_power",
    "peak_power",
    "last_speed",
    "last_dress",
    "size_error",
    "roughness",
    "parts_since_gauged",
    "volume",
    "dresses",
    "diameter",
    "pick",
    "strokes_left",
    "stock",
    "starts_part",
    "new_lot",
    "remaining",
)
HIDDEN = ("wear_flat", "loading", "waviness", "diamond_flat", "wheel_volume", "growth", "pressure")


def stroke_readings(task: Task, *, full: bool) -> tuple[Reading, ...]:
    """The observation of the task, entry by entry; `full` with the hidden state."""
    power = task.machine.power_limit
    low, high = task.action.speed_ends
    noise = f"{100.0 * POWER_NOISE:g} % + {POWER_NOISE_FLOOR:g} W"
    own = [
        Reading("power", "W", 0.0, power, 0.0, POWER_RANGE, noise, "power above idle of the last stroke"),
        Reading("mean_power", "W", 0.0, power, 0.0, POWER_RANGE, noise,
                "mean of the power readings of the last (up to 6) full plunges since the last dress; 0 if none"),
        Reading("peak_power", "W", 0.0, power, 0.0, POWER_RANGE, noise, "highest power reading on the part"),
        Reading("last_speed", "m/min", (low + high) / 2.0, (high - low) / 2.0, -1.3, 1.0, "exact",
                "E of the last stroke"),
        Reading("last_dress", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if there was a dress before the last stroke"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "pick before the coming stroke; 0 in spark-out"),
        Reading("strokes_left", "", 0.0, 20.0, 0.0, 5.0, "exact", "strokes left on the part"),
        Reading("stock", "of nominal", 1.0, 1.0, -1.0, 3.0, "pre-gauge of the task", "stock of the part"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming stroke is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the part begins a new lot"),
        Reading("remaining", "of all", 0.0, 1.0, 0.0, 1.0, "exact", "parts not yet finished"),
        Reading("growth", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat growth"),
        Reading("pressure", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat pressure"),
    ]  # fmt: skip
    return entries_of(task, own, (*SEEN, *HIDDEN) if full else SEEN)


@dataclass(slots=True)
class StrokeGauges(PartGauges):
    """What the shop floor has seen so far, in physical units; noisy where a gauge is."""

    power: float = 0.0
    peak_power: float = 0.0
    speed: float = 0.0
    dressed: bool = False
    volume: float = 0.0
    dresses: int = 0
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
        self.power = measured_power(run.stroke.power, z)
        if run.pick >= kind.pick - DEPTH_TOLERANCE:
            self.plunges.append(self.power)
        self.peak_power = max(self.peak_power, self.power)
        self.speed, self.dressed = speed, dress
        self.dresses += dress
        self.volume += run.pick * kind.length
        if run.finished is not None:
            self.peak_power = 0.0
            self.gauge(run.finished, kind.roughness_limit, row.size_noise, row.roughness_noise)

    def values(self, episode: StrokeEpisode) -> dict[str, float]:
        """The readings before the coming stroke; after the last one the coming stroke reads as zeros."""
        row, plunges = episode.row, self.plunges
        seen = {
            "power": self.power,
            "mean_power": sum(plunges) / len(plunges) if plunges else 0.0,
            "peak_power": self.peak_power,
            "last_speed": self.speed / 1000.0,
            "last_dress": float(self.dressed),
            "volume": self.volume,
            "dresses": self.dresses,
            "remaining": 1.0 - self.parts / len(episode.tape),
            "growth": row.kA,
            "pressure": row.pm,
            **self.part_values(),
            **wheel_values(episode.wheel),
        }
        if episode.part is None:
            return seen
        return seen | {
            "pick": episode.coming_pick,
            "strokes_left": episode.strokes - episode.made,
            "stock": row.gauged / episode.task.kinds[0].stock,
            "starts_part": float(episode.made == 0),
            "new_lot": row.new_lot,
        }
