"""The state of episodes of a user's own program."""

import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from grind_env.arrays import Table
from grind_env.envs.episodes import Episodes, EpisodesT
from grind_env.envs.program_episode import ProgramEpisode
from grind_env.envs.tape import BLOCKS, DRAWN
from grind_env.envs.transition import KIND


@dataclass(slots=True)
class JobEpisodes(Episodes):
    """The state of N episodes; `programs` are those under execution if the control runs them."""

    programs: list[ProgramEpisode]

    def pick(self, index: ArrayLike) -> "JobEpisodes":
        """Copies of the episodes at `index` (which may repeat); a program under execution is run anew."""
        chosen = np.asarray(index)
        arrays = {name: array[chosen] for name, array in self.arrays().items() if name != "programs"}
        programs = [copy.deepcopy(self.programs[i]) for i in chosen.tolist()] if self.programs else []
        return JobEpisodes(programs=programs, **arrays)

    def on(self: EpisodesT, tape: Table) -> EpisodesT:
        """As `Episodes.on`; they end, and the wheel is charged for, after the last block of the program only."""
        source = self.source.copy()
        source[:, [BLOCKS, DRAWN]] = self.schedule.shape[1] - tape[:, :1, KIND]
        return replace(self, tape=tape, source=source)
