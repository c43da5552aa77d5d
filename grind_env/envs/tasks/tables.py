"""The tables of a task file, one frozen dataclass each (scenarios, section 4)."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from grind_env.errors import GrindError


class TaskError(GrindError):
    """An unknown task or a task file that does not fit the dataclasses below."""


class ReadOnly(Mapping[str, float]):
    """Numbers by name that nobody can change: tasks are cached, and shared by all environments."""

    __slots__ = ("_numbers",)

    def __init__(self, numbers: Mapping[str, float] = MappingProxyType({})) -> None:
        self._numbers = dict(numbers)

    def __getitem__(self, name: str) -> float:
        return self._numbers[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __repr__(self) -> str:
        return repr(self._numbers)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionRange:
    """What an action can choose: a geometric range or levels of E in m/min, and up to `executions` for D."""

    executions: int
    speed_range: tuple[float, float] | None = None
    speed_levels: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if (self.speed_range is None) == (self.speed_levels is None):
            raise TaskError("[action] needs either speed_range or speed_levels: give exactly one of the two")

    @property
    def speed_ends(self) -> tuple[float, float]:
        """Lowest and highest E, m/min."""
        speeds = self.speed_levels or self.speed_range or ()
        return min(speeds), max(speeds)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Catalogue names of the set-up, with the values that this task changes in an entry.

    `wheel_speed` in m/s is that of the new wheel, `overrun` in mm, `load` in s for each part. With every part the
    convection of the coolant falls by the factor exp(-`coolant_ageing`).
    """

    wheel: str
    dresser: str
    fluid: str
    machine: str
    wheel_speed: float
    overrun: float
    load: float
    coolant_ageing: float = 0.0
    wheel_changes: Mapping[str, float] = field(default_factory=ReadOnly)
    machine_changes: Mapping[str, float] = field(default_factory=ReadOnly)


@dataclass(frozen=True, slots=True, kw_only=True)
class Dress:
    """The dress program of the task: diamond passes, lead (mm/rev) and depth (mm) of each, set-up (s)."""

    passes: int
    lead: float
    depth: float
    setup: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of cycle block.

    Lengths in mm, `roughness_limit` and `tolerance` in um (0 for none), `rise_allowance` in K, `scrap` in $.
    A block that does not start a part goes on with the part of the block before; scrap is charged with the
    block that ends it. The true stock is never less than `least_stock` times the nominal one.
    """

    name: str
    material: str
    stock: float
    pick: float
    sparkout: int
    width: float
    length: float
    scrap: float
    roughness_limit: float = 0.0
    tolerance: float = 0.0
    rise_allowance: float = 0.0
    least_stock: float = 0.4
    starts_part: bool = True
    ends_part: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Orders:
    """Small orders instead of a fixed sequence, each of one kind (all equally likely) and a lot of its own.

    An order has 1 to `most_parts` parts, all numbers equally likely; the last one ends with the episode.
    """

    most_parts: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Due:
    """Due dates: one after every `blocks` blocks.

    From one to the next it is the nominal time of the blocks between (E `speed` in m/min, no dress, nominal stock,
    loading included) times a factor that is drawn uniformly within `slack`. Lateness costs `late` $/h, without limit.
    """

    blocks: int
    speed: float
    slack: tuple[float, float]
    late: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelChange:
    """$ and s of a wheel change: a wheel below its minimum diameter is replaced by a new one, dressed."""

    price: float
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations of what an episode draws (scenarios, section 3).

    `stock` is relative, `gauge` in mm; both hold for blocks that start a part, since what a later block removes is
    what the block before it left. `measurement` is a factor on the noise of power, size and roughness readings,
    `diamond_flat` the largest start value in mm, `coolant_ageing` the half-width of a uniform factor around 1, the
    rest logarithmic.
    """

    stock: float = 0.0
    gauge: float = 0.0
    measurement: float = 0.0
    lot_probability: float = 0.0
    lot_growth: float = 0.0
    lot_pressure: float = 0.0
    wheel_growth: float = 0.0
    wheel_roughness: float = 0.0
    fracture_force: float = 0.0
    g_ratio: float = 0.0
    convection: float = 0.0
    coolant_ageing: float = 0.0
    diamond_flat: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """State of the wheel at the start where it differs from new and freshly dressed.

    `executions_left` gives the range of the number of dress executions left before the minimum diameter; it is
    drawn uniformly.
    """

    wear_flat_area: float | None = None
    volume: float = 0.0
    executions_left: tuple[float, float] | None = None


def refuse_unknown(table: Iterable[str], legal: Iterable[str], place: str) -> None:
    """Check keys or names.

    Raises:
        TaskError: at `place`, if one is not legal.
    """
    for key in table:
        if key not in legal:
            raise TaskError(f"{place}there is no {key}; legal are {', '.join(legal)}")
