"""The worst stroke or infeed of a cycle for the spindle, if it has slowed or stalled."""

from grind_env.arrays import Array
from grind_env.machine.part.part import SLOWED
from grind_env.machine.watch.notices import Notices
from grind_env.process.cost import STALL
from grind_env.process.equations import wheel_speed
from grind_env.process.state import StrokeParameters


class Overload:
    """Tells of it as the cycle, or the grooving, ends; its strokes have the `word` E, or F."""

    def __init__(self, notices: Notices) -> None:
        self.notices, self.word = notices, "E"
        self._line, self._torque = 0, 0.0  # of the worst one; 0 if there is none
        self._said = "", ""

    def add(self, rows: Array, p: StrokeParameters) -> None:
        worst = rows[int(rows["torque"].argmax())]
        line, torque, limit = int(worst["line"]), float(worst["torque"]), 0.001 * p.power
        if torque <= SLOWED * p.rs:
            return
        if line != self._line:
            self.end()
        if torque <= self._torque:
            return
        number = int(worst["number"])
        if worst["groove"] > 0:
            made, remedy = "in an infeed", "take smaller steps or a lower F"
        else:
            made = f"in stroke {number}" if number else "in a stroke"
            remedy = "lower J or E" if self.word == "E" else f"go less deep or lower {self.word}"
        if torque >= STALL:
            subject = "stall"
            told = (
                f"stalls, which has {limit:.1f} kW: the wheel retracts, the part is scrap, {p.stall_time:g} s are lost"
            )
        else:
            usual = wheel_speed(float(worst["ds"]), p.n, p.vs_set)
            subject, told = "spindle", f"slows to {worst['vs']:.1f} of {usual:.1f} m/s at its {limit:.1f} kW"
        self._line, self._torque = line, torque
        self._said = subject, f"{made} the spindle {told}; {remedy}, or dress before"

    def end(self) -> None:
        if self._torque > 0.0:
            self.notices.tell(self._line, *self._said)
        self._torque = 0.0
