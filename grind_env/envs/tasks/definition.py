"""A task: the tables of its file joined, checked, and turned into the numbers of the process model."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from grind_env.control.rules import motion_time, picks_to
from grind_env.envs.tasks.tables import (
    ActionRange,
    Dress,
    Due,
    Kind,
    Orders,
    ReadOnly,
    Setup,
    Spread,
    Start,
    TaskError,
    WheelChange,
    refuse_unknown,
)
from grind_env.process.catalogue import Entry, load_catalogue, quantities
from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import Machine, Wheel
from grind_env.process.parameters import limits_of, rates_of, stroke_parameters
from grind_env.process.state import StrokeParameters

EntryT = TypeVar("EntryT", bound=Entry)

DRESS_CLEARANCE = 10.0
"""mm that a dress traverse runs beyond the wheel width, both sides together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A job: its blocks, its set-up and what is drawn at random.

    `reference_cost` is in $ per block; `infeed` in mm/min is that of a wheel that the program feeds down while the
    table reciprocates, 0 for the picks of a cycle; `cross_pick` in mm that of a G83, 0 for cycles without.

    Raises:
        TaskError: if the blocks do not make whole parts, or the due dates whole episodes.
    """

    name: str
    title: str
    blocks: int
    reference_cost: float
    action: ActionRange
    setup: Setup
    dress: Dress
    kinds: tuple[Kind, ...]
    sequence: tuple[str, ...] = ()
    orders: Orders | None = None
    due: Due | None = None
    wheel_change: WheelChange | None = None
    observation: str = "measured"
    infeed: float = 0.0
    cross_pick: float = 0.0
    spread: Spread = field(default_factory=Spread)
    start: Start = field(default_factory=Start)
    factors: Mapping[str, float] = field(default_factory=ReadOnly)

    def __post_init__(self) -> None:
        if bool(self.sequence) == (self.orders is not None):
            raise TaskError("the blocks need either sequence or [orders]: give exactly one of the two")
        if self.orders is not None:
            for kind in self.kinds:
                if not (kind.starts_part and kind.ends_part):
                    raise TaskError(f"[orders]: a {kind.name} is no whole part: let it start and end one")
            if self.orders.most_parts < 1:
                raise TaskError(f"[orders]: most_parts is {self.orders.most_parts}, but must be at least 1")
        if self.due is not None and (self.due.blocks < 1 or self.blocks % self.due.blocks):
            raise TaskError(f"[due]: blocks is {self.due.blocks}, but must divide the {self.blocks} blocks evenly")
        self.numbers(self.nominal_sequence, "sequence: ")

    @property
    def nominal_sequence(self) -> tuple[str, ...]:
        """Names of the kinds, to be repeated; with orders, one order of middling size of each kind in turn."""
        if self.orders is None:
            return self.sequence
        parts = (1 + self.orders.most_parts) // 2
        return tuple(kind.name for kind in self.kinds for _ in range(parts))

    def numbers(self, sequence: tuple[str, ...], place: str) -> tuple[int, ...]:
        """Indices into `kinds` of all blocks, if the sequence repeats.

        Raises:
            TaskError: at `place`, if a kind is unknown or the blocks do not make whole parts.
        """
        names = [kind.name for kind in self.kinds]
        refuse_unknown(sequence, names, place)
        numbers = [names.index(name) for _, name in zip(range(self.blocks), itertools.cycle(sequence), strict=False)]
        kinds = [self.kinds[number] for number in numbers]
        whole = all(a.ends_part == b.starts_part for a, b in itertools.pairwise(kinds))
        if not (kinds and whole and kinds[0].starts_part and kinds[-1].ends_part):
            raise TaskError(f"{place}{', '.join(sequence)} does not make {self.blocks} blocks of whole parts")
        return tuple(numbers)

    def kind_of_block(self, block: int) -> int:
        """Index into `kinds` of a block of the nominal sequence, which repeats; episodes of orders have others."""
        sequence = self.nominal_sequence
        return [kind.name for kind in self.kinds].index(sequence[block % len(sequence)])

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
        return rates_of(self.wheel, load_catalogue().dresser(self.setup.dresser), self.machine)

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
        refuse_unknown(self.factors, StrokeParameters._fields, "[factors]: ")
        return p._replace(**{name: getattr(p, name) * factor for name, factor in self.factors.items()})

    def limits(self, kind: Kind) -> Limits:
        """Limits of a good part of that kind."""
        return limits_of(
            load_catalogue().material(kind.material),
            self.machine,
            rise_allowance=kind.rise_allowance,
            roughness_limit=kind.roughness_limit,
            tolerance=kind.tolerance,
        )

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

    @property
    def execution_depth(self) -> float:
        """What one dress execution takes off the wheel diameter, mm."""
        return 2.0 * self.dress.passes * self.dress.depth

    def stroke_length(self, kind: Kind) -> float:
        """Distance between the reversal points of a block of that kind, mm."""
        return kind.length + 2.0 * self.setup.overrun

    def strokes(self, kind: Kind, stock: float) -> int:
        """Strokes of a block of that kind and `stock` (mm): one to the primary point, the plunges and the spark-out."""
        plunges = picks_to(stock, kind.pick)
        if self.cross_pick > 0.0:
            # after the stroke to the primary point a traverse for each plunge and each spark-out
            across = picks_to(kind.width - self.wheel.width, self.cross_pick)
            return 1 + (plunges + kind.sparkout) * (across + 1)
        return plunges + 1 + kind.sparkout

    def nominal_seconds(self, kind: Kind, speed: float) -> float:
        """Time of a block of nominal stock at E `speed` (m/min) without a dress, s; a first one with its loading."""
        vw = 1000.0 * speed / 60.0
        stroke = motion_time(self.stroke_length(kind), vw, self.machine.acceleration) + self.machine.reversal_dwell
        return self.strokes(kind, kind.stock) * stroke + (self.setup.load if kind.starts_part else 0.0)


def _changed(entry: EntryT, changes: Mapping[str, Any], place: str) -> EntryT:
    """A catalogue entry with the changes of a task."""
    refuse_unknown(changes, quantities(type(entry)), place)
    return replace(entry, **changes)
