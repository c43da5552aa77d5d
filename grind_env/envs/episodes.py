"""The state of N episodes side by side, and copies of them for planners."""

import copy
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.arrays import Numbers, Table
from grind_env.envs.program_episode import ProgramEpisode
from grind_env.envs.tape import BLOCKS, DRAWN, SOURCE, TapeRow
from grind_env.envs.transition import KIND, EpisodeArrays
from grind_env.errors import GrindError
from grind_env.machine.loops.rows import OWN_FROM
from grind_env.process.state import WheelState

NOISE = [TapeRow._fields.index(name) for name in TapeRow._fields if name.endswith("_noise")]

DRAWN_FROM = [k for k in range(SOURCE) if k not in (BLOCKS, DRAWN)]


_of_step = attrgetter(*EpisodeArrays._fields)
"""Gets attributes in a third of the time that it takes one by one."""


@dataclass(slots=True)
class Episodes:
    """The state of N episodes.

    All fields are arrays with one row an episode, as of `EpisodeArrays`, in the units of their columns. `tape`
    has a row for each block, or two that take turns, of the coming block and of the next one. `source` has an `Origin`
    and what is `Carried`; `schedule` is as `draw_rows` takes it. `programs` are those under execution if the control
    runs them. `whole_program` is whether episodes end, and the wheel is charged for, after the last block of the
    program, whatever blocks their tapes have.
    """

    tape: Table
    block: NDArray[np.int64]
    wheels: Table
    parts: Table
    memory: Table
    source: Table
    schedule: NDArray[np.int16]
    stages: Table
    surfaces: Table
    machine: Numbers
    forces: Table
    programs: list[ProgramEpisode] = field(default_factory=list)
    whole_program: bool = False

    def arrays(self) -> dict[str, Any]:
        """Return all arrays by name."""
        return {name: getattr(self, name) for name in EpisodeArrays._fields}

    def in_order(self) -> tuple[Any, ...]:
        """Return the arrays of the compiled step, in its order."""
        return _of_step(self)

    def wheel(self, i: int) -> WheelState:
        """Return the wheel of episode i."""
        return WheelState(*self.wheels[i, :OWN_FROM].tolist())

    def extra_state(self, i: int) -> tuple[float, ...]:
        """Return further memory of process and gauge in episode i."""
        return tuple(self.wheels[i, OWN_FROM:].tolist())

    def pick(self, index: ArrayLike) -> "Episodes":
        """Copies of the episodes at `index`, shape (M,), which may repeat: what-if branches for a planner.

        A program under execution is run anew.
        """
        chosen = np.asarray(index)
        programs = [copy.deepcopy(self.programs[i]) for i in chosen.tolist()] if self.programs else []
        return replace(self, programs=programs, **{name: array[chosen] for name, array in self.arrays().items()})

    def row(self, i: int) -> Table:
        """Return the row of the coming block of episode i, shape (fields of `TapeRow`,), while the episode runs."""
        return np.asarray(self.tape[i, self.block[i] % self.tape.shape[1]])

    def coming(self) -> Table:
        """Return the rows of the coming blocks, or of the last ones, on the tapes; shape (N, fields of `TapeRow`)."""
        at = np.minimum(self.block, self.source[:, BLOCKS].astype(np.int64) - 1) % self.tape.shape[1]
        return np.asarray(self.tape[np.arange(len(at)), at])

    def hide_noise(self) -> None:
        """Remove future gauge noise and its source from full tapes, since no machine knows them."""
        self.tape[..., NOISE] = 0.0
        self.source[:, DRAWN_FROM] = 0.0

    def window(self, tape: Table, owner: Numbers, first: int, blocks: int) -> "Episodes":
        """Branches at block `first` with a tape of some blocks only, after which they end: whole ones are long to copy.

        After the last block of a tape the wheel left behind is charged for.

        Args:
            tape: of the episodes that they belong to, shape (N, blocks, fields of `TapeRow`).
            owner: which of these, shape (B,).
            first: the coming block of all of them.
            blocks: length of the tape.
        """
        return replace(self, block=np.zeros_like(self.block)).on(tape[owner, first : first + blocks])

    def on(self, tape: Table) -> "Episodes":
        """Return the same with another tape, shape (N, rows, fields of `TapeRow`), after which they end."""
        source = self.source.copy()
        # each block of a program is a kind of its own
        left = self.schedule.shape[1] - tape[:, :1, KIND] if self.whole_program else tape.shape[1]
        source[:, [BLOCKS, DRAWN]] = left
        return replace(self, tape=tape, source=source)


class EpisodeOver(GrindError):
    """A step of an episode whose last block has been run."""


def check_running(episodes: Episodes, active: NDArray[np.int64], blocks: Any) -> None:
    """Check that each episode in `active`, of so many `blocks` (a number, or shape (N,)), has a block left.

    Raises:
        EpisodeOver: an episode has none.
    """
    ended = episodes.block >= blocks
    if np.count_nonzero(ended) and ended[active].any():
        i = int(active[ended[active].argmax()])
        raise EpisodeOver(f"episode {i} is over after {episodes.block[i]} blocks: start it again or leave it out")
