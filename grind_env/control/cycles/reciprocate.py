"""G81: the table reciprocates without infeed (16-13).

The cycle has no strokes of its own: the table continues beside the program until G80 or another cycle.
"""

from typing import NamedTuple

from grind_env.control.motions import CyclePlan


class ReciprocationCycle(NamedTuple):
    """Parameters of a G81 block."""

    pre_dress: float
    """1 for G81.1, else 0."""


class ReciprocationProgress(NamedTuple):
    """Progress of a G81 cycle."""

    reversal: float
    """Number of strokes made, which is that of the reversal point reached."""
    dresses: float
    """Number of executions to run at this reversal, before the next stroke."""

    @property
    def depth(self) -> float:
        """Depth of the plunge picks; there are none."""
        return 0.0


def cycle_of(plan: CyclePlan, coverage: bool) -> ReciprocationCycle:
    """The numbers of a block; there is no depth for a coverage pass."""
    return ReciprocationCycle(pre_dress=float(plan.pre_dress))


def begin(cycle: ReciprocationCycle) -> ReciprocationProgress:
    """Before the first stroke."""
    return ReciprocationProgress(reversal=0.0, dresses=cycle.pre_dress)


def after_reversal(cycle: ReciprocationCycle, progress: ReciprocationProgress) -> ReciprocationProgress:
    """After the next stroke, which nothing follows."""
    return ReciprocationProgress(reversal=progress.reversal + 1.0, dresses=0.0)


def finished(cycle: ReciprocationCycle, progress: ReciprocationProgress) -> bool:
    """Whether there is no stroke to make any more: the block is done once the table is free to set out."""
    return True


def least_strokes(cycle: ReciprocationCycle) -> float:
    """Strokes that it makes at least: those of the table are none of its own."""
    return 0.0
