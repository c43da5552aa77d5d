"""The time that an optimisation may take, from its first look at the program on.

The search ends early enough for what is found to be judged within it. Where the control executes the program, the
search ends with it, and a command that is given 8 s within 5 times that and 10 s: the first trial and what has to be
known before it may take somewhat longer than the search, and what is found is compared and judged on as many lots as
time allows.
"""

from dataclasses import dataclass, field
from time import monotonic

FIRST, FIRST_BESIDES = 1.5, 4.0
"""Times the budget, and s beside it, for all up to the end of the first trial; none is left without that."""
COMPARED = 2.0
"""Times the budget up to which the best programs are compared."""
JUDGEMENT = 1.5
"""The same for the judgement alone."""
LEAST_JUDGED = 8
"""Lots on which programs are judged however long it takes: half of those of a trial."""
ENOUGH_TRIALS = 100
"""For which a time is named where one trial has taken all of it."""


class TimeUp(Exception):
    """The time is up in the midst of something."""


@dataclass(frozen=True, slots=True)
class Budget:
    """Some time of the clock.

    Attributes:
        seconds: of it.
        began: reading of the clock at its begin, s.
    """

    seconds: float
    began: float = field(default_factory=lambda: monotonic())

    @property
    def spent(self) -> float:
        """Time since it began, s."""
        return monotonic() - self.began

    def require_search(self) -> None:
        """Raise `TimeUp` once the time of the search is up."""
        self._require(self.seconds)

    def require_first(self) -> None:
        """Raise it once the time of the first trial is up."""
        self._require(FIRST * self.seconds + FIRST_BESIDES)

    def require_comparison(self) -> None:
        """The same with the time until which programs are compared."""
        self._require(COMPARED * self.seconds)

    def judged(self, most: int, seconds: float) -> int:
        """Lots on which two programs can be judged.

        Args:
            most: of them, `LEAST_JUDGED` or more.
            seconds: that one program takes on one lot.
        """
        return min(max(int(JUDGEMENT * self.seconds / (2.0 * seconds)), LEAST_JUDGED), most)

    def _require(self, seconds: float) -> None:
        if self.spent > seconds:
            raise TimeUp


def time_said(seconds: float) -> str:
    """A time as --budget takes it, rounded up."""
    return f"{max(-(-seconds // 1), 1):.0f}s" if seconds <= 120.0 else f"{-(-seconds // 60):.0f}min"
