"""A task: the tables of its file joined and checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

from grind_env.envs.names import ANY_TASK, environment_id
from grind_env.envs.tasks.checks import check_plant, check_whole
from grind_env.envs.tasks.numbers import TaskNumbers
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
from grind_env.presenter import html, presenter
from grind_env.process.catalogue import Catalogue, entry_name, load_catalogue
from grind_env.process.entries import Quantity
from grind_env.process.tables import check


@dataclass(frozen=True, kw_only=True)  # no slots: what follows from its tables is worked out once
class Task(TaskNumbers):
    """A job: its blocks, its set-up and what is drawn at random.

    Attributes:
        name: of its file.
        title: the job in a few words.
        blocks: cycle blocks of an episode.
        reference_cost: cost of a block that a reward of -1 stands for; 0 for that of the cheapest of some fixed plans,
            which the simulation of the task finds out.
        action: what an action can choose.
        setup: wheel, dresser, fluid and machine.
        dress: the dress program.
        kinds: of cycle block.
        sequence: names of the kinds in their order, repeated; empty for a task of orders.
        orders: random orders in place of a sequence.
        due: due dates.
        wheel_change: what a new wheel costs.
        observation: what is shown unless asked for otherwise: what a machine measures, or the hidden state, too.
        infeed: of a wheel that the program feeds down while the table reciprocates (G81); 0 for the picks of a cycle.
        cross_pick: of a G83, for parts wider than the wheel; 0 for cycles without.
        spread: what an episode draws.
        start: state of the wheel at the start.
        factors: on parameters of the process model, by their symbols.
        plant: the machine that grinds, as `"meter:7"`, or those that every episode draws one from, as `"meter"`, where
            it is not the model (`grind_env.plants`).
        catalogue: the entries that the names of the set-up and of the materials stand for.
        file: the user's file that it was read from; empty for a task of the package.

    Raises:
        TaskError: a value is out of its range, a name unknown, the blocks do not make whole parts, or the due dates
            whole episodes.
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
        check_whole(self)
        check_plant(self.plant)

    @property
    def environment_id(self) -> str:
        """The Gymnasium id that makes it: its own, or for a user's file the one of all such tasks."""
        return ANY_TASK if self.file else environment_id(self.name)

    def page(self) -> str:
        """Its page, Markdown, as `grind tasks` prints it; of a user's file all that it says, defaults included."""
        text: str = presenter("tasks").page(self)
        return text

    def _repr_html_(self) -> str:
        return html("tasks", self)
