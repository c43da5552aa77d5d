"""Lead, depth and passes in the text of a dress program: F, infeed words, and the number of passes.

The effect of an edit is always measured on the edited text (`dress.dress_run`). A change that other numbers in
its words cannot express is refused.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import pairwise

from grind_env.control import ControlError, read
from grind_env.control.block_words import Word
from grind_env.control.motion_paths import AXES
from grind_env.control.numbers import MILLIMETRES_PER_INCH
from grind_env.control.program_scanner import SourceText
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.errors import GrindError
from grind_env.machine.axis_roles import plunge_axis
from grind_env.machine.dress.dress_run import STEP, DressProgramError, DressRun, run_dress
from grind_env.shop.optimise.word_editing import (
    ProgramText,
    WordEdit,
    comment_edit,
    like,
    number_text,
    other_number,
    word_of,
)

_same = partial(math.isclose, rel_tol=1e-6)  #: function that compares two values of words up to rounding


class DressTextError(GrindError):
    """Change of a dress program that other numbers in its words cannot express."""


@dataclass(frozen=True, slots=True, eq=False)
class DressText:
    """Text of a dress program."""

    simulation: JobSimulation  #: simulation of the program that it belongs to
    text: ProgramText  #: text of the file
    number: int  #: its O number
    run: DressRun  #: one execution
    sources: Sequence[SourceText]  #: its blocks
    feeds: Sequence[tuple[SourceText, Word]]  #: F words of the passes with their blocks
    # infeed words with their blocks and infeeds, mm, in the order of the passes; empty if the dresser itself advances
    infeeds: Sequence[tuple[SourceText, Word, float]]
    unit: Decimal  #: unit of its words, mm

    def own(self, name: str) -> Decimal:
        """Return the written lead, depth or passes, in the units of the program."""
        if name == "passes":
            return Decimal(self.run.plan.passes)
        if name == "lead":
            return _number(*self.feeds[0])
        depths = {round(abs(way), 6) for *_, way in self.infeeds}
        if not depths:
            raise DressTextError("it has no infeed, for its dresser advances by itself")
        if len(depths) != 1:
            raise DressTextError("its infeeds differ; give all passes the same")
        return (Decimal(str(depths.pop())) / self.unit).quantize(Decimal("0.00001")).normalize()

    def setting(self, name: str, value: float) -> float:
        """Return a value in units of `BlockSettings`: feed (lead) in mm/s, mean infeed (depth) in mm, or passes."""
        if name == "lead":
            return value / 60.0
        return value * len(self.infeeds) / self.run.plan.passes if name == "depth" else value

    def writable(self, name: str, levels: Sequence[Decimal]) -> tuple[Decimal, ...]:
        """Return the levels that the program can express."""
        if name == "passes":
            return tuple(level for level in levels if self._says(name, level))
        other = next((level for level in levels if level != self.own(name)), None)
        if other is not None and not self._says(name, other):
            raise DressTextError("other numbers in its words do not change it alone; write its passes out one by one")
        return tuple(levels)

    def changes(self, name: str, level: Decimal) -> list[WordEdit]:
        """Return the edits that change lead or depth to a level."""
        if name == "lead":
            return [other_number(source, word, like(level, number_text(source, word))) for source, word in self.feeds]
        for absolute in (False, True):
            changes = self._deeper(level, absolute=absolute)
            if self._comes_to("depth", level, self.text.changed(changes)):
                return changes
        raise DressTextError(f"an infeed of {level:f} cannot be written into O{self.number}")

    def with_passes(self, text: ProgramText, passes: Decimal) -> ProgramText:
        """Return the text with another number of passes: the last passes are left out, or the last two are repeated."""
        ends = [self.run.motions[k].line for k in self.run.strokes]
        count, own, lines = int(passes), len(ends), text.lines
        if len(set(ends)) < own:
            raise DressTextError("its passes stand in one block; write them out one by one")
        said = f"PASSES {own} TO {count}"
        comments = text.edited([comment_edit(_last(self.sources, ends[min(count, own) - 1], text), said)]).lines
        if count <= own:
            lines = (*comments[: ends[count - 1]], *comments[ends[-1] :])
        elif own < 2 or (count - own) % 2:
            raise DressTextError(f"{count} passes do not end where {own} do")
        else:
            # with two passes the first one is repeated with its infeed, which may stand before it
            begin = ends[-3] if own > 2 else min([ends[0], *(source.line for source, *_ in self.infeeds)]) - 1
            again = lines[begin : ends[-1]] * ((count - own) // 2)
            lines = (*comments[: ends[-1]], *again, *comments[ends[-1] :])
        return ProgramText(text.encoding, text.mark, lines)

    def _deeper(self, level: Decimal, *, absolute: bool) -> list[WordEdit]:
        """Return edits of the infeed words as increments, or as coordinates, each shifted by all infeeds before."""
        changes, shift = [], Decimal(0)
        for source, word, way in self.infeeds:
            deeper = (level - self.own("depth")).copy_sign(1) * (1 if (level > self.own("depth")) == (way > 0) else -1)
            shift = shift + deeper if absolute else deeper
            old = number_text(source, word)
            value = _number(source, word) + shift
            signed = old if (value < 0) == ("-" in old) else f"{'-' if value < 0 else ''}{old.strip('+- ')}"
            changes.append(other_number(source, word, like(abs(value), signed)))
        return changes

    def _says(self, name: str, level: Decimal) -> bool:
        try:
            if name == "passes":
                text = self.text if level == self.own(name) else self.with_passes(self.text, level)
            else:
                text = self.text.changed(self.changes(name, level))
        except DressTextError:
            return False
        return self._comes_to(name, level, text)

    def _comes_to(self, name: str, level: Decimal, text: ProgramText) -> bool:
        """Return whether a text dresses with the new lead, depth or passes, and otherwise as before."""
        simulation, old, run = self.simulation, self.run.plan, self.run
        programs = read(text.text, simulation.programs.name, simulation.programs.folder)
        begin = run.motions[0].start
        try:
            changed = run_dress(programs, self.number, simulation.job, run.control, begin, run.axis, run.modes)
        except (ControlError, DressProgramError):
            return False
        new = changed.plan
        if not _goes_on(changed) and _goes_on(run):
            return False
        value = self.setting(name, float(level * (self.unit if name != "passes" else 1)))
        passes = int(value) if name == "passes" else old.passes
        feed = value if name == "lead" else old.feed
        depth = value if name == "depth" else old.depth
        return new.passes == passes and _same(new.feed, feed) and _same(new.depth, depth)


def _goes_on(run: DressRun) -> bool:
    """Return whether every pass is deeper than the one before; an infeed may include a retract and return."""
    depths = [run.motions[k].start[plunge_axis(run.axis)] for k in run.strokes]
    steps = [after - before for before, after in pairwise(depths)]
    return all(step < 0.0 for step in steps) or all(step > 0.0 for step in steps)


def dress_text(simulation: JobSimulation, text: ProgramText, number: int, run: DressRun) -> DressText:
    """Return the text of a dress program."""
    programs = simulation.programs
    program = programs.find(number)
    if program is None or program.place.file != programs.name:
        raise DressTextError(f"it stands in another file than {programs.name}; put it into that")
    sources = list(program.blocks)
    feeds: list[tuple[SourceText, Word]] = []
    infeeds: list[tuple[SourceText, Word, float]] = []
    plunge = plunge_axis(run.axis)
    before = 0
    for stroke in run.strokes:
        feeds.append(_feed_word(sources, run.motions[stroke].line))
        moves = [
            motion for motion in run.motions[before:stroke] if abs(motion.end[plunge] - motion.start[plunge]) >= STEP
        ]
        if moves and not run.advances:
            last = moves[-1]
            way = sum(motion.end[plunge] - motion.start[plunge] for motion in (moves if before else moves[-1:]))
            infeeds.append((*_plain(sources, last.line, AXES[plunge]), way))
        before = stroke + 1
    feed = 60.0 * run.plan.feed
    inch = not _same(float(_number(*feeds[0])), feed)
    unit = MILLIMETRES_PER_INCH if inch else Decimal(1)
    return DressText(simulation, text, number, run, sources, list(dict.fromkeys(feeds)), infeeds, unit)


def _feed_word(sources: Sequence[SourceText], line: int) -> tuple[SourceText, Word]:
    for source in reversed([each for each in sources if each.line <= line]):
        if word_of(source, "F") is not None:
            return _plain([source], source.line, "F")
    raise DressTextError("its passes have no F of their own; write one there")


def _plain(sources: Sequence[SourceText], line: int, letter: str) -> tuple[SourceText, Word]:
    for source in sources:
        word = word_of(source, letter) if source.line == line else None
        if word is not None and not word.expression:
            return source, word
    raise DressTextError(f"line {line} has no plain number of {letter}; write one there")


def _number(source: SourceText, word: Word) -> Decimal:
    return Decimal("".join(number_text(source, word).split()))


def _last(sources: Sequence[SourceText], line: int, text: ProgramText) -> SourceText:
    """Return the last block of a line in another text with the same lines."""
    source = [each for each in sources if each.line == line][-1]
    now = text.lines[line - 1].rstrip("\r\n")
    return source._replace(text=now[source.column - 1 :].rstrip(" \t"))
