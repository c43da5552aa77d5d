"""G81: the table reciprocates without infeed (16-13).

The cycle has no strokes of its own: the table continues beside the program until G80 or another cycle.
"""

from typing import NamedTuple

from grind_env.control.events import CyclePlan


class ReciprocationCycle(NamedTuple):
    """Parameters of a G81 block."""

    pre_dress: float  #: 1 for G81.1, else 0


class ReciprocationProgress(NamedTuple):
    """Progress of a G81 cycle."""

    reversal: float  #: number of strokes made; also the number of the reversal point reached
    dresses: float  #: number of dresses at this reversal, before the next stroke

    @property
    def depth(self) -> float:
        """Depth of the plunge picks, mm: 0, as there are none."""
        return 0.0


def cycle_of(plan: CyclePlan, coverage: bool) -> ReciprocationCycle:
    """Return the numbers of a block; a cycle without depth has no coverage pass."""
    return ReciprocationCycle(pre_dress=float(plan.pre_dress))


def begin(cycle: ReciprocationCycle) -> ReciprocationProgress:
    """Return the progress before the first stroke."""
    return ReciprocationProgress(reversal=0.0, dresses=cycle.pre_dress)


def after_reversal(cycle: ReciprocationCycle, progress: ReciprocationProgress) -> ReciprocationProgress:
    """Return the progress after the next stroke; no pick follows."""
    return ReciprocationProgress(reversal=progress.reversal + 1.0, dresses=0.0)


def finished(cycle: ReciprocationCycle, progress: ReciprocationProgress) -> bool:
    """Return True: the block is done as soon as the table is free to set out."""
    return True


def least_strokes(cycle: ReciprocationCycle) -> float:
    """Return 0: the strokes of the table are not counted as strokes of the cycle."""
    return 0.0
