"""What a run warns of, each subject once in each block."""

from grind_env.control import Control, Infeed, Message, Pick, Stroke
from grind_env.machine import grooving
from grind_env.machine.advice import middle_time, outside_model, short_stroke, slow_pick
from grind_env.machine.axes import AXES
from grind_env.machine.job import Job
from grind_env.process import state


class Watch:
    """Looks on while a run goes by.

    Attributes:
        part: on the machine.
        warnings: sentences so far.
    """

    def __init__(self, program: str, job: Job, control: Control) -> None:
        self.program, self.job, self.control = program, job, control
        self.part = job.part
        self.warnings: list[str] = []
        self._warned: set[tuple[str, int]] = set()
        self._pick: Pick | None = None
        self._stroke: Stroke | None = None

    def warn(self, line: int, subject: str, text: str) -> None:
        """Warn once of each subject in each block; line 0 is the program as a whole."""
        if (subject, line) not in self._warned:
            self._warned.add((subject, line))
            place = f"{self.program}:{line}" if line else self.program
            self.warnings.append(f"{place}: {text}")

    def message(self, event: Message) -> None:
        """Pass on what the control tells the operator."""
        self.warnings.append(f"{self.program}: the control says: {event.text}")

    def start_cycle(self) -> None:
        """A cycle takes over: picks and strokes before it have no bearing on its own."""
        self._pick = self._stroke = None

    def pick(self, event: Pick) -> None:
        """A pick has been made."""
        if self._stroke is not None and self._stroke.begin > event.begin:  # a whole stroke went by
            self.warn(event.line, "pick", slow_pick(event, self._stroke, self.control))
        self._pick = event

    def stroke(self, event: Stroke, Z: float, depth: float, diameter: float) -> None:
        """A stroke has been made.

        Args:
            event: the stroke.
            Z: depth of the wheel below the touched-off surface, mm.
            depth: real depth of cut, mm.
            diameter: of the wheel after it, mm.
        """
        pick, part, line = self._pick, self.part, event.cycle.line
        if pick is not None and pick.begin < event.begin:
            if pick.finish > middle_time(event, self.control):
                self.warn(line, "pick", slow_pick(pick, event, self.control))
            self._pick = None
        turn, low, high = event.end[event.axis], part.start, part.start + part.length
        if Z > 0.0 and low < turn < high:
            self.warn(line, "turn", short_stroke(turn, AXES[event.axis], low, high))
        outside = outside_model(event.feed, depth)
        if outside is not None:
            self.warn(line, "model", outside)
        self.diameter(diameter)
        self._stroke = event

    def infeed(self, event: Infeed, cut: state.Stroke, diameter: float) -> None:
        """A grooving wheel of a diameter, mm, has made an infeed."""
        outside = grooving.outside_model(cut)
        if outside is not None:
            self.warn(event.line, "model", outside)
        self.diameter(diameter)

    def diameter(self, diameter: float) -> None:
        """The wheel has a diameter, mm, after a stroke or a dress; one that will be changed is nobody's mistake."""
        least = self.job.setup.wheel.minimum_diameter
        if diameter < least and self.job.times.wheel_change is None:
            self.warn(0, "diameter", f"the wheel is smaller than its least diameter, {least:g} mm")
