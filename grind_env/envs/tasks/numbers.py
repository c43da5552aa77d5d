"""What follows from the tables of a task: the numbers of the process model, and the blocks of an episode."""

import itertools
import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from grind_env.control.rules import motion_time, picks_to
from grind_env.envs.tasks.tables import ActionRange, Dress, Due, Kind, Orders, Spread, Start, TaskError, TaskSetup
from grind_env.errors import did_you_mean, listed, quoted, shortened
from grind_env.process.catalogue import Catalogue
from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import Dresser, Fluid, Machine, Wheel
from grind_env.process.parameters import limits_of, rates_of, stroke_parameters
from grind_env.process.state import StrokeParameters
from grind_env.process.user_catalogue import entry_of

DRESS_CLEARANCE = 10.0
"""mm that a dress traverse runs beyond the wheel width, both sides together."""


class TaskNumbers:
    """Worked out of the fields of `Task`, of which it reads these."""

    name: str
    blocks: int
    action: ActionRange
    setup: TaskSetup
    dress: Dress
    kinds: tuple[Kind, ...]
    sequence: tuple[str, ...]
    orders: Orders | None
    due: Due | None
    infeed: float
    cross_pick: float
    spread: Spread
    start: Start
    factors: Mapping[str, float]
    catalogue: Catalogue

    @property
    def cycle(self) -> str:
        """The cycle of its blocks."""
        return "G81" if self.infeed > 0.0 else "G83" if self.cross_pick > 0.0 else "G82"

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
        for name in sequence:
            if name not in names:
                legal = listed(names)
                message = f"{place}: there is no kind {quoted(name)}{did_you_mean(name, names)}; legal are {legal}"
                raise TaskError(message, place, name, legal)
        numbers = [names.index(name) for _, name in zip(range(self.blocks), itertools.cycle(sequence), strict=False)]
        kinds = [self.kinds[number] for number in numbers]
        whole = all(a.ends_part == b.starts_part for a, b in itertools.pairwise(kinds))
        if not (kinds and whole and kinds[0].starts_part and kinds[-1].ends_part):
            shown = shortened(", ".join(sequence))
            raise TaskError(f"{place}: {shown} does not make {self.blocks} blocks of whole parts", place, sequence)
        return tuple(numbers)

    @property
    def parts(self) -> int:
        """Parts of an episode of the nominal sequence."""
        return sum(self.kinds[number].ends_part for number in self.numbers(self.nominal_sequence, "sequence"))

    def kind_of_block(self, block: int) -> int:
        """Index into `kinds` of a block of the nominal sequence, which repeats; episodes of orders have others."""
        sequence = self.nominal_sequence
        return [kind.name for kind in self.kinds].index(sequence[block % len(sequence)])

    @cached_property
    def wheel(self) -> Wheel:
        """The wheel, with what this task overrides."""
        wheel: Wheel = self._entry("wheel", self.setup.wheel, self.setup.wheel_overrides)
        return wheel

    @cached_property
    def dresser(self) -> Dresser:
        """The dresser, likewise."""
        dresser: Dresser = self._entry("dresser", self.setup.dresser, self.setup.dresser_overrides)
        return dresser

    @cached_property
    def fluid(self) -> Fluid:
        """The coolant, likewise."""
        fluid: Fluid = self._entry("fluid", self.setup.fluid, self.setup.fluid_overrides)
        return fluid

    @cached_property
    def machine(self) -> Machine:
        """The machine, likewise."""
        machine: Machine = self._entry("machine", self.setup.machine, self.setup.machine_overrides)
        return machine

    def _entry(self, kind: str, name: str, overrides: Mapping[str, float]) -> Any:
        return entry_of(self.catalogue, f"setup.{kind}", name, {f"{kind}_overrides": overrides}, TaskError)

    @cached_property
    def rates(self) -> Rates:
        """Prices of time, wheel and dresser."""
        return rates_of(self.wheel, self.dresser, self.machine)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Names of all materials of its catalogue, in alphabetical order; numbers of materials count in it."""
        return tuple(sorted(self.catalogue.materials))

    def parameters(self, kind: Kind) -> StrokeParameters:
        """Stroke parameters of a block kind, with the fixed factors of this task."""
        part = kind.material, kind.width, kind.height
        if part not in self._parameters:
            self._parameters[part] = self._parameters_of(*part)
        return self._parameters[part]

    @cached_property
    def _parameters(self) -> dict[tuple[str, float, float], StrokeParameters]:
        """Those that have been asked for, by material, width and height."""
        return {}

    def _parameters_of(self, material: str, width: float, height: float) -> StrokeParameters:
        p = stroke_parameters(
            self.catalogue.materials[material],
            self.wheel,
            self.dresser,
            self.fluid,
            self.machine,
            wheel_speed=self.setup.wheel_speed,
            width=width,
            height=height,
        )
        return p._replace(**{name: getattr(p, name) * factor for name, factor in self.factors.items()})

    def limits(self, kind: Kind) -> Limits:
        """Limits of a good part of that kind."""
        return limits_of(
            self.catalogue.materials[kind.material],
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

    def stroke_seconds(self, kind: Kind, speed: float) -> float:
        """Time of a stroke of a block of that kind at E `speed` (m/min) with its reversal dwell, s."""
        vw = 1000.0 * speed / 60.0
        return motion_time(self.stroke_length(kind), vw, self.machine.acceleration) + self.machine.reversal_dwell

    def nominal_seconds(self, kind: Kind, speed: float) -> float:
        """Time of a block of nominal stock at E `speed` (m/min) without a dress, with what comes before it, s."""
        stroke, wait = self.stroke_seconds(kind, speed), self.wait_seconds(kind)
        if self.infeed > 0.0:
            return 60.0 * kind.stock / self.infeed + (2 + kind.sparkout) * stroke + wait
        return self.strokes(kind, kind.stock) * stroke + wait

    def wait_seconds(self, kind: Kind) -> float:
        """Time before a block of that kind in which its part is loaded or gauged, s."""
        return self.setup.load if kind.starts_part else self.setup.gauge
