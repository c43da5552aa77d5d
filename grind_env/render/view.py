"""The data of a picture of an episode, without simulation or drawing library."""

from dataclasses import dataclass

from grind_env.errors import GrindError
from grind_env.process.cost import SCRAP_BELOW, Limits, passed_limits
from grind_env.process.state import WheelState

FAULTS = {"rise": "burn", "power": "stall", "roughness": "Ra", "size": "size"}
"""What a picture calls the passing of a limit, by the field of `process.cost.Limits`."""


class RenderError(GrindError):
    """A picture that cannot be drawn or shown."""


class NoScreenError(RenderError):
    """There is no screen for a window."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """Extent of an episode: constant values that set the scales of its pictures."""

    title: str
    blocks: int
    """Cycle blocks of the episode."""
    parts: int
    """Parts that these blocks finish."""
    new_diameter: float
    """New diameter of the wheel, mm."""
    lowest_speed: float
    """Lowest E, mm/min."""
    highest_speed: float
    """Highest E, mm/min."""
    most_executions: int
    """Highest D."""
    longest: float
    """Length of the longest part, mm."""
    thickest: float
    """Stock that fills the height set aside for it, mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundBlock:
    """A cycle block that has been ground."""

    speed: float
    """E, mm/min."""
    executions: int
    """D."""
    power: float
    """Highest power above idle, W."""
    torque: float
    """Highest torque over that at which the spindle stalls."""
    rise: float
    """Highest temperature rise that counts, K."""
    roughness: float
    """Ra that it left, um."""
    size_error: float
    """Stock that it left, um."""
    limits: Limits
    """Limits of the part."""
    cost: float
    """$."""
    finished: bool
    """Whether it finished a part."""
    good: float
    """Probability that this part is good; 0 if it finished none."""

    @property
    def faults(self) -> tuple[str, ...]:
        """Return the exceeded limits: any of `burn`, `stall`, `Ra` and `size`."""
        passed = passed_limits(self.rise, self.torque, self.roughness, self.size_error, self.limits)
        return tuple(FAULTS[limit] for limit in passed)


@dataclass(frozen=True, slots=True, kw_only=True)
class Workpiece:
    """The part on the table: its kind, and how much of the stock of the block is still on it."""

    name: str
    length: float
    """mm."""
    stock: float
    """Stock before the block, mm."""
    left: float
    """Stock still on the part, mm; below 0 on one that is too thin."""

    @property
    def description(self) -> str:
        return f"{self.name}, {self.length:.0f} mm long, stock {self.stock:.3f} mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureInstant:
    """An instant within a block, for an animation; a picture without one shows the machine at rest."""

    table: float
    """Where the table stands, from -1 at the secondary to 1 at the primary reversal point."""
    spin: float
    """Turns of the wheel."""
    dressing: bool
    """Whether the diamond is at the wheel."""
    speed: float
    """E of the block that is running, mm/min."""
    executions: int
    """Its D."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodePicture:
    """One picture of an episode."""

    extent: Extent
    ground: tuple[GroundBlock, ...]
    """The blocks ground so far."""
    wheel: WheelState
    part: Workpiece
    text: str
    """The block last run or, with `instant`, running; empty before the first."""
    instant: PictureInstant | None = None

    @property
    def title(self) -> str:
        return self.extent.title

    @property
    def last(self) -> GroundBlock | None:
        """Return the last finished block, whose marks the part bears unless another is running."""
        return self.ground[-1] if self.ground and self.instant is None else None

    @property
    def number(self) -> int:
        """Number of the block that the picture shows, from 1; 0 before the first."""
        return len(self.ground) + (self.instant is not None)

    @property
    def cost(self) -> float:
        """Cost so far, $."""
        return sum(block.cost for block in self.ground)

    @property
    def good_parts(self) -> float:
        return sum(block.good for block in self.ground)

    @property
    def finished_parts(self) -> int:
        return sum(block.finished for block in self.ground)

    @property
    def scrapped(self) -> int:
        """Parts finished so far that are more likely bad than good."""
        return sum(block.finished and block.good < SCRAP_BELOW for block in self.ground)

    @property
    def price(self) -> str:
        """Return the cost of a good part so far, in words."""
        if self.good_parts < SCRAP_BELOW:
            return f"{self.cost:.2f} $ and no good part"
        return f"{self.cost / self.good_parts:.2f} $ per good part"

    @property
    def verdict(self) -> str:
        """Return the result of the part of the last block, in words; empty if another is running or none was."""
        last = self.last
        if last is None:
            return ""
        if last.faults:
            return "beyond its limit: " + ", ".join(last.faults)
        if not last.finished:
            return "within its limits, to be ground on"
        return "good part" if last.good >= SCRAP_BELOW else "scrap"

    @property
    def radius_lost(self) -> float:
        """Return the wheel radius lost by wear and dressing, mm."""
        return 0.5 * (self.extent.new_diameter - self.wheel.ds)
