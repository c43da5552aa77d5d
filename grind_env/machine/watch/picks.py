"""Picks that are not finished when the wheel is over the middle of the part."""

from grind_env.control import Control, CycleStrokes, Pick
from grind_env.machine.watch import advice
from grind_env.machine.watch.notices import Notices


class Picks:
    """Tells of the picks that come one by one; those of a whole cycle are not slow."""

    def __init__(self, control: Control, notices: Notices) -> None:
        self.control, self.notices = control, notices
        self._pick: Pick | None = None
        self._last: CycleStrokes | None = None

    def pick(self, event: Pick) -> None:
        if self._last is not None and self._last.begins[0] > event.begin:  # a whole stroke went by
            self.notices.tell(event.line, "pick", advice.slow_pick(event, self._last, self.control))
        self._pick = event

    def strokes(self, event: CycleStrokes) -> None:
        pick, self._last = self._pick, event
        if pick is not None and pick.begin < event.begins[0]:
            middle = event.begins[0] + 0.5 * (event.seconds[0] - self.control.reversal_dwell)
            if pick.finish > middle:
                self.notices.tell(event.plan.line, "pick", advice.slow_pick(pick, event, self.control))
            self._pick = None
