"""A part program and its job, examined before an agent gets them: the cycle blocks, and what the program costs."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from grind_env.control import ControlError, CyclePlan, CycleStart, Programs, execute
from grind_env.envs.program_episode import BlockRun, ProgramEpisode, Words
from grind_env.envs.rows import COST_TERMS
from grind_env.errors import GrindError
from grind_env.machine.compiled import expenses, handover_cost
from grind_env.machine.dress_program import DressPlan
from grind_env.machine.job import Job
from grind_env.machine.run import GrindingRun
from grind_env.process.state import WheelState

INCH = 25.4
"""mm."""

MOST_BLOCKS = 2000
"""Cycle blocks of an episode."""


class Choice(NamedTuple):
    """What an agent chooses for a block."""

    speed: float
    """E, mm/min."""
    executions: int
    """D."""


class JobProgramError(GrindError):
    """A part program and a job from which no environment can be made."""


@dataclass(frozen=True, slots=True)
class BlockOutline:
    """A cycle block as the program has it.

    Attributes:
        plan: its parameters.
        inch: whether it is read in inches.
        depth: by which the part gets deeper from this block to the next one, mm; in a G81 by other blocks.
        starts_part: whether it is the first one on its part.
        part: number of its part, from 0.
    """

    plan: CyclePlan
    inch: bool
    depth: float
    starts_part: bool
    part: int

    def words(self, choice: Choice) -> Words:
        """The words that say a choice in this block; a G81, or a block without a dress program, takes no D."""
        speed = f"{choice.speed / INCH:.4f}" if self.inch else f"{choice.speed:.0f}."
        return {"E": speed, "D": str(choice.executions)} if self.takes_dresses else {"E": speed}

    @property
    def takes_dresses(self) -> bool:
        """Whether it may have a D word."""
        return self.plan.code != "G81" and self.plan.program is not None


@dataclass(frozen=True, slots=True)
class Outline:
    """What is known of a program and its job before it is run.

    Attributes:
        programs: the program.
        job: the job.
        blocks: its cycle blocks in the order in which they are run.
        parts: how many parts it grinds.
        wheel: as the first cycle finds it.
        cost: of the program with its own words on nominal parts, $ per cycle block.
    """

    programs: Programs
    job: Job
    blocks: tuple[BlockOutline, ...]
    parts: int
    wheel: WheelState
    cost: float


def outline(programs: Programs, job: Job, trials: Sequence[Choice]) -> Outline:
    """Run a program on nominal parts, as it is written and with the same choice for all its blocks.

    Args:
        programs: what `control.read` or `control.read_file` returned.
        job: the job.
        trials: choices with each of which the program must run as well.

    Raises:
        GrindError: it cannot be run, or there is nothing to choose in it.
    """
    _refuse_many(programs, job)
    episode = ProgramEpisode(programs, job)
    runs: list[BlockRun] = []
    while episode.block is not None:
        runs.append(episode.step({}))
    if not runs:
        raise JobProgramError(
            f"{programs.name} has no cycle block G81, G82 or G83, so that there is no E or D to choose"
        )
    cost = sum(sum(costs(run, job).values()) for run in runs) + handover(episode.run, runs[-1].plan, job)
    if not cost > 0.0:
        raise JobProgramError(f"{programs.name} costs nothing with this job; give its machine an hourly_rate above 0")
    blocks = tuple(_outlines(runs))
    for choice in trials:
        trial = ProgramEpisode(programs, job)
        for block in blocks:
            trial.step(block.words(choice))
    return Outline(programs, job, blocks, len(episode.run.parts), runs[0].wheel, cost / len(runs))


def _refuse_many(programs: Programs, job: Job) -> None:
    """Refuse a program of too many cycle blocks; other faults are for those who grind with it."""
    events = execute(programs, job.control)
    events.set_wheel_radius(0.5 * job.setup.wheel.diameter)
    with suppress(ControlError):
        cycles = (event for event in events if isinstance(event, CycleStart))
        if next(islice(cycles, MOST_BLOCKS, None), None) is not None:
            raise JobProgramError(
                f"{programs.name} runs more than {MOST_BLOCKS} cycle blocks; let it come to its M30 before"
            )


def costs(run: BlockRun, job: Job) -> dict[str, float]:
    """What a block has cost, $: the terms of `COST_TERMS` without the last."""
    volume = float(run.strokes["worn"].sum() + run.dresses["removed"].sum())
    terms = (
        *expenses(run.seconds, volume, float(run.dresses.size), job.rates),
        float(run.finished["scrap_cost"].sum()),
    )
    return dict(zip(COST_TERMS, terms, strict=False))


def handover(run: GrindingRun, plan: CyclePlan, job: Job) -> float:
    """Price of the dull wheel that a run leaves, $; 0 if its last cycle knows no dress program to sharpen it with."""
    if plan.program is None or run.wheel is None:
        return 0.0
    dress: DressPlan = run.dressing.plans[plan.program]
    return handover_cost(run.wheel, float(dress.passes), dress.feed, dress.depth, dress.seconds, run.part.p, job.rates)


def _outlines(runs: Sequence[BlockRun]) -> Iterator[BlockOutline]:
    part, reached = 0, 0.0
    for run in runs:
        starts = run.part != part
        surface = 0.0 if starts else reached
        # grooves of another part may lie on the way to this block, or from it
        part, reached = run.part, max([surface, *run.strokes["Z"][run.strokes["part"] == run.part]])
        yield BlockOutline(run.plan, run.inch, reached - surface, starts, part - 1)
