"""What the tasks are to hold, so that deciding on E and D matters in them."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from agents.reference.gaps import ADAPTING_D, ADAPTING_E, BEST, PLANNER, TaskGaps
from grind_env.table import NONE

SOLVED = ("slot", "oracle6")
"""Tasks in which a constant, or a rule that sees measurements, is as good as hindsight by intention."""


class Promise(NamedTuple):
    """What the tasks are to hold: a figure of a task is kept, in all tasks that have one or in `least` of them."""

    text: str
    figure: Callable[[TaskGaps], float | None]
    unit: str
    kept: Callable[[float], bool]
    least: int | None = None

    def verdict(self, tasks: Iterable[TaskGaps]) -> tuple[bool, str, str]:
        """Whether it is held, the tasks that keep it, and those that do not, with their figures."""
        of = {each.task: figure for each in tasks if (figure := self.figure(each)) is not None}
        keep = {task: figure for task, figure in of.items() if self.kept(figure)}
        held = len(keep) == len(of) if self.least is None else len(keep) >= self.least
        broken = {task: figure for task, figure in of.items() if task not in keep}
        return held, self._listed(keep), self._listed(broken)

    def _listed(self, figures: Mapping[str, float]) -> str:
        return ", ".join(f"{task} {figure:.3g}{self.unit}" for task, figure in figures.items()) or NONE


def _saved(what: str, but: Sequence[str] = ()) -> Callable[[TaskGaps], float | None]:
    """What a gap saves in a task, %."""

    def figure(found: TaskGaps) -> float | None:
        return found.gaps[what].saving.value if found.task not in but and what in found.gaps else None

    return figure


def _best_score(found: TaskGaps) -> float | None:
    """The score of the best rule in a task that is not made to be solved by one."""
    return None if found.task in SOLVED else found.gaps[BEST].score.value


PROMISES = (
    Promise(
        "the planner saves 15 % on the best fixed plan in every task but Slot",
        _saved(PLANNER, but=("slot",)),
        " %",
        lambda saving: saving >= 15.0,
    ),
    Promise("adapting E saves 8 % in three tasks", _saved(ADAPTING_E), " %", lambda saving: saving >= 8.0, least=3),
    Promise("adapting D saves 10 % in four tasks", _saved(ADAPTING_D), " %", lambda saving: saving >= 10.0, least=4),
    Promise(
        "no rule on measurements comes within 3 points of hindsight but in Slot and Oracle6",
        _best_score,
        "",
        lambda score: score <= 97.0,
    ),
    Promise(
        "the reference cost is within 1 % of that of the best fixed plan",
        lambda found: found.off,
        " %",
        lambda off: abs(off) <= 1.0,
    ),
)
