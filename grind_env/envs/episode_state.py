"""The state of N episodes side by side, and copies of them for planners."""

import copy
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.array_types import Numbers, Table
from grind_env.envs.noise_tape import BLOCKS, DRAWN, SOURCE, TapeRow
from grind_env.envs.program_episode import ProgramEpisode
from grind_env.envs.step_arrays import KIND, EpisodeArrays
from grind_env.errors import GrindError
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.process.stroke_types import WheelState

NOISE = [TapeRow._fields.index(name) for name in TapeRow._fields if name.endswith("_noise")]

DRAWN_FROM = [k for k in range(SOURCE) if k not in (BLOCKS, DRAWN)]


_of_step = attrgetter(*EpisodeArrays._fields)  #: getter of all arrays at once, three times as fast as one by one


@dataclass(slots=True)
class Episodes:
    """The state of N episodes.

    All fields are arrays with one row for each episode, as in `EpisodeArrays`, in the units of their columns. `tape`
    has a row for each block, or two rows that take turns, for the coming and the next block. `source` has the fields of
    `Origin` and `Carried`; `schedule` is as for `draw_rows`. `programs` are the programs under execution if the control
    runs them. With `whole_program`, episodes end and the handover of the wheel is charged after the last block of the
    program, even if their tapes end earlier.
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
        """Return copies of the episodes at `index`, shape (M,), which may repeat: what-if branches for a planner.

        A program under execution is executed again up to its present block.
        """
        chosen = np.asarray(index)
        programs = [copy.deepcopy(self.programs[i]) for i in chosen.tolist()] if self.programs else []
        return replace(self, programs=programs, **{name: array[chosen] for name, array in self.arrays().items()})

    def row(self, i: int) -> Table:
        """Return the row of the coming block of episode i, shape (fields of `TapeRow`,), while the episode runs."""
        return np.asarray(self.tape[i, self.block[i] % self.tape.shape[1]])

    def coming(self) -> Table:
        """Return the tape rows of the coming blocks (at the end: the last blocks), shape (N, fields of `TapeRow`)."""
        at = np.minimum(self.block, self.source[:, BLOCKS].astype(np.int64) - 1) % self.tape.shape[1]
        return np.asarray(self.tape[np.arange(len(at)), at])

    def hide_noise(self) -> None:
        """Remove future gauge noise and its source from full tapes, since no machine knows them."""
        self.tape[..., NOISE] = 0.0
        self.source[:, DRAWN_FROM] = 0.0

    def window(self, tape: Table, owner: Numbers, first: int, blocks: int) -> "Episodes":
        """Return branches at block `first` with short tapes, after which they end: full tapes take long to copy.

        The handover of the wheel is charged after the last block of a tape.

        Args:
            tape: full tapes of the original episodes, shape (N, blocks, fields of `TapeRow`).
            owner: index of the original episode of each branch, shape (B,).
            first: number of the coming block of all branches.
            blocks: number of blocks on the new tapes.
        """
        return replace(self, block=np.zeros_like(self.block)).on(tape[owner, first : first + blocks])

    def on(self, tape: Table) -> "Episodes":
        """Return the episodes with other tapes, shape (N, rows, fields of `TapeRow`), after which they end."""
        source = self.source.copy()
        # each block of a program is a kind of its own
        left = self.schedule.shape[1] - tape[:, :1, KIND] if self.whole_program else tape.shape[1]
        source[:, [BLOCKS, DRAWN]] = left
        return replace(self, tape=tape, source=source)


class EpisodeOver(GrindError):
    """A step of an episode whose last block has been run."""


def check_running(episodes: Episodes, active: NDArray[np.int64], blocks: Any) -> None:
    """Check that each episode in `active` has a block left of its `blocks`, one number for all or shape (N,).

    Raises:
        EpisodeOver: an episode has no block left.
    """
    ended = episodes.block >= blocks
    if np.count_nonzero(ended) and ended[active].any():
        i = int(active[ended[active].argmax()])
        raise EpisodeOver(f"episode {i} is over after {episodes.block[i]} blocks: start it again or leave it out")
