"""The state of episodes of a user's own program."""

import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from grind_env.arrays import Numbers, Table
from grind_env.envs.episodes import Episodes, EpisodesT
from grind_env.envs.job.step import JobArrays
from grind_env.envs.program_episode import ProgramEpisode


@dataclass(slots=True)
class JobEpisodes(Episodes):
    """The state of N episodes.

    `stages` is what each part has come to since it was last judged, shape (N, fields of `step.StageSoFar`); `surfaces`
    are the parts in zones, shape (N, zones, fields of `Zone`); `first` is the number of the block that each tape begins
    with, shape (N,); `machine` is the number of that on which each runs (`JobSimulation.on_machines`), shape (N,), and
    `forces` a factor on its forces in each block, shape (N, 1 or blocks); `programs` are those under execution if the
    control runs them.
    """

    stages: Table
    surfaces: Table
    first: Numbers
    machine: Numbers
    forces: Table
    programs: list[ProgramEpisode]

    def compiled_arrays(self) -> JobArrays:
        """What the compiled step takes of them."""
        return JobArrays(*(getattr(self, name) for name in JobArrays._fields))

    def pick(self, index: ArrayLike) -> "JobEpisodes":
        """Copies of the episodes at `index` (which may repeat); a program under execution is run anew."""
        chosen = np.asarray(index)
        arrays = {name: array[chosen] for name, array in self.arrays().items() if name != "programs"}
        programs = [copy.deepcopy(self.programs[i]) for i in chosen.tolist()] if self.programs else []
        return JobEpisodes(programs=programs, **arrays)

    def coming(self) -> Table:
        at = np.minimum(self.block - self.first, self.tape.shape[1] - 1)
        return np.asarray(self.tape[np.arange(len(at)), at])

    def window(self: EpisodesT, tape: Table, owner: Numbers, first: int, blocks: int) -> EpisodesT:
        """As `Episodes.window`; the wheel left behind is charged for after the last block of the program only."""
        at = np.full(len(owner), first)
        cut = {"tape": tape[owner, first : first + blocks], "block": at, "first": at.copy()}
        return replace(self, **cut)
