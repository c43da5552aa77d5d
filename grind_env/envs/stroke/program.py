"""The program text of an episode of `grind/Stroke-v0`, stroke by stroke.

G81 keeps the table going; while a stroke decelerates, a `G01 Y.. E..` makes the pick and changes the table speed, which
holds from the next stroke on (PD-8). Dwells in between, in whole ms, let the program keep pace with the table. A dress
is the operator's request during that block; the table waits at its reversal point until the dwell is over (22-11).
"""

import math
from dataclasses import dataclass, field

from grind_env.control.profile import ramp_time
from grind_env.control.rules import motion_time
from grind_env.envs.program import DRESS_PROGRAM, PICK_FEED, approach, end_of, next_part, number, start_of
from grind_env.envs.reciprocation.program import REQUEST
from grind_env.envs.tasks import Kind, Task


@dataclass(slots=True)
class StrokeProgram:
    """Writes the program while the strokes are made.

    Attributes:
        task: the task.
        lines: blocks so far.
        clock: time of the control since the table set out from rest, s.
        began: time at which the stroke in progress began, s.
        speed: of the stroke in progress, mm/min.
        running: whether the table reciprocates.
        acceleration: of the axes, mm/s2.
        dwell: at a reversal point, s.
        length: between the reversal points, mm.
    """

    task: Task
    lines: list[str] = field(default_factory=list)
    clock: float = 0.0
    began: float = 0.0
    speed: float = 0.0
    running: bool = False
    acceleration: float = field(init=False)
    dwell: float = field(init=False)
    length: float = field(init=False)

    def __post_init__(self) -> None:
        # the task looks its machine up in the catalogue: once, not at every stroke
        machine = self.task.machine
        self.acceleration, self.dwell = machine.acceleration, machine.reversal_dwell
        self.length = self.task.stroke_length(self.kind)

    @property
    def kind(self) -> Kind:
        """What the task grinds."""
        return self.task.kinds[0]

    def stroke_time(self, speed: float) -> float:
        """Time of a stroke with its reversal dwell at E `speed` (mm/min), s."""
        return self._travel(speed) + self.dwell

    def start_part(self, depth: float, speed: float, dress: bool) -> None:
        """Set the wheel to its first depth (mm) and the table going at E `speed` (mm/min), after a dress or not."""
        overrun = self.task.setup.overrun
        if self.lines:
            self.lines.append(next_part())
        self.lines += [
            *approach(self.task, depth),
            f"{'G81.1' if dress else 'G81'} X{number(self.kind.length + overrun)} I{number(-overrun)} "
            f"E{number(speed)} P{DRESS_PROGRAM}",
        ]
        self.clock, self.began, self.speed, self.running = 0.0, 0.0, speed, True

    def next_stroke(self, pick: float, depth: float, speed: float, dress: bool) -> float:
        """Go down by `pick` to `depth` (mm) for the next stroke at E `speed` (mm/min), after a dress or not.

        Returns:
            The time for which the table waits for the program before the dress, s.
        """
        braking = ramp_time(self.length, self.speed / 60.0, self.acceleration)
        decelerates = self.began + self._travel(self.speed) - braking
        self._dwell(math.floor(1000.0 * (decelerates - self.clock)))
        self.lines.append(f"G01 Y{number(-depth)} E{number(speed)}" if pick > 0.0 else f"G01 E{number(speed)}")
        self.clock += motion_time(pick, PICK_FEED / 60.0, self.acceleration) if pick > 0.0 else 0.0
        arrives, wait = self.began + self.stroke_time(self.speed), 0.0
        self.began, self.speed = arrives, speed
        if dress:
            self._dwell(math.floor(1000.0 * (arrives - self.clock)) + 2, f" ({REQUEST})")
            wait, self.clock, self.began = self.clock - arrives, 0.0, 0.0
        return wait

    def end_part(self) -> None:
        """Stop the table at the end of the stroke in progress."""
        self.lines += self._stop()
        self.running = False

    def text(self) -> str:
        """The program as far as it is written, with its dress program; the stroke in progress is its last."""
        stop = self._stop() if self.running else []
        return "\n".join([*start_of(self.task), *self.lines, *stop, *end_of(self.task)])

    def _stop(self) -> list[str]:
        wait = self.began + 0.5 * self._travel(self.speed) - self.clock
        return [f"G04 X{number(math.floor(1000.0 * wait) / 1000.0)}", "G80"]

    def _dwell(self, milliseconds: int, comment: str = "") -> None:
        self.lines.append(f"G04 X{number(milliseconds / 1000.0)}{comment}")
        self.clock += milliseconds / 1000.0

    def _travel(self, speed: float) -> float:
        return motion_time(self.length, speed / 60.0, self.acceleration)
