"""What adapts a policy to a machine, and the log of a shift, which is all that it gets of it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackShift:
    """A shift on a machine, as the shop has it in its books.

    Attributes:
        observations: what was measured before every block, and after the last one, shape (blocks + 1, entries).
        speeds: E of every block, mm/min, shape (blocks,).
        executions: D of every block, shape (blocks,).
        cost: of every block, $: time, wheel, dresses, late orders, wheel changes, and the price of a part found to be
            bad; what it costs to hand over a dull wheel nobody measures.
        bad: whether the part that the block finished was found to be bad.
    """

    observations: NDArray[np.float32]
    speeds: Array
    executions: Array
    cost: Array
    bad: NDArray[np.bool_]


class Adapter(Protocol):
    """Adapts a policy to one machine, of which it gets measurements alone.

    It has what it has been made from without limit: the simulator of the model, and the public plants. One is made anew
    for every machine and seed.
    """

    @property
    def name(self) -> str:
        """In tables."""

    def start(self, problem: Problem) -> Policy:
        """The policy with which it begins, which sees measurements; the problem is on the model."""

    def learn(self, shift: TrackShift) -> Policy:
        """The policy of the next shift, after one that was ground with the last one."""
