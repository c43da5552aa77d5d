"""Episodes of a user's program as part programs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from grind_env.control import Programs
from grind_env.control.block_words import Block
from grind_env.control.word_rewriting import with_words
from grind_env.envs.episode_state import Episodes
from grind_env.envs.job.program_outline import BlockOutline, JobChoice
from grind_env.envs.job.repeated_program import with_words_chosen
from grind_env.envs.program_episode import ProgramEpisode, Words
from grind_env.envs.program_writer import ProgramWriter, Written
from grind_env.machine.job import Job, PartConditions
from grind_env.machine.record import GrindingRecord


class RunBlock(NamedTuple):
    """A cycle block with its chosen E and D."""

    number: int  #: number of the block, from 0
    speed: float  #: E, mm/min
    executions: int  #: D
    extra_state: tuple[float, ...]  #: memory of process and gauge at the start, without the wheel


@dataclass(frozen=True, slots=True)
class JobWriter(ProgramWriter):
    """Writer of chosen words into a user's program; `conditions` of the parts come from the simulation."""

    programs: Programs
    job: Job
    outlines: Sequence[BlockOutline]
    conditions: Callable[[Episodes, int], tuple[PartConditions, ...]]

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> RunBlock:
        return RunBlock(int(episodes.block[i]), float(speed), int(executions), episodes.extra_state(i))

    def text(self, block: RunBlock) -> str:
        return with_words(*self._chosen(block)).source.text

    def program(self, blocks: Sequence[RunBlock]) -> str:
        return with_words_chosen(self.programs, [self._chosen(block) for block in blocks])

    def written(self, episodes: Episodes, i: int, blocks: Sequence[RunBlock]) -> Written:
        return Written(self.program(blocks), self._job(episodes, i, blocks))

    def record(self, episodes: Episodes, i: int, blocks: Sequence[RunBlock]) -> GrindingRecord:
        program = ProgramEpisode(self.programs, self._job(episodes, i, blocks))
        for block in blocks:
            program.step(self._chosen(block)[1])
        return program.run.record()

    def _chosen(self, block: RunBlock) -> tuple[Block, Words]:
        outline = self.outlines[block.number]
        return outline.block, outline.words(JobChoice(block.speed, block.executions))

    def _job(self, episodes: Episodes, i: int, blocks: Sequence[RunBlock]) -> Job:
        """Return the job with the parts of episode i and the memory of its process at the start."""
        own = blocks[0].extra_state[: len(self.job.process.own._fields)]
        return replace(self.job, parts=self.conditions(episodes, i), part_stations=(), own=own)
