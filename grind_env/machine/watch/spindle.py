"""The worst stroke or infeed of a cycle for the spindle, if it has slowed or stalled."""

from grind_env.arrays import Array
from grind_env.machine.part.part import SLOWED
from grind_env.machine.watch import advice
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
        number, groove = int(worst["number"]), int(worst["groove"]) > 0
        if torque >= STALL:
            said = "stall", advice.stalled_spindle(number, limit, p.stall_time, word=self.word, groove=groove)
        else:
            speed = wheel_speed(float(worst["ds"]), p.n, p.vs_set)
            found = float(worst["vs"])
            said = "spindle", advice.slowed_spindle(number, found, speed, limit, word=self.word, groove=groove)
        self._line, self._torque, self._said = line, torque, said

    def end(self) -> None:
        if self._torque > 0.0:
            self.notices.tell(self._line, *self._said)
        self._torque = 0.0
