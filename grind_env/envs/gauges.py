"""Gauge readings shared by `JobEnv` and `StrokeEnv`, in plain Python.

Noise and scales are those of `observations`, the delay of the roughness gauge is that of the compiled step.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.observations import GAUGE_EVERY, Reading, measured_roughness, measured_size, readings
from grind_env.envs.tasks import Task
from grind_env.process.state import WheelState


@dataclass(slots=True)
class PartGauges:
    """Gauges of finished parts: the size is known at once, the roughness of every third part one part later.

    Attributes:
        size_error: reading of the last part, um.
        roughness: last reading that is known, over the limit.
        gauged: a reading that is not yet known.
        since_gauged: parts since the one that `roughness` is of.
        parts: finished so far.
    """

    size_error: float = 0.0
    roughness: float = 0.0
    gauged: float | None = None
    since_gauged: int = 0
    parts: int = 0

    def gauge(self, part: NDArray[np.void], limit: float, z_size: float, z_roughness: float) -> None:
        """A part has been finished.

        Args:
            part: its row (`machine.record.PART_ROW`).
            limit: of its roughness, um; 0 for none.
            z_size: noise of the size, standard normal times a factor.
            z_roughness: noise of the roughness, likewise.
        """
        self.size_error = measured_size(float(part["size_error"]), z_size)
        self.since_gauged += 1
        if self.gauged is not None:
            self.roughness, self.gauged, self.since_gauged = self.gauged, None, 1
        if self.parts % GAUGE_EVERY == 0:
            self.gauged = measured_roughness(float(part["Ra"]), limit, z_roughness)
        self.parts += 1

    def part_values(self) -> dict[str, float]:
        """The readings of finished parts."""
        return {
            "size_error": self.size_error,
            "roughness": self.roughness,
            "parts_since_gauged": self.since_gauged,
        }


def wheel_values(wheel: WheelState) -> dict[str, float]:
    """The diameter, and what no gauge shows of the wheel."""
    return {
        "diameter": wheel.ds,
        "wear_flat": wheel.A,
        "loading": wheel.lam,
        "waviness": wheel.alw,
        "diamond_flat": wheel.wd,
        "dressed_roughness": wheel.Rd,
        "dressed_density": wheel.Cd,
        "wheel_volume": wheel.V,
    }


def entries_of(task: Task, own: Iterable[Reading], names: Iterable[str]) -> tuple[Reading, ...]:
    """Entries of an observation by name: those of its own, and else those of the task."""
    known = {entry.name: entry for entry in (*readings(task, full=True), *own)}
    return tuple(known[name] for name in names)


def scaled(values: Mapping[str, float], entries: tuple[Reading, ...]) -> NDArray[np.float32]:
    """An observation, shape (entries,): values scaled and cut at the range of their sensors; 0 for a missing value."""
    numbers = [(values[e.name] - e.offset) / e.scale if e.name in values else 0.0 for e in entries]
    low, high = [e.low for e in entries], [e.high for e in entries]
    return np.clip(numbers, low, high).astype(np.float32)
