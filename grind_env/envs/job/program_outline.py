"""The outline of a part program: its cycle blocks, and the part of each block."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import NamedTuple

from grind_env.control import ControlError, CyclePlan, CycleStart, Programs, execute
from grind_env.control.block_words import Block
from grind_env.envs.program_episode import BlockRun, Passage, ProgramEpisode, Words
from grind_env.errors import GrindError
from grind_env.machine.dress.dress_run import DressPlan
from grind_env.machine.job import Job, Part, Stage
from grind_env.machine.part.feed_moves import FEED_WORD, speed_word
from grind_env.machine.script.script import Script
from grind_env.machine.script.script_tables import BlockRow, ScriptTables
from grind_env.process.cost import Limits

INCH = 25.4  #: length of an inch, mm

MOST_BLOCKS = 2000  #: most cycle blocks of an episode, feed moves that are strokes included


class JobChoice(NamedTuple):
    """Choice of an agent for a block."""

    speed: float  #: E, mm/min
    executions: int  #: D


class JobProgramError(GrindError):
    """A part program and a job from which no environment can be made."""


@dataclass(frozen=True, slots=True)
class BlockOutline:
    """A cycle block as the program has it."""

    block: Block  #: the block as read
    plan: CyclePlan  #: parameters of its cycle
    inch: bool  #: whether its numbers are inches
    dress: DressPlan | None  #: one execution of its dress program; None without a dress program
    depth: float  #: depth that the part gains up to the next cycle block, mm; in a G81 other blocks feed
    finish: float  #: depth of the deepest block of its stage of the part, mm
    part: int  #: number of its part, from 0
    starts_part: bool  #: whether it is the first block on its part
    finished: int  #: number of parts that are taken off before the next block
    limits: Limits  #: limits of its stage of the part
    counts_all: bool  #: whether heat counts over all plunges of that stage

    def words(self, choice: JobChoice) -> Words:
        """Return the words for a choice in this block; a G81 or a block without a dress program takes no D.

        E stays as written if the block already has this value, because it may have decimals or be clamped; so does F of
        a feed move.
        """
        letter = speed_word(self.plan)
        speed = f"{choice.speed / INCH:.4f}" if self.inch else f"{choice.speed:.0f}."
        if choice.speed == self.plan.feed:
            own = [str(word)[1:] for word in self.block.words if word.letter == letter]
            if own:
                speed = own[0]
            elif letter == FEED_WORD and not self.inch:  # the F in force may have decimals
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
    """Return the cycle blocks of a program that must be run to find them, on parts as stated in the job."""
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
    """Return the sequence of cycle blocks and parts of a program, which no choice may change."""
    return tuple(Passage(block.block.source, block.part + 1, block.finished) for block in blocks)


def refuse_many(programs: Programs, job: Job) -> tuple[str, ...]:
    """Refuse a program with too many cycle blocks; other faults show when the program is ground.

    Returns:
        A sentence for each variable of the job whose value the program does not read.
    """
    events = execute(programs, replace(job.control, whole_cycles=True))
    events.set_wheel_radius(0.5 * job.setup.wheel.diameter)
    with suppress(ControlError):
        cycles = (event for event in events if isinstance(event, CycleStart))
        refuse_more(programs, sum(1 for _ in islice(cycles, MOST_BLOCKS + 1)))
        return events.unread
    return ()


def refuse_more(programs: Programs, blocks: int) -> None:
    """Raise `JobProgramError` for a program with more blocks than an episode may have."""
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
