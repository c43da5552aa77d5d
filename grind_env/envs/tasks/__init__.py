"""The tasks, one declarative TOML file each (scenarios, section 4), read into frozen dataclasses."""

import functools
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, TypeVar

from grind_env.envs.names import FOLDER, task_names
from grind_env.errors import GrindError
from grind_env.process.catalogue import Entry, load_catalogue, quantities
from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import Machine, Wheel
from grind_env.process.parameters import stroke_parameters
from grind_env.process.state import StrokeParameters

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

EntryT = TypeVar("EntryT", bound=Entry)

DRESS_CLEARANCE = 10.0
"""mm that a dress traverse runs beyond the wheel width, both sides together."""


class TaskError(GrindError):
    """An unknown task or a task file that does not fit the dataclasses below."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionRange:
    """What an action can choose: a geometric range or levels of E in m/min, and up to `executions` for D."""

    executions: int
    speed_range: tuple[float, float] | None = None
    speed_levels: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if (self.speed_range is None) == (self.speed_levels is None):
            raise TaskError("[action] needs either speed_range or speed_levels: give exactly one of the two")


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Catalogue names of the set-up, with the values that this task changes in an entry."""

    wheel: str
    dresser: str
    fluid: str
    machine: str
    wheel_speed: float
    overrun: float
    load: float
    wheel_changes: Mapping[str, float] = field(default_factory=dict)
    machine_changes: Mapping[str, float] = field(default_factory=dict)


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
    block that ends it.
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
    starts_part: bool = True
    ends_part: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations of what an episode draws (scenarios, section 3); all 0 is the deterministic task.

    `stock` is relative, `gauge` in mm, `measurement` a factor on the noise of power, size and roughness
    readings, `diamond_flat` the largest start value in mm, the rest logarithmic.
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
    diamond_flat: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """State of the wheel at the start where it differs from freshly dressed."""

    wear_flat_area: float | None = None
    volume: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A job: its blocks, its set-up and what is drawn at random."""

    name: str
    title: str
    blocks: int
    sequence: tuple[str, ...]
    reference_cost: float
    action: ActionRange
    setup: Setup
    dress: Dress
    kinds: tuple[Kind, ...]
    observation: str = "measured"
    spread: Spread = field(default_factory=Spread)
    start: Start = field(default_factory=Start)
    factors: Mapping[str, float] = field(default_factory=dict)

    def kind_of_block(self, block: int) -> int:
        """Index into `kinds` of a block; the sequence repeats."""
        names = [kind.name for kind in self.kinds]
        return names.index(self.sequence[block % len(self.sequence)])

    @property
    def wheel(self) -> Wheel:
        """The wheel, with the changes of this task."""
        return _changed(load_catalogue().wheel(self.setup.wheel), self.setup.wheel_changes, "[setup.wheel_changes]: ")

    @property
    def machine(self) -> Machine:
        """The machine, with the changes of this task."""
        return _changed(
            load_catalogue().machine(self.setup.machine),
            self.setup.machine_changes,
            "[setup.machine_changes]: ",
        )

    @property
    def rates(self) -> Rates:
        """Prices of time, wheel and dresser."""
        dresser = load_catalogue().dresser(self.setup.dresser)
        return Rates(self.machine.hourly_rate, self.wheel.price, dresser.cost_per_dress)

    def parameters(self, kind: Kind) -> StrokeParameters:
        """Stroke parameters of a block kind, with the fixed factors of this task."""
        catalogue = load_catalogue()
        p = stroke_parameters(
            catalogue.material(kind.material),
            self.wheel,
            catalogue.dresser(self.setup.dresser),
            catalogue.fluid(self.setup.fluid),
            self.machine,
            wheel_speed=self.setup.wheel_speed,
        )
        _refuse_unknown(self.factors, StrokeParameters._fields, "[factors]: ")
        return p._replace(**{name: getattr(p, name) * factor for name, factor in self.factors.items()})

    def limits(self, kind: Kind) -> Limits:
        """Limits of a good part of that kind."""
        tempering = load_catalogue().material(kind.material).tempering_rise
        return Limits(tempering + kind.rise_allowance, self.machine.power_limit, kind.roughness_limit, kind.tolerance)

    @property
    def wheel_revolutions(self) -> float:
        """Wheel speed, 1/s."""
        return 1000.0 * self.setup.wheel_speed / (math.pi * self.wheel.diameter)

    @property
    def dress_feed(self) -> float:
        """Traverse feed of the diamond, mm/s; in mm/min it has three decimals, as the control reads it."""
        return round(60.0 * self.dress.lead * self.wheel_revolutions, 3) / 60.0

    @property
    def dress_lead(self) -> float:
        """Lead that this feed gives, mm per wheel revolution."""
        return self.dress_feed / self.wheel_revolutions

    @property
    def dress_seconds(self) -> float:
        """Time of one dress execution, s."""
        return self.dress.setup + self.dress.passes * (self.wheel.width + DRESS_CLEARANCE) / self.dress_feed


TABLES: Mapping[str, type[Any]] = {
    "action": ActionRange,
    "setup": Setup,
    "dress": Dress,
    "spread": Spread,
    "start": Start,
}


@functools.cache
def load_task(name: str) -> Task:
    """The task of that name.

    Raises:
        TaskError: if there is no such task, or its file lacks a key or has one that does not exist.
    """
    if name not in task_names():
        raise TaskError(f"there is no task {name!r}: the tasks are {', '.join(task_names())}")
    try:
        return _task(name, tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8")))
    except tomllib.TOMLDecodeError as error:
        raise TaskError(f"{name}.toml: not valid TOML: {error}") from None
    except GrindError as error:
        raise TaskError(f"{name}.toml: {error}") from None


def _task(name: str, document: Mapping[str, Any]) -> Task:
    plain = [item.name for item in fields(Task) if item.name not in ("name", "kinds", *TABLES)]
    _refuse_unknown(document, [*plain, *TABLES, "kind"], "")
    tables = {key: _read(kind, document.get(key, {}), f"[{key}]: ") for key, kind in TABLES.items()}
    kinds = tuple(_read(Kind, table, "[[kind]]: ") for table in document.get("kind", ()))
    values = {key: document[key] for key in plain if key in document}
    task: Task = _read(Task, values, "", name=name, kinds=kinds, **tables)
    _refuse_unknown(task.sequence, [kind.name for kind in kinds], "sequence: ")
    for kind in kinds:
        # looks up every name of the catalogue and every key of the changes
        task.parameters(kind)
    return task


def _read(kind: type[Any], table: Mapping[str, Any], place: str, **given: Any) -> Any:
    """An instance of a dataclass from a table of a task file; `given` are the fields not in the table."""
    expected = [item for item in fields(kind) if item.name not in given]
    _refuse_unknown(table, [item.name for item in expected], place)
    for item in expected:
        if item.default is MISSING and item.default_factory is MISSING and item.name not in table:
            raise TaskError(f"{place}the key {item.name} is missing")
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()}
    return kind(**given, **values)


def _changed(entry: EntryT, changes: Mapping[str, Any], place: str) -> EntryT:
    """A catalogue entry with the changes of a task."""
    _refuse_unknown(changes, quantities(type(entry)), place)
    return replace(entry, **changes)


def _refuse_unknown(table: Iterable[str], legal: Iterable[str], place: str) -> None:
    for key in table:
        if key not in legal:
            raise TaskError(f"{place}there is no {key}; legal are {', '.join(legal)}")
