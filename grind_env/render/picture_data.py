"""The data of a picture of an episode, without simulation or drawing library."""

from dataclasses import dataclass

from grind_env.errors import GrindError
from grind_env.process.cost import SCRAP_BELOW, Limits, passed_limits
from grind_env.process.stroke_types import WheelState

#: name of an exceeded limit in a picture, by the field of `process.cost.Limits`
FAULTS = {"rise": "burn", "power": "stall", "roughness": "Ra", "size": "size"}


class RenderError(GrindError):
    """A picture that cannot be drawn or shown."""


class NoScreenError(RenderError):
    """There is no screen for a window."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """Extent of an episode: constant values that set the scales of its pictures."""

    title: str
    blocks: int  #: cycle blocks of the episode
    parts: int  #: number of parts that these blocks finish
    new_diameter: float  #: new diameter of the wheel, mm
    lowest_speed: float  #: lowest E, mm/min
    highest_speed: float  #: highest E, mm/min
    most_executions: int  #: highest D
    longest: float  #: length of the longest part, mm
    thickest: float  #: stock that fills the height for stock in the picture, mm


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundBlock:
    """A cycle block that has been ground."""

    speed: float  #: E, mm/min
    executions: int  #: D, number of dresses
    power: float  #: highest power above idle, W
    torque: float  #: ratio of the highest torque to the torque at which the spindle stalls
    rise: float  #: highest temperature rise that counts, K
    roughness: float  #: Ra after the block, um
    size_error: float  #: stock left after the block, um
    limits: Limits  #: limits of the part
    cost: float  #: cost of the block, $
    finished: bool  #: whether the block finished a part
    good: float  #: probability that the finished part is good; 0 if the block finished none

    @property
    def faults(self) -> tuple[str, ...]:
        """Return the exceeded limits: any of `burn`, `stall`, `Ra` and `size`."""
        passed = passed_limits(self.rise, self.torque, self.roughness, self.size_error, self.limits)
        return tuple(FAULTS[limit] for limit in passed)


@dataclass(frozen=True, slots=True, kw_only=True)
class Workpiece:
    """The part on the table: its kind, and the stock still on it."""

    name: str
    length: float  #: length of the part, mm
    stock: float  #: stock before the block, mm
    left: float  #: stock still on the part, mm; below 0 if the part is too thin

    @property
    def description(self) -> str:
        return f"{self.name}, {self.length:.0f} mm long, stock {self.stock:.3f} mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureInstant:
    """An instant within a block, for an animation; a picture without one shows the machine at rest."""

    table: float  #: position of the table, from -1 at the secondary to 1 at the primary reversal point
    spin: float  #: number of turns of the wheel
    dressing: bool  #: whether the diamond is at the wheel
    speed: float  #: E of the block that is running, mm/min
    executions: int  #: D of the block that is running, number of dresses


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodePicture:
    """One picture of an episode."""

    extent: Extent
    ground: tuple[GroundBlock, ...]  #: the blocks ground so far
    wheel: WheelState
    part: Workpiece
    text: str  #: text of the last block or, with `instant`, of the running block; empty before the first block
    instant: PictureInstant | None = None

    @property
    def last(self) -> GroundBlock | None:
        """Return the last block ground, whose marks are on the part; None during a block or before the first."""
        return self.ground[-1] if self.ground and self.instant is None else None

    @property
    def number(self) -> int:
        """Number of the block in the picture, from 1; 0 before the first."""
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
        """Number of parts finished so far that are more likely bad than good."""
        return sum(block.finished and block.good < SCRAP_BELOW for block in self.ground)

    @property
    def price(self) -> str:
        """Return the cost of a good part so far, in words."""
        if self.good_parts < SCRAP_BELOW:
            return f"{self.cost:.2f} $ and no good part"
        return f"{self.cost / self.good_parts:.2f} $ per good part"

    @property
    def verdict(self) -> str:
        """Return the result for the part of the last block, in words; empty during a block or before the first."""
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
