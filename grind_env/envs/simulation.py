"""The task itself: N episodes side by side, without Gymnasium.

One compiled call steps all of them: cycle parameters from (E, D), the block kernel, cost, and the readings of
the next observation. The single environment runs it with N = 1, the vector environment and the planners with
many.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.contexts import Given
from grind_env.envs.episode import EpisodeGenerator
from grind_env.envs.observations import Reading, readings, scaling
from grind_env.envs.observe import observe_blocks
from grind_env.envs.rows import Memory, Outcome, kind_table, parameter_table, shop_row
from grind_env.envs.step import CYCLE_FIELDS, NEW_PART, step_blocks
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.machine.cycle import PartState
from grind_env.machine.tally import Tally
from grind_env.process.state import WheelState

Table = NDArray[np.float64]
EpisodesT = TypeVar("EpisodesT", bound="Episodes")


@dataclass(slots=True)
class Episodes:
    """The state of N episodes: arrays with one row an episode.

    `tape` has shape (N, blocks, fields of `TapeRow`); the others (N, fields of the named tuple).
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
        """Copies of the episodes at `index` (which may repeat): what-if branches for a planner."""
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
        """Write tape and first wheel of the episodes at `index`, one from each generator."""


class Simulation:
    """Steps episodes of one task.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        pre_dress: whether observations show if the last block began with a dress.
    """

    def __init__(self, task: Task, *, full: bool = False, pre_dress: bool = False) -> None:
        self.task = task
        self.entries = self._readings(task, full=full, pre_dress=pre_dress)
        self.kinds, self.base, self.shop = kind_table(task), parameter_table(task), shop_row(task)
        self._materials = len(task.materials)
        self._scaling = scaling(task, self.entries)
        self._begin_with(EpisodeGenerator(task))

    def _begin_with(self, generator: Generator) -> None:
        """Let episodes begin as a generator draws them, with nothing done yet."""
        # kept from step to step: of tens of MB the system would have to find every page anew
        self._cycles, self._parameters = np.empty((0, CYCLE_FIELDS)), np.empty((0, self.base.shape[1]))
        self._shops = np.array([self.shop])
        self._generator = generator
        self._first_part = np.array(NEW_PART)
        nothing = Memory(*[0.0] * len(Memory._fields))
        self._first_memory = np.array(nothing._replace(gauged=-1.0, volume=self.task.start.volume, survival=1.0))

    def start(self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None) -> Episodes:
        """New episodes, one from each generator, with what is given of each."""
        n = len(rngs)
        episodes = self._room(n)
        self.restart_all(episodes, range(n), rngs, [Given()] * n if given is None else given)
        return episodes

    def _room(self, n: int) -> Episodes:
        """Arrays for N episodes."""
        return Episodes(
            np.empty((n, self.task.blocks, len(TapeRow._fields))),
            np.zeros(n, np.int64),
            np.empty((n, len(WheelState._fields))),
            np.empty((n, len(PartState._fields))),
            np.empty((n, len(Memory._fields))),
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
        episodes.block[rows] = 0
        episodes.parts[rows] = self._first_part
        episodes.memory[rows] = self._first_memory

    def taken(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        """What the coming blocks make of a choice."""
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
            self._cycles[:n],
            self._parameters[:n],
            self.kinds,
            self.base,
            self._shops,
            *episodes.arrays().values(),
            speeds,
            executions,
            np.zeros(n) if pre_dresses is None else pre_dresses,
            self._materials,
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

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        """Which episodes have ground their last block, shape (N,)."""
        return episodes.block >= self.task.blocks

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """The entries of the observation."""
        return readings(task, full=full, pre_dress=pre_dress)

    def _grind(self, cycles: Table, *arguments: Any) -> None:
        """Grind the next blocks; arguments as for `step_blocks`, with all arrays of the episodes."""
        step_blocks(cycles, *arguments)
