"""Warnings about stops that remove an unfinished part, and stages that no stop ends."""

from grind_env.control import CyclePlan, ProgramStop
from grind_env.machine.part.part import PartRun
from grind_env.machine.warnings.idle_cycles import Cycle
from grind_env.machine.warnings.texts import Notices

#: stock that is too little to be left on a part, and difference of depths that gauging does not show, mm
NEGLIGIBLE_STOCK = 0.001


class Stops:
    """Watcher of parts that are taken off; it warns with the next cycle or at the end of the program."""

    def __init__(self, notices: Notices) -> None:
        self.notices = notices
        self._pending: list[tuple[int, str, str]] = []  # warnings about the part that M00 took off
        self._taken_off: tuple[int, float, float] | None = None  # line of that M00, depth and stock left, mm

    def stroked_on(self, stop: ProgramStop) -> None:
        text = (
            "M00 stops the program while the table reciprocates, from which no part is taken; the part stays and is "
            "ground on until the table stands or the next cycle begins: write G80 before M00"
        )
        self._pending.append((stop.line, "stop", text))

    def unload(self, part: PartRun, cycle: Cycle | None, stop: ProgramStop | None) -> None:
        left, notices = part.stock - max(part.deepest, 0.0), self.notices
        if cycle is not None and part.deepest > 0.0 and part.strokes:
            if 0.0 < part.job.part.tolerance < 1000.0 * left:
                found = f"to a depth of {part.deepest:.4g} mm, but has {part.stock:.4g} mm of stock"
                self._pending.append((cycle.plan.line, "stock", f"the part is ground {found}; go as deep"))
            if stop is not None and min(left, part.deepest) > NEGLIGIBLE_STOCK and not notices.muted:
                self._taken_off = stop.line, part.deepest, left
        stages, passed = len(part.job.part.stages), len(part.ended)
        if passed < stages:
            text = (
                f"the job has {stages} stage{'s' * (stages > 1)} before the last one, but the program stopped at "
                f"{passed} M01 after it had begun to grind; put M01 after the last cycle of each, or its limits are "
                "not judged"
            )
            self._pending.append((0, "stages", text))
        if notices.muted:
            self._pending.clear()
            notices.muted = False

    def resume(self, part: PartRun, plan: CyclePlan) -> None:
        """Begin a cycle; if it continues the part of the last M00, the warnings about that part follow from the M00."""
        if self._taken_off is not None and plan.plunges:
            line, depth, left = self._taken_off
            if part.job.part.surface - plan.plunge_start > depth - NEGLIGIBLE_STOCK:
                text = (
                    f"M00 takes the part off at a depth of {depth:.4g} mm, with {left:.4g} mm of stock, and line "
                    f"{plan.line} goes on there; write M01 if the part is to be gauged and stay"
                )
                self.notices.tell(line, "stop", text)
                self._pending.clear()
                self.notices.muted = True  # until the part is off
        self.end()

    def end(self) -> None:
        for line, subject, text in self._pending:
            self.notices.tell(line, subject, text)
        self._pending.clear()
        self._taken_off = None
