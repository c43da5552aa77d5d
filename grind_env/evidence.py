"""Evidence behind the numbers of a band, for checks of the model and for out-of-model machines."""

from dataclasses import dataclass
from enum import Enum


class Evidence(Enum):
    """What a number carries, from the strongest to the weakest."""

    MEASURED = "a measured number"
    DRAWN = "a band from data or tables"
    REMEMBERED = "a number from memory"
    OWN = "only our own band"


@dataclass(frozen=True, slots=True)
class Basis:
    """Where a band is from.

    Attributes:
        evidence: what stands behind its numbers. A relation that says no more than which way a trend goes is no number,
            whoever found it: what it allows is then a band of this project.
        text: where it was read, or who says so.
    """

    evidence: Evidence
    text: str

    def __str__(self) -> str:
        return f"{self.evidence.name.lower()}: {self.text}"
