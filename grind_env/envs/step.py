"""The compiled step of every environment: cycles for the coming blocks, the loops over their strokes, what came of it.

Arrays come in plain tuples: Python hands over three of them (1.8 us) about as fast as all their arrays one by one
(1.2 us), and named ones much slower (6 us). A `Work` says how they are named within.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.kernel import entry


class Work(NamedTuple):
    """A step as one form of environments does it: named tuples of arrays, and compiled functions of them."""

    tables: type[Any]
    """What is the same for all episodes, and room for the cycles of N machines."""
    episodes: type[Any]
    """The state of N episodes, their first axis."""
    choices: type[Any]
    """What is chosen for their coming blocks, each of N rows."""
    prepare: Callable[..., None]
    """`prepare(tables, episodes, choices, active, results)`: rows of the cycles and their parameters; loads parts. What
    results hold before a cycle (a spindle that has stalled on the part) is written, too."""
    grind: Callable[..., None]
    """`grind(tables, episodes, choices, active, results)`: runs the cycles."""
    settle: Callable[..., None]
    """`settle(tables, episodes, choices, active, results, outcomes)`: writes what they have cost and shown, and goes on
    to the next blocks."""
    together: int = 1024
    """Episodes that are prepared, ground and settled in one go, few enough that their rows stay in a near cache."""


def step_of(work: Work) -> Callable[..., None]:
    """The compiled step of a form."""
    tables_of, episodes_of, choices_of, together = work.tables, work.episodes, work.choices, work.together
    prepare, grind, settle = work.prepare, work.grind, work.settle

    @entry
    def step(tables: Any, episodes: Any, choices: Any, active: Any, results: Any, outcomes: Any) -> None:
        """Grind the next block of the episodes in `active`.

        Args:
            tables: what `work.tables` names, as a tuple, like the next two.
            episodes: what `work.episodes` names; updated.
            choices: what `work.choices` names.
            active: indices of the episodes to step, int64.
            results: shape (N, fields of `Tally`), all 0; written in the rows of `active`.
            outcomes: shape (N, fields of `Outcome`); written likewise.
        """
        numbers, state, chosen = tables_of(*tables), episodes_of(*episodes), choices_of(*choices)
        for first in range(0, active.size, together):
            some = active[first : first + together]
            prepare(numbers, state, chosen, some, results)
            grind(numbers, state, chosen, some, results)
            settle(numbers, state, chosen, some, results, outcomes)

    return step
