"""A task: all tables of its file, derived values, and consistency checks."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, Literal

from grind_env.control.cycle_formulas import motion_time, picks_to
from grind_env.envs.plant_options import plants_of
from grind_env.envs.task_names import ANY_TASK, environment_id
from grind_env.envs.tasks.tables import (
    ActionRange,
    Dress,
    Due,
    Kind,
    Orders,
    ReadOnly,
    Spread,
    Start,
    TaskError,
    TaskSetup,
    WheelChange,
    whole_micrometres,
)
from grind_env.errors import GrindError
from grind_env.machine.dress.wheel_geometry import half_chord
from grind_env.message_text import did_you_mean, listed, quoted, shortened
from grind_env.notebook_loader import html, presenter
from grind_env.process.catalogue import Catalogue, entry_name, load_catalogue
from grind_env.process.catalogue_parameters import limits_of, rates_of, stroke_parameters
from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import Dresser, Fluid, Machine, Quantity, Wheel
from grind_env.process.force_correction import exponents_of
from grind_env.process.stroke_types import StrokeParameters
from grind_env.process.toml_tables import check, refuse_unknown, wrong
from grind_env.process.user_catalogue import entry_of

DRESS_CLEARANCE = 10.0  #: travel of a dress traverse beyond the wheel width, both sides together, mm
PICK_FEED, CROSS_FEED = 60.0, 1500.0  #: feed of the picks of a G82, and of all picks of a G83, mm/min

#: most strokes of a block, and of a traverse; more strokes mean a mistake in a pick or an infeed
MOST_STROKES, MOST_ACROSS = 100_000, 200


@dataclass(frozen=True, kw_only=True)  # no slots, because derived values are cached
class Task:
    """A task: its blocks, its set-up and its random draws.

    Attributes:
        name: name of its file.
        title: short description.
        blocks: cycle blocks of an episode.
        reference_cost: cost of a block with a reward of -1; 0 to compute it from the cheapest of several fixed plans.
        action: ranges of the actions.
        setup: wheel, dresser, fluid and machine.
        dress: the dress program.
        kinds: kinds of cycle blocks.
        sequence: names of the kinds in their order, repeated; empty for a task of orders.
        orders: random orders in place of a sequence.
        due: due dates.
        wheel_change: cost of a new wheel.
        observation: default observation: the measurements, or also the hidden state.
        infeed: continuous infeed of the wheel in a G81; 0 for cycles with picks.
        cross_pick: cross pick of a G83, for parts wider than the wheel; 0 for other cycles.
        spread: random draws of an episode.
        start: state of the wheel at the start.
        factors: factors on parameters of the process model, by symbol.
        plant: the machine, such as `"meter:7"`, or the family to draw one from in each episode, such as `"meter"`
            (`grind_env.plants`); empty for the model.
        catalogue: catalogue entries of the set-up and the materials.
        file: user's file of the task; empty for a task of the package.

    Raises:
        TaskError: a value is out of its range, a name is unknown, the blocks do not make whole parts, or the due dates
            do not divide the episode evenly.
    """

    name: str
    title: str
    blocks: Annotated[int, Quantity("", "", 1, 10_000)]
    reference_cost: Annotated[float, Quantity("", "$", 0, 1e9)] = 0.0
    action: ActionRange = field(default_factory=ActionRange)
    setup: TaskSetup = field(default_factory=TaskSetup)
    dress: Dress = field(default_factory=Dress)
    kinds: tuple[Kind, ...]
    sequence: tuple[str, ...] = ()
    orders: Orders | None = None
    due: Due | None = None
    wheel_change: WheelChange | None = None
    observation: Literal["measured", "full"] = "measured"
    infeed: Annotated[float, Quantity("F", "mm/min", 0, 1000)] = 0.0
    cross_pick: Annotated[float, Quantity("K", "mm", 0, 300)] = 0.0
    spread: Spread = field(default_factory=Spread)
    start: Start = field(default_factory=Start)
    factors: Annotated[Mapping[str, float], Quantity("", "", 0.01, 100)] = field(default_factory=ReadOnly)
    plant: str = ""
    catalogue: Catalogue = field(default_factory=load_catalogue, repr=False)
    file: str = ""

    def __post_init__(self) -> None:
        check(self, "", TaskError)
        known = self.catalogue.materials
        kinds = tuple(replace(kind, material=entry_name(kind.material, known)) for kind in self.kinds)
        object.__setattr__(self, "kinds", kinds)
        whole_micrometres(self, "", "cross_pick", "infeed")
        _check_whole(self)
        try:
            plants_of(None, self.plant)
        except GrindError as error:
            raise TaskError(f"plant: {error}", "plant", self.plant) from None

    @property
    def environment_id(self) -> str:
        """Return the Gymnasium id of the task; all task files of users share one id."""
        return ANY_TASK if self.file else environment_id(self.name)

    def page(self) -> str:
        """Return the Markdown page of the task, as `grind tasks` prints it; for a user's file with all defaults."""
        text: str = presenter("tasks").page(self)
        return text

    def _repr_html_(self) -> str:
        return html("tasks", self)

    @property
    def cycle(self) -> str:
        """Return the grinding cycle of the blocks."""
        return "G81" if self.infeed > 0.0 else "G83" if self.cross_pick > 0.0 else "G82"

    @property
    def nominal_sequence(self) -> tuple[str, ...]:
        """Return the names of the kinds, to be repeated; with orders, one order of mean size of each kind."""
        if self.orders is None:
            return self.sequence
        parts = (1 + self.orders.most_parts) // 2
        return tuple(kind.name for kind in self.kinds for _ in range(parts))

    def numbers(self, sequence: tuple[str, ...], place: str) -> tuple[int, ...]:
        """Return the index into `kinds` of each block of an episode that repeats `sequence`.

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
        """Return the number of parts of an episode of the nominal sequence."""
        return sum(self.kinds[number].ends_part for number in self.numbers(self.nominal_sequence, "sequence"))

    def kind_of_block(self, block: int) -> int:
        """Return the index into `kinds` of a block of the nominal sequence; episodes with orders differ from it."""
        sequence = self.nominal_sequence
        return [kind.name for kind in self.kinds].index(sequence[block % len(sequence)])

    @cached_property
    def wheel(self) -> Wheel:
        """Return the wheel with the overrides of this task."""
        wheel: Wheel = self._entry("wheel", self.setup.wheel, self.setup.wheel_overrides)
        return wheel

    @cached_property
    def dresser(self) -> Dresser:
        """Return the dresser with the overrides of this task."""
        dresser: Dresser = self._entry("dresser", self.setup.dresser, self.setup.dresser_overrides)
        return dresser

    @cached_property
    def fluid(self) -> Fluid:
        """Return the coolant with the overrides of this task."""
        fluid: Fluid = self._entry("fluid", self.setup.fluid, self.setup.fluid_overrides)
        return fluid

    @cached_property
    def machine(self) -> Machine:
        """Return the machine with the overrides of this task."""
        machine: Machine = self._entry("machine", self.setup.machine, self.setup.machine_overrides)
        return machine

    def _entry(self, kind: str, name: str, overrides: Mapping[str, float]) -> Any:
        return entry_of(self.catalogue, f"setup.{kind}", name, {f"{kind}_overrides": overrides}, TaskError)

    @cached_property
    def rates(self) -> Rates:
        """Return the prices of time, wheel and dresser."""
        return rates_of(self.wheel, self.dresser, self.machine)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Return the names of all materials of the catalogue in alphabetical order, the order of material indices."""
        return tuple(sorted(self.catalogue.materials))

    def parameters(self, kind: Kind) -> StrokeParameters:
        """Return the stroke parameters of a block kind, with the fixed factors of this task."""
        part = kind.material, kind.width, kind.height
        if part not in self._parameters:
            p = stroke_parameters(
                self.catalogue.materials[kind.material],
                self.wheel,
                self.dresser,
                self.fluid,
                self.machine,
                wheel_speed=self.setup.wheel_speed,
                width=kind.width,
                height=kind.height,
            )
            factors = {name: getattr(p, name) * factor for name, factor in self.factors.items()}
            self._parameters[part] = p._replace(**factors)
        return self._parameters[part]

    @cached_property
    def _parameters(self) -> dict[tuple[str, float, float], StrokeParameters]:
        """Return the parameters computed so far, by material, width and height."""
        return {}

    def limits(self, kind: Kind) -> Limits:
        """Return the limits of a good part of a kind."""
        return limits_of(
            self.catalogue.materials[kind.material],
            self.machine,
            rise_allowance=kind.rise_allowance,
            roughness_limit=kind.roughness_limit,
            tolerance=kind.tolerance,
        )

    @property
    def wheel_revolutions(self) -> float:
        """Return the wheel speed, 1/s."""
        return 1000.0 * self.setup.wheel_speed / (math.pi * self.wheel.diameter)

    @property
    def dress_feed(self) -> float:
        """Return the traverse feed of the diamond, mm/s; in mm/min it has three decimals, as the control reads it."""
        return round(60.0 * self.dress.lead * self.wheel_revolutions, 3) / 60.0

    @property
    def dress_lead(self) -> float:
        """Return the lead at `dress_feed`, mm per wheel revolution."""
        return self.dress_feed / self.wheel_revolutions

    @property
    def dress_seconds(self) -> float:
        """Return the time of one dress execution, s."""
        return self.dress.setup + self.dress.passes * (self.wheel.width + DRESS_CLEARANCE) / self.dress_feed

    @property
    def execution_depth(self) -> float:
        """Return the depth that one dress execution removes from the wheel diameter, mm."""
        return 2.0 * self.dress.passes * self.dress.depth

    def stroke_length(self, kind: Kind) -> float:
        """Return the distance between the reversal points of a block of that kind, mm."""
        return kind.length + 2.0 * self.setup.overrun

    def strokes(self, kind: Kind, stock: float) -> int:
        """Return the number of strokes of a block with `stock` (mm): one to the primary point, plunges, spark-out."""
        plunges = picks_to(stock, kind.pick)
        if self.cross_pick > 0.0:
            # after the stroke to the primary point a traverse for each plunge and each spark-out
            across = picks_to(kind.width - self.wheel.width, self.cross_pick)
            return 1 + (plunges + kind.sparkout) * (across + 1)
        return plunges + 1 + kind.sparkout

    def stroke_seconds(self, kind: Kind, speed: float) -> float:
        """Return the time of a stroke of a block of that kind at E `speed` (mm/min) with its reversal dwell, s."""
        return (
            motion_time(self.stroke_length(kind), speed / 60.0, self.machine.acceleration) + self.machine.reversal_dwell
        )

    def nominal_seconds(self, kind: Kind, speed: float) -> float:
        """Return the time of a nominal block at E `speed` (mm/min), with loading or gauging, without a dress, s."""
        stroke, wait = self.stroke_seconds(kind, speed), self.wait_seconds(kind)
        if self.infeed > 0.0:
            return 60.0 * kind.stock / self.infeed + (2 + kind.sparkout) * stroke + wait
        return self.strokes(kind, kind.stock) * stroke + wait

    def wait_seconds(self, kind: Kind) -> float:
        """Return the time before a block of that kind in which its part is loaded or gauged, s."""
        return self.setup.load if kind.starts_part else self.setup.gauge


def _check_whole(task: Task) -> None:
    """Check rules that depend on several tables, or on the catalogue."""
    if not task.kinds:
        raise TaskError("kind is missing: give at least one block, headed [[kind]]", "kind")
    names = [kind.name for kind in task.kinds]
    for name in names:
        if names.count(name) > 1:
            raise TaskError(f"kind.name is {quoted(name)} twice: give every kind a name of its own", "kind.name", name)
    if bool(task.sequence) == (task.orders is not None):
        raise TaskError("the blocks need either sequence or [orders]: give exactly one of the two", "sequence")
    if task.orders is not None:
        _refuse_pieces(task, "[orders]")
    if task.due is not None and task.blocks % task.due.blocks:
        message = f"due.blocks is {task.due.blocks}, but must divide the {task.blocks} blocks evenly"
        raise TaskError(message, "due.blocks", task.due.blocks)
    task.numbers(task.nominal_sequence, "sequence")
    refuse_unknown(task.factors, StrokeParameters._fields, TaskError, "factors.")
    for kind in task.kinds:
        material = entry_of(task.catalogue, "kind.material", kind.material, {}, TaskError)
        if any(exponents_of(material)):
            raise TaskError(
                f"kind.material: {material} has exponents of the power, by which only jobs grind: use it in a job "
                "(grind/Job-v0), or set them to 0",
                "kind.material",
                kind.material,
            )
        _check_wheel_covers(task, kind)
    if task.infeed > 0.0:
        _refuse_pieces(task, "infeed")
        _check_infeeds(task)
    if task.cross_pick > 0.0:
        _check_crossing(task)
    for kind in task.kinds:
        _check_strokes(task, kind)
        if task.cycle == "G82":
            _check_clear(task, kind)
    _check_start(task)


def _refuse_pieces(task: Task, place: str) -> None:
    """Refuse kinds that are no whole parts."""
    for kind in task.kinds:
        if not (kind.starts_part and kind.ends_part):
            raise TaskError(f"{place}: a {kind.name} is no whole part: let it start and end one", "kind.ends_part")


def _check_wheel_covers(task: Task, kind: Kind) -> None:
    wheel = task.wheel.width
    sizes = f"a {kind.name} of {shortened(task.name)} is {kind.width:g} mm wide, the wheel {wheel:g} mm"
    if task.cycle != "G83" and kind.width > wheel:
        message = f"{sizes}: a {task.cycle} grinds only one strip of it; give a cross_pick for a G83, or a wider wheel"
        raise TaskError(message, "kind.width", kind.width)
    if task.cycle == "G83" and kind.width <= wheel:
        message = f"{sizes}: a G83 has no strip to cross to; leave out cross_pick for a G82"
        raise TaskError(message, "kind.width", kind.width)


def _check_strokes(task: Task, kind: Kind) -> None:
    """Refuse more than `MOST_STROKES` strokes, and picks that take longer than half a stroke."""
    fastest = task.stroke_seconds(kind, task.action.speed_ends[1])
    strokes = 60.0 * kind.stock / task.infeed / fastest if task.infeed > 0.0 else task.strokes(kind, kind.stock)
    if strokes > MOST_STROKES:
        key, value = ("infeed", task.infeed) if task.infeed > 0.0 else ("kind.pick", kind.pick)
        raise TaskError(
            f"{key} is {value:g}, so that a {kind.name} takes {strokes:.0f} strokes, but {MOST_STROKES} are the "
            "most: take more, or less stock",
            key,
            value,
        )
    picks = {} if task.infeed > 0.0 else {"kind.pick": kind.pick, "cross_pick": task.cross_pick}
    feed = CROSS_FEED if task.cycle == "G83" else PICK_FEED
    for key, pick in picks.items():
        if motion_time(pick, feed / 60.0, task.machine.acceleration) > 0.5 * fastest:
            raise TaskError(
                f"{key} is {pick:g} mm, which at {feed:g} mm/min takes longer than half a stroke of a {kind.name} "
                f"at {task.action.speed_ends[1]:g} mm/min, {0.5 * fastest:.3g} s: take less",
                key,
                pick,
            )


def _check_clear(task: Task, kind: Kind) -> None:
    """Refuse an overrun so short that the wheel would grind the part before the G82, which begins at the first pick."""
    diameter, overrun = task.wheel.diameter, task.setup.overrun
    # the first pick is at most as deep as the stock, which has no upper limit in a task with a spread
    first = kind.pick if task.spread.stock > 0.0 else min(kind.pick, kind.stock)
    least = math.ceil(1000.0 * half_chord(0.5 * diameter, first)) / 1000.0
    if overrun < least:
        way = (
            f"the {diameter:g} mm wheel grinds the part as it comes down beside it, {first:g} mm deep in its first pick"
        )
        legal = f"at least {least:.3f} mm, or {way}"
        raise wrong("setup.overrun", overrun, legal, TaskError)


def _check_infeeds(task: Task) -> None:
    """Refuse so many dresses that an infeed between two of them would be less than 0.001 mm."""
    for kind in task.kinds:
        least = kind.stock * (kind.least_stock if task.spread.stock > 0.0 else 1.0)
        if least < 0.001 * (task.action.executions + 1):
            raise TaskError(
                f"action.executions is {task.action.executions}, but a {kind.name} may have only {least:g} mm "
                "of stock, which a G81 parts in steps of 0.001 mm between them: allow fewer dresses, or more stock",
                "action.executions",
                task.action.executions,
            )


def _check_crossing(task: Task) -> None:
    if task.infeed > 0.0:
        raise TaskError("the task has both infeed (G81) and cross_pick (G83): give one of the two", "cross_pick")
    if len(task.kinds) > 1:
        raise TaskError(
            f"{shortened(task.name)} has several kinds of blocks; a G83 task has one, which is a whole part", "kind"
        )
    across = picks_to(task.kinds[0].width - task.wheel.width, task.cross_pick)
    if task.cross_pick > task.wheel.width or across > MOST_ACROSS:
        least = (task.kinds[0].width - task.wheel.width) / MOST_ACROSS
        legal = f"from {least:.3g} mm ({MOST_ACROSS} strokes) to the width of the wheel, {task.wheel.width:g} mm"
        raise wrong("cross_pick", task.cross_pick, legal, TaskError)


def _check_start(task: Task) -> None:
    area, left = task.start.wear_flat_area, task.start.executions_left
    if area is not None and area >= task.wheel.wear_flat_limit:
        raise wrong("start.wear_flat_area", area, f"below {task.wheel.wear_flat_limit:g} for {task.wheel}", TaskError)
    most = (task.wheel.diameter - task.wheel.minimum_diameter) / task.execution_depth
    if left is not None and left[1] > most:
        raise wrong(
            "start.executions_left", left, f"at most {math.floor(most)}, which a new {task.wheel} has", TaskError
        )
