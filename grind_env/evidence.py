"""Evidence behind the numbers of a band, for checks of the model and for out-of-model machines."""

from dataclasses import dataclass
from enum import Enum


class Evidence(Enum):
    """Kinds of evidence for a number, from the strongest to the weakest."""

    MEASURED = "a measured number"
    DRAWN = "a band from data or tables"
    REMEMBERED = "a number from memory"
    OWN = "only our own band"


@dataclass(frozen=True, slots=True)
class Basis:
    """Source of a band."""

    evidence: Evidence  #: evidence for the numbers; the project's own if the source gives only the direction of a trend
    text: str  #: reference, or the name of a person

    def __str__(self) -> str:
        return f"{self.evidence.name.lower()}: {self.text}"
