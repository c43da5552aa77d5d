"""The rule on the full state of who cannot know all of it before a block: what each measurement would be worth."""

from dataclasses import dataclass
from typing import ClassVar

from grind_env.policies.planners.known_state import FullStateRule


@dataclass(kw_only=True)
class GrowthRule(FullStateRule):
    """Knows how dull the wheel is and how fast the lot dulls it, but not which Ra wheel and part give."""

    gR: float = 0.0
    name: ClassVar[str] = "growth_rule"


@dataclass(kw_only=True)
class RoughnessRule(FullStateRule):
    """Knows how dull the wheel is and which Ra wheel and part give, but not how fast the lot dulls it."""

    gK: float = 0.0
    wK: float = 0.0
    name: ClassVar[str] = "roughness_rule"


@dataclass(kw_only=True)
class DullnessRule(GrowthRule):
    """Knows how dull the wheel is, and no more."""

    gK: float = 0.0
    wK: float = 0.0
    name: ClassVar[str] = "dullness_rule"
