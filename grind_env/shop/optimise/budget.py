"""What a search may take: seconds of the clock or a number of programs, with the judgement's share kept from the start.

Where the control executes the program, one trial may take longer than all of it: the first trial is given more time.
"""

import math
from dataclasses import dataclass, field
from time import monotonic

COMPARING = 0.3
"""Share of the time that a search leaves for the comparison of its best programs."""
MOST_JUDGING = 0.4
"""Share that the judgement is given at most."""
FIRST, FIRST_BESIDES = 1.5, 4.0
"""Times the budget, and s beside it, for all up to the end of the first trial; none is left without that."""
ENOUGH_TRIALS = 100
"""For which a time is named where one trial has taken all of it."""


class TimeUp(Exception):
    """The time is up in the midst of something."""


@dataclass(slots=True)
class Budget:
    """Some time of the clock, or some programs."""

    seconds: float = math.inf  # of the clock; infinite where programs are counted
    programs: float = math.inf  # that a search tries at most; a comparison has a quarter as many
    judging: float = 0.0  # time that is kept for the judgement, s
    began: float = field(default_factory=lambda: monotonic())  # reading of the clock at its begin, s

    @property
    def spent(self) -> float:
        """Time since it began, s."""
        return monotonic() - self.began

    @property
    def compared(self) -> float:
        return self.programs / 4

    def keep(self, seconds: float) -> None:
        """Keep some time for the judgement, up to `MOST_JUDGING`."""
        self.judging = min(seconds, MOST_JUDGING * self.seconds)

    @property
    def is_search_up(self) -> bool:
        """Whether the comparison is due."""
        return self.spent > (1.0 - COMPARING) * self.seconds - self.judging

    @property
    def is_comparison_up(self) -> bool:
        """Whether the judgement is due."""
        return self.spent > self.seconds - self.judging

    def require_search(self) -> None:
        """Raise `TimeUp` once the time of search and comparison is up."""
        if self.is_comparison_up:
            raise TimeUp

    def require_first(self) -> None:
        """Raise it once the time of the first trial is up."""
        if self.spent > FIRST * self.seconds + FIRST_BESIDES:
            raise TimeUp


def time_said(seconds: float) -> str:
    """A time as --budget takes it, rounded up."""
    return f"{max(-(-seconds // 1), 1):.0f}s" if seconds <= 120.0 else f"{-(-seconds // 60):.0f}min"
