"""The outline of a part program: its cycle blocks, and the part of each block."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import NamedTuple

from grind_env.control import ControlError, CyclePlan, CycleStart, Programs, execute
from grind_env.control.words import Block
from grind_env.envs.program_episode import BlockRun, Passage, ProgramEpisode, Words
from grind_env.errors import GrindError
from grind_env.machine.dress.program import DressPlan
from grind_env.machine.job import Job, Part, Stage
from grind_env.machine.part.feeds import FEED_WORD, speed_word
from grind_env.machine.script.script import Script
from grind_env.machine.script.tables import BlockRow, ScriptTables
from grind_env.process.cost import Limits

INCH = 25.4
"""mm."""

MOST_BLOCKS = 2000
"""Cycle blocks of an episode, with feed moves that are strokes."""


class JobChoice(NamedTuple):
    """Choice of an agent for a block."""

    speed: float
    """E, mm/min."""
    executions: int
    """D."""


class JobProgramError(GrindError):
    """A part program and a job from which no environment can be made."""


@dataclass(frozen=True, slots=True)
class BlockOutline:
    """A cycle block as the program has it."""

    block: Block  # as it was read
    plan: CyclePlan  # its parameters
    inch: bool  # whether it is read in inches
    dress: DressPlan | None  # one execution of its dress program; None if it knows none
    depth: float  # by which the part gets deeper from this block to the next one, mm; in a G81 by other blocks
    finish: float  # depth of the deepest block of its stage of the part, mm
    part: int  # number of its part, from 0
    starts_part: bool  # whether it is the first one on its part
    finished: int  # parts that are taken off before the next block
    limits: Limits  # of its stage of the part
    counts_all: bool  # whether heat counts over all plunges of that stage

    def words(self, choice: JobChoice) -> Words:
        """Return the words that say a choice in this block; a G81, or a block without a dress program, takes no D.

        Its own E stays as it is written, for it may have decimals or be clamped; so does F of a feed move.
        """
        letter = speed_word(self.plan)
        speed = f"{choice.speed / INCH:.4f}" if self.inch else f"{choice.speed:.0f}."
        if choice.speed == self.plan.feed:
            own = [str(word)[1:] for word in self.block.words if word.letter == letter]
            if own:
                speed = own[0]
            elif letter == FEED_WORD and not self.inch:  # that in force may have decimals
                speed = f"{choice.speed:.4f}".rstrip("0")
        return {letter: speed, "D": str(choice.executions)} if self.takes_dresses else {letter: speed}

    @property
    def takes_dresses(self) -> bool:
        """Return whether the block may have a D word."""
        return self.plan.plunges and self.plan.program is not None


def outline_of_script(script: Script, tables: ScriptTables) -> tuple[BlockOutline, ...]:
    """Return the cycle blocks of a script."""
    part, reached, blocks = -1, 0.0, []
    for block, numbers in zip(script.blocks, tables.blocks.tolist(), strict=True):
        row = BlockRow(*numbers)
        starts = row.starts_part > 0.0
        part, reached = part + starts, 0.0 if starts else reached
        depth, reached = row.reached - reached, row.reached
        outline = BlockOutline(
            block.block,
            block.plan,
            block.inch,
            block.dress_plan,
            depth,
            row.finish,
            part,
            starts,
            int(block.ends_part),
            Limits(row.rise, row.power, row.roughness, row.size),
            row.counts_all > 0.0,
        )
        blocks.append(outline)
    return tuple(blocks)


def outline_of_runs(
    programs: Programs, job: Job, trials: Sequence[JobChoice], between: Callable[[], object]
) -> tuple[BlockOutline, ...]:
    """Return the cycle blocks of a program that has to be run to know them, on parts as the job states them."""
    episode = ProgramEpisode(programs, job)
    runs: list[BlockRun] = []
    while episode.block is not None:
        runs.append(episode.step({}))
        refuse_more(programs, len(runs))
        between()
    blocks = tuple(_outlines(runs, episode))
    for choice in trials:
        trial = ProgramEpisode(programs, job, course_of(blocks))
        for block in blocks:
            trial.step(block.words(choice))
            between()
    return blocks


def parts_of(blocks: Sequence[BlockOutline]) -> int:
    """Return the number of parts that a program of these blocks grinds."""
    return max(sum(block.finished for block in blocks), blocks[-1].part + 1)


def course_of(blocks: Sequence[BlockOutline]) -> tuple[Passage, ...]:
    """Return the values of a program that no choice in its blocks changes."""
    return tuple(Passage(block.block.source, block.part + 1, block.finished) for block in blocks)


def refuse_many(programs: Programs, job: Job) -> tuple[str, ...]:
    """Refuse a program of too many cycle blocks, or of none; other faults are for those who grind with it.

    Returns:
        What to say of each variable of the job whose value it does not read.
    """
    events = execute(programs, replace(job.control, whole_cycles=True))
    events.set_wheel_radius(0.5 * job.setup.wheel.diameter)
    with suppress(ControlError):
        cycles = (event for event in events if isinstance(event, CycleStart))
        refuse_more(programs, sum(1 for _ in islice(cycles, MOST_BLOCKS + 1)))
        return events.unread
    return ()


def refuse_more(programs: Programs, blocks: int) -> None:
    """Refuse a program of more blocks than an episode may have; errors as of `refuse_many`."""
    if blocks > MOST_BLOCKS:
        raise JobProgramError(
            f"{programs.name} runs more than {MOST_BLOCKS} cycle blocks; let it come to its M30 before"
        )


def _outlines(runs: Sequence[BlockRun], episode: ProgramEpisode) -> Iterator[BlockOutline]:
    part, reached, stage, job = 0, 0.0, 0, episode.run.job
    finish = [0.0] * len(runs)
    for k in reversed(range(len(runs))):
        ends = k + 1 == len(runs) or runs[k].judged or runs[k + 1].part != runs[k].part
        finish[k] = runs[k].deepest if ends else finish[k + 1]
    for run, at_end, (block, _) in zip(runs, finish, episode.chosen, strict=True):
        starts = run.part != part
        surface, stage = (0.0, 0) if starts else (reached, stage)
        stages: list[Stage | Part] = [*job.of_part(run.part).part.stages, job.of_part(run.part).part]
        asked = stages[stage]
        stage += run.judged and not run.finished.size
        # grooves of another part may lie on the way to this block, or from it
        part, reached = run.part, max([surface, *run.strokes["Z"][run.strokes["part"] == run.part]])
        dress = None if run.plan.program is None else episode.run.dressing.plans[run.plan.program]
        yield BlockOutline(
            block,
            run.plan,
            run.inch,
            dress,
            reached - surface,
            at_end,
            part - 1,
            starts,
            int(run.finished.size),
            job.of_part(run.part).limits_at(asked),
            asked.rise_allowance > 0.0,
        )
