"""What an environment is without Gymnasium: N episodes side by side, and all that there is to say of them.

Policies, evaluations, trainings and the environments themselves see no more of a problem than this contract. Every
environment that chooses E and D has a simulation, as `env.unwrapped.simulation`; the single one steps one episode of
it, the native vector one and the planners many. What a planner, a belief or an adviser needs beyond it are its
`branches`.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers, Table
from grind_env.envs.branches import Branches
from grind_env.envs.contexts import Given
from grind_env.envs.cost import Outcome
from grind_env.envs.episodes import Episodes, EpisodesT
from grind_env.envs.observations import Reading
from grind_env.envs.tasks import Task
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.process.process import Process
from grind_env.render.view import EpisodePicture

SimulationT = TypeVar("SimulationT", bound="Simulation")


class Written(NamedTuple):
    """An episode as one takes it to the machine: `machine.grind` makes of it what the episode was."""

    program: str
    """The part program."""
    job: Job
    """Its job, with the wheel, the lots and the stocks of the episode."""
    requests: tuple[float, ...] = ()
    """Times of the control, s, at which the operator asks for a dress while the program runs."""


class Simulation(Protocol):
    """A problem: it draws and steps episodes, says what is observed of them, writes them down and shows them."""

    @property
    def task(self) -> Task:
        """Names and limits; a simulation of a program has one that says the same of it."""

    @property
    def entries(self) -> tuple[Reading, ...]:
        """Of the observation, the measured ones first."""

    @property
    def kinds(self) -> Table:
        """Numbers of the kinds of blocks, shape (rows, fields of `KindRow`)."""

    @property
    def process(self) -> Process:
        """What grinds."""

    @property
    def branches(self) -> Branches:
        """What planners, beliefs and advisers need beside."""

    @property
    def pre_dress(self) -> bool:
        """Whether a choice has a third number: 1 for a dress before the first plunge."""

    @property
    def barred(self) -> Mapping[str, str]:
        """What a context of `grind_env.envs.contexts` cannot fix, each with the reason."""

    @property
    def compiled(self) -> bool:
        """Whether compiled code runs a step, so that many branches can be tried before a choice."""

    @property
    def most_steps(self) -> int:
        """Steps of an episode at most."""

    def start(
        self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None, *, whole: bool = True
    ) -> Episodes:
        """New episodes, one from each generator, with what is given of each; `whole` as for `room`."""

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """Put new episodes in place of those at `index`, one from each generator, with what is given of each."""

    def room(self, n: int, *, whole: bool = True) -> Episodes:
        """Arrays for N episodes, of which none has been drawn.

        With whole tapes, or, for all but a user's own program, with rows for the coming blocks only.
        """

    def whole(self, episodes: EpisodesT) -> EpisodesT:
        """Copies with whole tapes."""

    def clear(self, episodes: Episodes, index: Numbers) -> None:
        """Forget what the episodes at `index`, shape (M,), have done but for their wheels: none has begun."""

    def taken(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        """What the coming blocks make of a choice, each of shape (N,)."""

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

        Raises:
            EpisodeOver: an episode in `active` has run its last block.
            GrindError: a block cannot be run so; every episode is then as it was before.
        """

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        """Which episodes have ground their last block, shape (N,)."""

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Observations of the coming blocks, shape (N, entries), float32.

        After the last block of an episode the coming block reads as zeros.
        """

    def read(self, observation: NDArray[np.float32]) -> dict[str, Table]:
        """What observations say in physical units, by name, each shape (N,), with what never changes."""

    def without_wheel_changes(self: SimulationT) -> SimulationT:
        """The same, but a wheel is changed only when it is said."""

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> Any:
        """What there is to say of the step that episode i takes next: `text` and the methods below take it."""

    def text(self, block: Any) -> str:
        """What the control reads for it."""

    def program(self, blocks: Sequence[Any]) -> str:
        """The part program of an episode of these steps, with its dress program.

        Raises:
            GrindError: no one text says them.
        """

    def written(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> Written:
        """Episode i, of which these steps have been taken: at least one."""

    def record(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> GrindingRecord:
        """Its strokes, dresses and finished parts, as `machine.grind` records them."""

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        """What a picture of episode i shows, of which these steps have been taken with these outcomes."""


def advance(simulation: Simulation, episodes: Episodes, speeds: Table, executions: Table) -> tuple[Table, Table]:
    """As `Simulation.step`, of the episodes that are not over; the shapes are those of all N."""
    running = ~simulation.over(episodes)
    return simulation.step(episodes, speeds, executions, active=None if running.all() else np.flatnonzero(running))
