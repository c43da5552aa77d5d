"""Limits on the work of a program, so that no program runs without end."""

import math

from grind_env.control.cli_options import CHECK_COMMANDS
from grind_env.control.errors import Place


class BlockBudget:
    """Counter of blocks and strokes, including those of subprograms and dress programs."""

    def __init__(self, limit: int) -> None:
        self.limit, self.spent = limit, 0

    def spend(self, place: Place, count: int = 1) -> None:
        self.spent += count
        self.foresee(0, place)

    def foresee(self, count: float, place: Place) -> None:
        """Raise `ControlError` if at least `count` more blocks and strokes would exceed the limit."""
        if self.spent + count > self.limit:
            raise place.error(
                "block-budget",
                f"the program comes to more than {self.limit} blocks and strokes; let it repeat less or infeed more at "
                f"a time, or allow more of them with --max-blocks of {CHECK_COMMANDS} (block_budget)",
            )


class Rounds:
    """Repeated execution, such as of a subprogram; the first rounds predict the rest.

    Each further round is assumed to need as many blocks as the shortest finished one. The forecast begins after two
    rounds, because the first may differ. Nested rounds multiply.
    """

    def __init__(self, budget: BlockBudget, place: Place, count: int, within: "Rounds | None" = None) -> None:
        self.budget, self.place = budget, place
        self.count: int = count * (1 if within is None else within.count - within.made)
        self.made: int = 0
        self.least, self.began = math.inf, budget.spent

    def end_round(self) -> None:
        """Count a finished round; raise `ControlError` if all rounds together are too many."""
        self.least, self.began = min(self.least, self.budget.spent - self.began), self.budget.spent
        self.made += 1
        if self.made > 1:
            self.budget.foresee(self.least * (self.count - self.made), self.place)
