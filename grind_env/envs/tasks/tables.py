"""The tables of a task file, one frozen dataclass each.

Annotations of fields give the legal values, lines under `Attributes` the meaning; the schema is made from both.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated

from grind_env.process.catalogue import USUAL
from grind_env.process.entries import Quantity
from grind_env.process.toml_tables import TableError, check, wrong

#: legal range of E, up to the limit of the control; the process model holds from 3000 to 40,000 mm/min
SPEED = Quantity("E", "mm/min", 1000, 60_000)
#: most characters in the name of a kind, which appears in messages and in names of observation entries
LONGEST_NAME = 40
USUAL_SPEEDS = (3000.0, 30_000.0)  #: range of E for a task that gives none, mm/min


class TaskError(TableError):
    """An unknown task, or a task file that does not fit the dataclasses below."""


class ReadOnly(Mapping[str, float]):
    """Read-only numbers by name: tasks are cached, and shared by all environments."""

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
    """Range of actions.

    Attributes:
        executions: most dress executions D of a block.
        speed_range: lowest and highest E, chosen geometrically between them; 3000 to 30,000 if there are no levels.
        speed_levels: the values of E to choose from, in place of a range.
    """

    executions: Annotated[int, Quantity("D", "", 0, 20)] = 3
    speed_range: Annotated[tuple[float, float] | None, SPEED] = None
    speed_levels: Annotated[tuple[float, ...] | None, SPEED] = None

    def __post_init__(self) -> None:
        if self.speed_range is not None and self.speed_levels is not None:
            raise TaskError("action has both speed_range and speed_levels: give one of the two", "action.speed_levels")
        if self.speed_range is None and self.speed_levels is None:
            object.__setattr__(self, "speed_range", USUAL_SPEEDS)
        check(self, "action", TaskError)
        low, high = self.speed_ends
        if not low < high:
            message = f"action.speed_range is {low:g} to {high:g}, but must leave a choice: let the second be higher"
            raise TaskError(message, "action.speed_range", self.speed_range)

    @property
    def speed_ends(self) -> tuple[float, float]:
        """Return the lowest and highest E, mm/min."""
        speeds = self.speed_levels or self.speed_range or ()
        return min(speeds), max(speeds)


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSetup:
    """Catalogue names of the set-up, with single values that this task overrides.

    Attributes:
        wheel: name of the grinding wheel.
        dresser: name of the diamond.
        fluid: name of the coolant.
        machine: name of the machine tool.
        wheel_speed: surface speed of the new wheel.
        overrun: overrun of the table on each side of the part; in a G82, a wheel one pick deep must clear the part.
        load: time to load each part, including the way of the wheel to the part.
        gauge: time to gauge a part between two blocks on it, including the way of the wheel off the part and back.
        coolant_ageing: every part multiplies the convection of the coolant by exp(-coolant_ageing).
        wheel_overrides: values that replace values of the wheel's catalogue entry, in its units.
        dresser_overrides: values that replace values of the dresser's catalogue entry, in its units.
        fluid_overrides: values that replace values of the fluid's catalogue entry, in its units.
        machine_overrides: values that replace values of the machine's catalogue entry, in its units.
    """

    wheel: str = USUAL["wheel"]
    dresser: str = USUAL["dresser"]
    fluid: str = USUAL["fluid"]
    machine: str = USUAL["machine"]
    wheel_speed: Annotated[float, Quantity("vs", "m/s", 5, 150)] = 30.0
    overrun: Annotated[float, Quantity("", "mm", 1, 1000)] = 30.0
    load: Annotated[float, Quantity("t_load", "s", 0, 86_400)] = 20.0
    gauge: Annotated[float, Quantity("t_gauge", "s", 0, 86_400)] = 10.0
    coolant_ageing: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    wheel_overrides: Mapping[str, float] = field(default_factory=ReadOnly)
    dresser_overrides: Mapping[str, float] = field(default_factory=ReadOnly)
    fluid_overrides: Mapping[str, float] = field(default_factory=ReadOnly)
    machine_overrides: Mapping[str, float] = field(default_factory=ReadOnly)

    def __post_init__(self) -> None:
        check(self, "setup", TaskError)
        whole_micrometres(self, "setup", "overrun")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dress:
    """The dress program of the task.

    Attributes:
        passes: number of passes of the diamond in an execution.
        lead: lead of the diamond in a wheel revolution.
        depth: depth of each pass.
        setup: time of an execution beyond the motions of the passes.
    """

    passes: Annotated[int, Quantity("", "", 1, 50)] = 2
    lead: Annotated[float, Quantity("", "mm", 0.005, 5)] = 0.10
    depth: Annotated[float, Quantity("", "mm", 0.001, 0.1)] = 0.02
    setup: Annotated[float, Quantity("t_d0", "s", 0, 86_400)] = 8.0

    def __post_init__(self) -> None:
        check(self, "dress", TaskError)
        whole_micrometres(self, "dress", "depth")


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of cycle block.

    Attributes:
        name: name of the kind in `sequence`.
        material: catalogue name of the work material.
        stock: depth to grind off.
        pick: depth of a plunge.
        sparkout: strokes at full depth after the plunges; traverses of a G83.
        width: width of the part.
        length: length of the part, along the table.
        height: height of the part above the chuck, which decides how it warms up and grows.
        scrap: price of a scrapped part, charged with its last block.
        roughness_limit: highest Ra; 0 for none.
        tolerance: largest size error, too large or too small; 0 for none.
        rise_allowance: allowed temperature rise above tempering, for a surface that is ground again later. With 0 only
            the plunges of the last 0.05 mm count, otherwise all plunges.
        least_stock: smallest ratio of the drawn stock of a part to the nominal stock.
        starts_part: whether the block starts a part; otherwise it continues that of the block before.
        ends_part: whether the block ends a part.
    """

    name: str = "part"
    material: str
    stock: Annotated[float, Quantity("H", "mm", 0.001, 20)]
    pick: Annotated[float, Quantity("J", "mm", 0.001, 20)]
    sparkout: Annotated[int, Quantity("L", "", 0, 1000)] = 2
    width: Annotated[float, Quantity("b", "mm", 0.5, 2000)]
    length: Annotated[float, Quantity("Lw", "mm", 1, 10_000)]
    height: Annotated[float, Quantity("", "mm", 0.1, 10_000)]
    scrap: Annotated[float, Quantity("", "$", 0, 1e6)] = 50.0
    roughness_limit: Annotated[float, Quantity("Ra", "um", 0, 50)] = 0.0
    tolerance: Annotated[float, Quantity("tol", "um", 0, 1000)] = 0.0
    rise_allowance: Annotated[float, Quantity("dT", "K", 0, 2000)] = 0.0
    least_stock: Annotated[float, Quantity("", "", 0.01, 1)] = 0.4
    starts_part: bool = True
    ends_part: bool = True

    def __post_init__(self) -> None:
        check(self, "kind", TaskError)
        if not (self.name.isprintable() and 0 < len(self.name) <= LONGEST_NAME):
            raise wrong("kind.name", self.name, f"1 to {LONGEST_NAME} printable characters", TaskError)
        whole_micrometres(self, "kind", "stock", "pick", "width", "length")


@dataclass(frozen=True, slots=True, kw_only=True)
class Orders:
    """Small orders instead of a fixed sequence, each of one kind (all equally likely) and of one lot.

    An order has 1 to `most_parts` parts, all equally likely; the episode may end within the last order.

    Attributes:
        most_parts: most parts of an order.
    """

    most_parts: Annotated[int, Quantity("", "", 1, 1000)]

    def __post_init__(self) -> None:
        check(self, "orders", TaskError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Due:
    """Due dates; the time between two dates is the nominal time of the blocks between them times a factor.

    The nominal time includes loading and has nominal stock and no dresses.

    Attributes:
        blocks: number of blocks from one due date to the next.
        speed: E at which the nominal time is computed.
        slack: lowest and highest factor on the nominal time, drawn uniformly.
        late: price of lateness, without limit.
    """

    blocks: Annotated[int, Quantity("", "", 1, 10_000)]
    speed: Annotated[float, SPEED]
    slack: Annotated[tuple[float, float], Quantity("", "", 0, 100)]
    late: Annotated[float, Quantity("", "$/h", 0, 1e6)]

    def __post_init__(self) -> None:
        check(self, "due", TaskError)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelChange:
    """A wheel below its minimum diameter is replaced by a new one, dressed; without this table it stays.

    Attributes:
        price: price of the change.
        seconds: time of the change.
    """

    price: Annotated[float, Quantity("", "$", 0, 1e6)]
    seconds: Annotated[float, Quantity("", "s", 0, 86_400)]

    def __post_init__(self) -> None:
        check(self, "wheel_change", TaskError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Random draws of an episode; 0 for a fixed value.

    `stock` and `gauge` hold for blocks that start a part; a later block removes the rest of the block before it.
    Logarithmic standard deviations belong to factors.

    Attributes:
        stock: standard deviation of the stock of a part over the nominal one.
        gauge: standard deviation of the error of the gauged stock.
        measurement: factor on the noise of power, size and roughness readings; 0 for exact gauges.
        lot_probability: probability that a part begins a new lot of material.
        lot_growth: logarithmic standard deviation of the dulling rate of a lot.
        lot_pressure: logarithmic standard deviation of a lot's pressure on the wear flats.
        wheel_growth: logarithmic standard deviation of the dulling rate of a wheel.
        wheel_roughness: logarithmic standard deviation of the roughness from a wheel.
        part_roughness: logarithmic standard deviation of the roughness from part to part.
        fracture_force: logarithmic standard deviation of the grade of a wheel.
        g_ratio: logarithmic standard deviation of the G-ratio of a wheel.
        convection: logarithmic standard deviation of the convection of the coolant.
        coolant_ageing: half-width of a uniform factor around 1 on `setup.coolant_ageing`.
        diamond_flat: widest wear flat of the diamond at the start, which is drawn uniformly from 0.
    """

    stock: Annotated[float, Quantity("", "", 0, 0.5)] = 0.0
    gauge: Annotated[float, Quantity("", "mm", 0, 0.1)] = 0.0
    measurement: Annotated[float, Quantity("", "", 0, 10)] = 0.0
    lot_probability: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    lot_growth: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    lot_pressure: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    wheel_growth: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    wheel_roughness: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    part_roughness: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    fracture_force: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    g_ratio: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    convection: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    coolant_ageing: Annotated[float, Quantity("", "", 0, 1)] = 0.0
    diamond_flat: Annotated[float, Quantity("wd", "mm", 0, 1)] = 0.0

    def __post_init__(self) -> None:
        check(self, "spread", TaskError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """State of the wheel at the start where it differs from new and freshly dressed.

    Attributes:
        wear_flat_area: wear-flat area A, a share of the wheel face; left out for a freshly dressed wheel.
        volume: volume V ground since the last dress.
        executions_left: fewest and most dress executions left before the minimum diameter, drawn uniformly; left out
            for a new wheel.
    """

    wear_flat_area: Annotated[float | None, Quantity("A", "", 1e-4, 0.5)] = None
    volume: Annotated[float, Quantity("V", "mm3/mm", 0, 1e6)] = 0.0
    executions_left: Annotated[tuple[float, float] | None, Quantity("", "", 0, 1e6)] = None

    def __post_init__(self) -> None:
        check(self, "start", TaskError)


def whole_micrometres(table: object, place: str, *names: str) -> None:
    """Check lengths that become words of a program, which the control reads to 0.001 mm.

    Raises:
        TaskError: a length is no multiple of 0.001 mm.
    """
    for name in names:
        value = getattr(table, name)
        if round(value, 3) != value:
            key = f"{place}.{name}" if place else name
            legal = f"a multiple of 0.001 mm, as the control reads it: {round(value, 3):g}"
            raise wrong(key, value, legal, TaskError)
