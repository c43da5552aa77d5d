"""The task itself: N episodes side by side, without Gymnasium.

What policies, planners, beliefs, evaluations and trainings need of an environment is here: what a step is, what can be
chosen, how its readings are read, what of the truth may be shown, and branches on which a choice is tried.
Every environment that chooses E and D has one, as `env.unwrapped.simulation`.

One compiled call steps all of them: cycle parameters from (E, D), the block kernel, cost, and the readings of
the next observation. The single environment runs it with N = 1, the vector environment and the planners with
many.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.blocks.episode import EpisodeGenerator
from grind_env.envs.blocks.observe import observe_blocks
from grind_env.envs.blocks.step import NEW_PART, step_blocks
from grind_env.envs.blocks.tables import KindRow, Outcome, Shop, ShopMemory, kind_table, parameter_table, shop_row
from grind_env.envs.blocks.tape import TapeRow
from grind_env.envs.contexts import Given
from grind_env.envs.observations import Reading, constant_readings, physical, readings, scaling
from grind_env.envs.tasks import Task
from grind_env.machine.batch import CYCLE_FIELDS
from grind_env.machine.cycle import PartState
from grind_env.machine.tally import Tally
from grind_env.process.cost import running_cost
from grind_env.process.equations import dressed_volume
from grind_env.process.state import WheelState

Table = NDArray[np.float64]
Numbers = NDArray[np.int64]
EpisodesT = TypeVar("EpisodesT", bound="Episodes")

STOCK, TAPE_STOCK = KindRow._fields.index("stock"), TapeRow._fields.index("stock")
KIND, MATERIAL = TapeRow._fields.index("kind"), TapeRow._fields.index("material")
BOOKED, DIAMETER = ShopMemory._fields.index("diameter"), WheelState._fields.index("ds")
NOISE = [TapeRow._fields.index(name) for name in TapeRow._fields if name.endswith("_noise")]


@dataclass(slots=True)
class Episodes:
    """The state of N episodes: arrays with one row an episode.

    `tape` has shape (N, blocks, fields of `TapeRow`), and `wheels`, `parts` and `memory` (N, fields of `WheelState`,
    `PartState` or `ShopMemory`), all in the units of these fields. `block` is the index of the coming block,
    shape (N,).
    """

    tape: Table
    block: NDArray[np.int64]
    wheels: Table
    parts: Table
    memory: Table

    def arrays(self) -> dict[str, Any]:
        """All of them by name, in the order in which the compiled step takes them."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def pick(self: EpisodesT, index: ArrayLike) -> EpisodesT:
        """Copies of the episodes at `index`, shape (M,), which may repeat: what-if branches for a planner."""
        return type(self)(**{name: array[np.asarray(index)] for name, array in self.arrays().items()})


class Generator(Protocol):
    """Draws episodes."""

    def begin(
        self,
        tape: Table,
        wheels: Table,
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """Write tape and first wheel of the episodes at `index`, shape (M,), one from each generator.

        Args:
            tape: shape (N, blocks, fields of `TapeRow`).
            wheels: shape (N, fields of `WheelState`).
            index: of those that begin.
            rngs: M generators.
            given: what is given of each.
        """


class Simulation:
    """Steps episodes of one task.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        pre_dress: whether observations show if the last block began with a dress.

    Attributes:
        task: names and limits; a simulation of a program has one that says the same of it.
        entries: of the observation, the measured ones first.
        kinds: numbers of the kinds of blocks, shape (rows, fields of `KindRow`).
        usual: readings that the environment does not show because they never change, by name.
    """

    by_block: ClassVar[bool] = True
    """Whether a step is a block, and not a stroke."""

    def __init__(self, task: Task, *, full: bool = False, pre_dress: bool = False) -> None:
        self.task = task
        self.entries = self._readings(task, full=full, pre_dress=pre_dress)
        self.kinds, self.base, self.shop = kind_table(task), parameter_table(task), shop_row(task)
        self.usual: Mapping[str, float] = constant_readings(task, pre_dress=pre_dress)
        self._materials = len(task.materials)
        self._scaling = scaling(task, self.entries)
        self._begin_with(EpisodeGenerator(task))

    def _begin_with(self, generator: Generator) -> None:
        """Let episodes begin as a generator draws them, with nothing done yet."""
        # kept from step to step: of tens of MB the system would have to find every page anew
        self._cycles, self._parameters = np.empty((0, CYCLE_FIELDS)), np.empty((0, self.base.shape[1]))
        self.change_shop(self.shop)
        self._generator = generator
        self._first_part = np.array(NEW_PART)
        nothing = ShopMemory(*[0.0] * len(ShopMemory._fields))
        self._first_memory = np.array(nothing._replace(gauged=-1.0, volume=self.task.start.volume, survival=1.0))

    def change_shop(self, shop: Shop) -> None:
        """Go on with other numbers of the shop."""
        self.shop, self._shops = shop, np.array([shop])

    def start(self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None) -> Episodes:
        """New episodes, one from each generator, with what is given of each."""
        n = len(rngs)
        episodes = self.room(n)
        self.restart_all(episodes, range(n), rngs, [Given()] * n if given is None else given)
        return episodes

    def room(self, n: int) -> Episodes:
        """Arrays for N episodes."""
        return Episodes(
            np.empty((n, self.task.blocks, len(TapeRow._fields))),
            np.zeros(n, np.int64),
            np.empty((n, len(WheelState._fields))),
            np.empty((n, len(PartState._fields))),
            np.empty((n, len(ShopMemory._fields))),
        )

    def restart(self, episodes: Episodes, i: int, rng: np.random.Generator, given: Given | None = None) -> None:
        """Put a new episode in place of episode i."""
        self.restart_all(episodes, [i], [rng], [Given() if given is None else given])

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """Put new episodes in place of those at `index`, one from each generator, with what is given of each."""
        rows = np.array(index)
        self._generator.begin(episodes.tape, episodes.wheels, rows, rngs, given)
        self.clear(episodes, rows)

    def clear(self, episodes: Episodes, index: Numbers) -> None:
        """Forget what the episodes at `index`, shape (M,), have done but for their wheels: none has begun."""
        episodes.block[index] = 0
        episodes.parts[index] = self._first_part
        episodes.memory[index] = self._first_memory
        episodes.memory[index, BOOKED] = episodes.wheels[index, DIAMETER]

    def load(self, episodes: Episodes, index: Numbers, rows: Numbers, stocks: Table) -> None:
        """Give episodes of one block, at `index`, one of a row in `kinds`, with its stock over the nominal one.

        All three are of shape (M,).
        """
        nominal = self.kinds[rows, STOCK]
        episodes.block[index] = 0
        episodes.tape[index, 0, KIND] = rows // self._materials
        episodes.tape[index, 0, MATERIAL] = rows % self._materials
        episodes.tape[index, 0, TAPE_STOCK] = np.round(1000.0 * stocks * nominal) / 1000.0

    def first_wheels(self, count: int) -> Table:
        """Wheels with which an episode may begin, evenly over what is drawn, shape (count, fields of `WheelState`)."""
        generator = EpisodeGenerator(self.task)
        flats = self.task.spread.diamond_flat * (np.arange(count) + 0.5) / count
        return np.array([generator.wheel(float(flat)) for flat in flats])

    @property
    def dress_price(self) -> float:
        """Price of a dress execution, $."""
        task = self.task
        volume = dressed_volume(task.dress.passes, task.dress.depth, task.wheel.diameter, task.wheel.width)
        price: float = running_cost(task.dress_seconds, volume, 1.0, task.rates)
        return price

    @property
    def usual_dress(self) -> tuple[float, float]:
        """Traverse feed of the diamond, mm/s, and depth of a pass, mm."""
        return self.task.dress_feed, self.task.dress.depth

    def taken(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        """What the coming blocks make of a choice, each of shape (N,)."""
        return choice

    def step(
        self,
        episodes: Episodes,
        speeds: Table,
        executions: Table,
        pre_dresses: Table | None = None,
        *,
        active: NDArray[np.int64] | None = None,
    ) -> tuple[Table, Table]:
        """Grind the next block of the episodes in `active` (indices; all by default).

        Args:
            episodes: changed in place.
            speeds: E in mm/min, shape (N,).
            executions: D, shape (N,).
            pre_dresses: 1 for a dress before the first plunge, else 0, shape (N,); none by default.
            active: indices of the episodes to step; they must not be over.

        Returns:
            Outcomes, shape (N, fields of `Outcome`), and results of the cycles, shape (N, fields of
            `Tally`); rows of the others are 0.
        """
        n = len(episodes.block)
        active = np.arange(n) if active is None else active
        outcomes = np.zeros((n, len(Outcome._fields)))
        results = np.zeros((n, len(Tally._fields)))
        if len(self._cycles) < n:
            self._cycles, self._parameters = np.empty((n, CYCLE_FIELDS)), np.empty((n, self.base.shape[1]))
        self._grind(
            (self.kinds, self.base, self._shops, self._cycles[:n], self._parameters[:n]),
            tuple(episodes.arrays().values()),
            (speeds, executions, np.zeros(n) if pre_dresses is None else pre_dresses),
            active,
            results,
            outcomes,
        )
        return outcomes, results

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Observations of the coming blocks, shape (N, entries), float32.

        After the last block of an episode the coming block reads as zeros.
        """
        observations = np.zeros((len(episodes.block), len(self._scaling.offset)), np.float32)
        observe_blocks(
            self.kinds,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            episodes.memory,
            self._shops,
            *self._scaling,
            observations,
        )
        return observations

    def read(self, observation: NDArray[np.float32]) -> dict[str, Table]:
        """What observations say in physical units, by name, each shape (N,); see `usual`."""
        constant = {name: np.full(len(observation), value) for name, value in self.usual.items()}
        return constant | physical(observation, self.entries[: observation.shape[1]])

    def coming_kinds(self, seen: Mapping[str, Table]) -> Numbers:
        """Number of the kind of the coming block, from what was read; shape (N,)."""
        if len(self.task.kinds) == 1:
            return np.zeros(len(seen["remaining"]), np.int64)
        return np.asarray(np.argmax([seen[f"coming_{kind.name}"] for kind in self.task.kinds], axis=0))

    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        """Row in `kinds` of the coming block, from what was read; shape (N,)."""
        names = self.task.materials
        kind = self.coming_kinds(seen)
        material = np.array([names.index(each.material) for each in self.task.kinds])[kind]
        for number, name in enumerate(names):
            material = np.where(seen.get(f"material_{name}", np.zeros(len(kind))) > 0.5, number, material)
        return np.asarray(kind * len(names) + material)

    def nominal_parameters(self) -> Table:
        """Nominal stroke parameters of each kind, shape (kinds, fields of `StrokeParameters`)."""
        return np.array([self.task.parameters(kind) for kind in self.task.kinds])

    def rows_of(self, tape: Table) -> Numbers:
        """Row in `kinds` of the blocks on a tape, shape (..., fields of `TapeRow`)."""
        return np.asarray(tape[..., KIND] * self._materials + tape[..., MATERIAL]).astype(np.int64)

    def coming_blocks(self, episodes: Episodes) -> Table:
        """The rows of the coming blocks, or of the last ones, on the tapes; shape (N, fields of `TapeRow`)."""
        at = np.minimum(episodes.block, episodes.tape.shape[1] - 1)
        return np.asarray(episodes.tape[np.arange(len(at)), at])

    def kind_of_row(self, row: Numbers) -> Numbers:
        """Number of the kind that a row in `kinds` is of, of any shape."""
        return row // self._materials

    def without_noise(self, episodes: EpisodesT) -> EpisodesT:
        """The episodes, changed in place, without the noise of the gauges to come: a machine cannot know it."""
        episodes.tape[..., NOISE] = 0.0
        return episodes

    def window(self, episodes: EpisodesT, tape: Table, owner: Numbers, first: int, blocks: int) -> EpisodesT:
        """Branches at block `first` with a tape of some blocks only, after which they end: whole ones are long to copy.

        After the last block of a tape the wheel left behind is charged for.

        Args:
            episodes: the branches, shape (B, ...).
            tape: of the episodes that they belong to, shape (N, blocks, fields of `TapeRow`).
            owner: which of these, shape (B,).
            first: the coming block of all of them.
            blocks: length of the tape.
        """
        return replace(episodes, tape=tape[owner, first : first + blocks], block=np.zeros_like(episodes.block))

    def lengthened(self, episodes: EpisodesT, blocks: range) -> EpisodesT:
        """Episodes of one block with the further ones of the nominal sequence, as the number of each block has it."""
        task = self.task
        # the wheel left behind is charged after the last block of a tape
        length = len(blocks) + (blocks[-1] + 1 < task.blocks)
        tape = np.repeat(episodes.tape, length, axis=1)
        for k, block in enumerate(blocks[1:], 1):
            number = task.kind_of_block(block)
            tape[:, k, KIND], tape[:, k, TAPE_STOCK] = number, task.kinds[number].stock
        return replace(episodes, tape=tape)

    def advance(self, episodes: Episodes, speeds: Table, executions: Table) -> tuple[Table, Table]:
        """As `step`, of the episodes that are not over; the shapes are those of all N."""
        running = ~self.over(episodes)
        return self.step(episodes, speeds, executions, active=None if running.all() else np.flatnonzero(running))

    def part_from(self, block: int) -> range:
        """A block of the nominal sequence and those after it up to the end of its part."""
        task, last = self.task, block
        # only parts of a fixed sequence have several blocks
        while task.orders is None and not task.kinds[task.kind_of_block(last)].ends_part:
            last += 1
        return range(block, last + 1)

    @property
    def compiled(self) -> bool:
        """Whether compiled code runs a step, so that many branches can be tried before a choice."""
        return True

    @property
    def most_steps(self) -> int:
        """Steps of an episode at most."""
        return self.task.blocks

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        """Which episodes have ground their last block, shape (N,)."""
        return episodes.block >= self.task.blocks

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """The entries of the observation."""
        return readings(task, full=full, pre_dress=pre_dress)

    def _grind(self, tables: tuple[Any, ...], *arguments: Any) -> None:
        """Grind the next blocks; arguments as for `envs.step.step_of`."""
        step_blocks(tables, *arguments)
