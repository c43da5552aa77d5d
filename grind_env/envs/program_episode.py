"""A part program executed cycle block by cycle block, one step of an environment each.

The control stops before every cycle block, takes the words that an agent has chosen for it, and goes on to the next
one, while `machine.program_run` grinds what it commands.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.control import ControlError, CycleAhead, CyclePlan, Event, FeedAhead, ProgramEnd, Programs, execute
from grind_env.control.block_words import Block
from grind_env.control.program_scanner import SourceText
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.machine.part.parts_under_stroke import sweep_between, sweep_of_plan
from grind_env.machine.program_run import GrindingRun

Words = Mapping[str, str]  #: numbers as written, by letter


@dataclass(frozen=True, slots=True, eq=False)
class BlockRun:
    """Run of a program from a cycle block to the next block or the end; the first run includes the beginning."""

    plan: CyclePlan  #: parameters of the cycle
    inch: bool  #: whether G70 is in force in its block
    part: int  #: number of its part, from 1
    strokes: Array  #: dtype `STROKE_ROW`, with the infeeds of grooves
    increments: Array  #: additional depth of each stroke over the stroke before it on its part, mm
    plunged: Array  #: whether each stroke is deeper than all before it at some place
    dresses: Array  #: dtype `DRESS_ROW`, but `after` counts `strokes` alone
    finished: Array  #: parts that were taken off the machine, dtype `PART_ROW`
    judged: bool  #: whether a stage of the part has ended, or the part
    deepest: float  #: depth to which the program has led on the part, mm
    seconds: float  #: time of this run, s


class Passage(NamedTuple):
    """A cycle block in the sequence of a program, which must not depend on choices."""

    source: SourceText
    part: int  #: number of the part, from 1
    finished: int  #: number of parts that are taken off before the next block


class PassageError(GrindError):
    """A program in which the sequence of cycle blocks or parts depends on the chosen words."""


class ProgramEpisode:
    """One execution of a part program.

    A copy, also by pickling, repeats the same choices.

    Args:
        programs: the program.
        job: the job.
        course: sequence of blocks of the unchanged program; empty if unknown.
    """

    def __init__(self, programs: Programs, job: Job, course: Sequence[Passage] = ()) -> None:
        """Start, and go on to the first cycle block."""
        self._arguments = (programs, job, course)
        self.course = course
        control = replace(job.control, announce_cycles=True, announce_feeds=True, whole_cycles=True)
        self.run = GrindingRun(programs, job, control)  # the machine
        self.chosen: list[tuple[Block, Words]] = []  # the finished blocks, with the chosen words
        self.block: Block | None = None  # the coming cycle block; None at the end of the program
        # time of the job up to which blocks have been run, s; the first step includes the way to its block
        self.time = 0.0
        self._execution = execute(programs, control)
        self.run.tell(self._execution)
        for _ in self._to_next_cycle():
            pass
        self.time = 0.0

    def __getstate__(self) -> dict[str, Any]:
        """Return the inputs and choices of the episode, because the execution itself cannot be copied."""
        return {"arguments": self._arguments, "words": [words for _, words in self.chosen]}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Run the copy up to where the original is."""
        ProgramEpisode.__init__(self, *state["arguments"])
        for words in state["words"]:
            self.step(words)

    def step(self, words: Words) -> BlockRun:
        """Run the coming cycle block with these words, and go on to the next cycle block."""
        run, began = self.run, self.time
        strokes, dresses, parts = len(run.strokes), len(run.dresses), len(run.parts)
        stages = len(run.part.ended) if run.unloaded_at is None else 0
        if not self.chosen:  # rows from the way to the first block belong to its step, as their time does
            strokes, dresses, parts = 0, 0, 0
        assert self.block is not None
        self.chosen.append((self.block, dict(words)))
        self._execution.choose(**words)
        plan, inch, part, begun = run.plan, False, 0, run.begun
        for _ in self._to_next_cycle():
            if not part and run.begun > begun:
                plan, inch, part = run.plan, self._execution.modes.inch, run.part.number
        assert plan is not None and part
        ended = len(run.parts) > parts
        if self.course:
            self._require(Passage(self.chosen[-1][0].source, part, len(run.parts) - parts))
        last = max(strokes - 1, 0)
        rows = run.strokes.table(last)
        dressed = run.dresses.table(dresses)
        dressed["after"] -= strokes
        return BlockRun(
            plan,
            inch,
            part,
            rows[strokes - last :],
            _increments(rows)[strokes - last :],
            np.frombuffer(run.plunged[strokes:], np.bool_),
            dressed,
            run.parts.table(parts),
            ended or len(run.part.ended) > stages,
            run.part.deepest,
            self.time - began,
        )

    def _require(self, passed: Passage) -> None:
        """Raise an error if the block differs from the course."""
        number, source = len(self.chosen), passed.source
        coming = None if self.block is None else self.block.source
        expected = self.course[number].source if number < len(self.course) else None
        if passed != self.course[number - 1] or coming != expected:
            raise PassageError(
                f"{source.file}:{source.line}: which cycle blocks the program runs behind this one, or on which parts, "
                "depends on the E and D chosen in it, such as by a # variable that a dress assigns; let it run the "
                "same ones whatever they are"
            )

    def rewind(self, blocks: int) -> None:
        """Run again from the beginning through the first `blocks` blocks."""
        state = self.__getstate__()
        self.__setstate__({**state, "words": state["words"][:blocks]})

    def _to_next_cycle(self) -> Iterator[Event]:
        """Yield the events up to the next cycle block or the end, each after the machine has executed it."""
        self.block = None
        for event in self._execution:
            if isinstance(event, CycleAhead) or (isinstance(event, FeedAhead) and self.run.is_feed_block(event)):
                if self._execution.table is None or self._execution.table.at_secondary:
                    self.run.take_pending_part_off()
                    self._expect(event)
                self.time, self.block = self.run.clock(event.time), event.block
                return
            self.run.take(event)
            if isinstance(event, ProgramEnd):  # the time after a trailing M00 belongs to no part
                assert self.run.unloaded_at is not None
                self.time = self.run.unloaded_at
            self.run.tell(self._execution)
            yield event

    def _expect(self, event: CycleAhead | FeedAhead) -> None:
        """Tell the machine the sweep of the coming block; a block that only chosen words make legal tells it itself."""
        run = self.run
        if not run.job.stations:
            return
        if isinstance(event, FeedAhead):
            run.expect(event.time, sweep_between(event.start, event.end, run.axis))
            return
        with suppress(ControlError):
            run.expect(event.time, sweep_of_plan(self._execution.planned(event.block), run.position))


def step_all(programs: Sequence[ProgramEpisode], words: Mapping[int, Words]) -> dict[int, BlockRun]:
    """Run the coming block of each program that has words in `words`; after an error, no program has moved.

    Returns:
        The run of each program, by its index.
    """
    before = {i: len(programs[i].chosen) for i in words}
    try:
        return {i: programs[i].step(numbers) for i, numbers in words.items()}
    except GrindError:
        for i, blocks in before.items():
            if len(programs[i].chosen) > blocks:
                programs[i].rewind(blocks)
        raise


def _increments(strokes: Array) -> Array:
    """Return the additional depth of each stroke over the stroke before it, mm; the first stroke counts from 0."""
    before = np.concatenate([[0.0], np.where(np.diff(strokes["part"]) == 0, strokes["Z"][:-1], 0.0)])
    return np.asarray(strokes["Z"] - before[: strokes.size])
