"""The effect of a dress program on the wheel, read from its motions.

A pass is a straight feed move along the cross axis that takes the diamond over the whole width of the wheel. Its infeed
is its depth below all passes before it. Before the first pass, where the wheel also comes down to the diamond, the
infeed is the last plunge move, which must be a separate feed move. A move without an infeed and with another feed, or
off the diamond, is the way back. If no pass has an infeed, the dresser advances by the infeed of the job.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from grind_env.control import Control, ControlError, Programs, dress_program_moves
from grind_env.control.block_words import read_block
from grind_env.control.events import Arc, Line, Motion, Position, Rapid, Source
from grind_env.control.modal_state import Modes
from grind_env.control.motion_paths import AXES
from grind_env.errors import GrindError
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.dress.wheel_geometry import over_diamond
from grind_env.machine.job import Job
from grind_env.message_text import listed

DEEPEST_INFEED = 0.1  #: deepest infeed of a pass, mm; a longer move is an approach (0.005 to 0.04 mm is usual)

ENDS = frozenset({("M", 2), ("M", 30), ("M", 99)})  #: words that end a program

USUAL_INFEED = 0.02  #: infeed of a dresser that advances by itself if the job gives none, mm

STEP = 1e-6  #: least difference of positions, mm; axes stand on multiples of 1000 times this, so that less is rounding


class DressProgramError(GrindError):
    """A dress program whose motions do not dress the wheel."""


class DressPlan(NamedTuple):
    """One execution of a dress program."""

    passes: int  #: passes of the diamond over the wheel
    feed: float  #: feed of the passes, mm/s; over the wheel's speed of rotation it is the dress lead
    depth: float  #: infeed of a pass, mm, mean over the passes
    seconds: float  #: time with approach, retrace and the job's set-up time, s

    def __str__(self) -> str:
        passes = "1 pass" if self.passes == 1 else f"{self.passes} passes"
        return f"{passes} of {self.depth:g} mm at {60.0 * self.feed:g} mm/min"


NO_DRESS = DressPlan(passes=0, feed=0.0, depth=0.0, seconds=0.0)  #: dress of a cycle without one


class DressRun(NamedTuple):
    """One execution of a dress program as it was run."""

    plan: DressPlan
    axis: int  #: number of the reciprocating axis
    motions: tuple[Motion, ...]  #: motions of the control, retrace included
    strokes: tuple[int, ...]  #: indices of the passes in `motions`
    control: Control  #: control with the tables that the program found
    modes: Modes | None  #: modes in force when the program began; None for those of power-up
    advances: bool  #: True if the dresser advances by itself, because no pass has an infeed


def run_dress(
    programs: Programs,
    number: int,
    job: Job,
    control: Control,
    position: Position,
    axis: int,
    modes: Modes | None = None,
) -> DressRun:
    """Measure a dress program by running it once by itself, at a position, mm, along a reciprocating axis.

    A `DressProgramError` is raised if the program does not exist or is faulty, has no traverse, dresses a form, or has
    passes with different feeds.
    """
    try:
        motions = dress_program_moves(programs, number, control, position, modes)
    except ControlError as error:
        raise _error(number, f"it fails: {error}") from None
    return measure_dress(motions, number, job, axis, control, modes)


def plain_calls(programs: Programs, *, block_delete: bool = False) -> Iterator[tuple[int | None, int, int]]:
    """Yield each call by M98: O number of the caller, line, and O number of the called program.

    The caller is None for a main program without a number, and the line 0 in another file than the main program's. A
    program is read up to the first block that ends it; with `block_delete` blocks that begin with '/' are left out.
    """
    for program in programs:
        for source in program.blocks:
            if "M" not in source.text.upper() or (block_delete and source.deletable):
                continue
            try:
                words = {(word.letter, int(word.whole)) for word in read_block(source).words if word.whole}
            except ControlError:  # never executed, or the run had ended there
                continue
            if ("M", 98) in words:
                line = source.line if source.file == programs.name else 0
                yield from ((program.number, line, number) for letter, number in words if letter == "P")
            if not words.isdisjoint(ENDS):
                break


def measure_dress(
    motions: Sequence[Motion], number: int, job: Job, axis: int, control: Control, modes: Modes | None
) -> DressRun:
    """Return the effect of the motions of one execution; arguments and errors as for `run_dress`."""
    cross, plunge = cross_axis(axis), plunge_axis(axis)
    width = job.setup.wheel.width
    out = [motion for motion in motions if motion.source is not Source.RETRACE]
    passes = [
        k
        for k, motion in enumerate(out)
        if isinstance(motion, Line)
        and abs(_way(motion, cross)) >= width - STEP
        and math.dist(motion.start, motion.end) <= abs(_way(motion, cross)) + STEP
    ]
    traverses = [motion for motion in (out[k] for k in passes) if isinstance(motion, Line)]
    begun = next((k for k, motion in enumerate(out) if k in passes or _is_infeed(motion, cross, plunge)), 0)
    dressing = out[begun : passes[-1]] if passes else out[begun:]
    formed = next((motion for motion in dressing if _is_formed(motion, cross, plunge)), None)
    formed = formed or _step_of_form(dressing, cross, plunge, width)
    if formed is not None:
        raise _form_error(formed, number, cross, plunge)
    if not traverses:
        raise _error(
            number, f"no feed move takes the diamond over the wheel; add one of {width:g} mm along {AXES[cross]}"
        )
    places = [traverse.end[plunge] for traverse in traverses]
    first = _first_infeed(out[: passes[0]], plunge, number, alone=max(places) - min(places) < STEP)
    sunk = first if abs(first) >= STEP else places[-1] - places[0]
    towards = math.copysign(1.0, sunk)
    leaving = itertools.takewhile(lambda motion: isinstance(motion, Line | Arc), out[passes[-1] + 1 :])
    for motion in leaving if abs(sunk) >= STEP else ():
        if _is_formed(motion, cross, plunge) and towards * _way(motion, plunge) > -STEP:
            raise _form_error(motion, number, cross, plunge)
    depths = [towards * place for place in places]
    before = list(itertools.accumulate(depths, max))  # the deepest pass up to each
    infeeds = [abs(first), *(after - old for old, after in itertools.pairwise(before))]
    at_work = [
        k
        for k, (infeed, traverse) in enumerate(zip(infeeds, traverses, strict=True))
        if infeed >= STEP or (depths[k] > before[k] - STEP and traverse.feed == traverses[0].feed)
    ]
    passes, traverses, infeeds = (
        [passes[k] for k in at_work],
        [traverses[k] for k in at_work],
        [infeeds[k] for k in at_work],
    )
    feeds = sorted({traverse.feed for traverse in traverses})
    if len(feeds) > 1:
        found = listed([f"F{feed:g}" for feed in feeds])
        raise _error(number, f"its passes run at {found} mm/min; give all of them the same feed")
    for k, infeed in enumerate(infeeds, 1):
        if infeed > DEEPEST_INFEED + STEP:
            raise _error(
                number,
                f"the wheel moves {infeed:g} mm along {AXES[plunge]} before pass {k}, but an infeed is "
                f"at most {DEEPEST_INFEED:g} mm; approach first, then infeed in a block of its own",
            )
    depth = sum(infeeds) / len(traverses)
    advances = depth < STEP
    if advances:
        depth = job.setup.dresser_infeed or USUAL_INFEED
    seconds = motions[-1].finish - motions[0].begin + job.times.dress_setup
    plan = DressPlan(len(traverses), feeds[0] / 60.0, depth, seconds)
    return DressRun(plan, axis, tuple(motions), tuple(passes), control, modes, advances)


def missed_pass(run: DressRun, tip: Position, radius: float, width: float) -> Motion | None:
    """Return the first pass of a dress that leaves some of the wheel undressed by the diamond; None if none does."""
    for motion in (run.motions[k] for k in run.strokes):
        depth, passed = over_diamond(tip, motion, run.axis, radius, width)
        if depth <= 0.0 or passed < width - STEP:
            return motion
    return None


def is_same(plan: DressPlan, other: DressPlan) -> bool:
    """Return whether two dresses are equal except for their times."""
    same = math.isclose(plan.feed, other.feed) and math.isclose(plan.depth, other.depth)
    return plan.passes == other.passes and same


def require_same(found: DressPlan, plan: DressPlan, number: int) -> None:
    """Refuse a dress program with another effect in the cycle than by itself; the modes then differ."""
    if not is_same(found, plan):
        raise _error(
            number,
            f"it makes {found} when the cycle calls it, but {plan} where the cycle begins; "
            "let it set G70 or G71, G90 or G91, G94 and F, and go to the diamond, before it infeeds",
        )


def _is_infeed(motion: Motion, cross: int, plunge: int) -> bool:
    way = abs(_way(motion, plunge))
    return isinstance(motion, Line) and STEP <= way <= DEEPEST_INFEED + STEP and abs(_way(motion, cross)) < STEP


def _is_formed(motion: Motion, cross: int, plunge: int) -> bool:
    """Return whether a motion leads the diamond across the wheel and into it at once, along a form."""
    if isinstance(motion, Arc):
        return True
    both = min(abs(_way(motion, cross)), abs(_way(motion, plunge)))
    return isinstance(motion, Line) and both > STEP


def _step_of_form(dressing: Sequence[Motion], cross: int, plunge: int, width: float) -> Motion | None:
    """Return the first motion that continues over the wheel at another depth, as a form in steps; None if none does.

    Neither motion takes the diamond over the whole wheel.
    """
    before: Motion | None = None
    for motion in dressing:
        way = _way(motion, cross)
        if not isinstance(motion, Line) or abs(way) >= width - STEP:
            before = None
        elif abs(way) >= STEP:
            if (
                before is not None
                and way * _way(before, cross) > 0.0
                and abs(motion.start[plunge] - before.end[plunge]) >= STEP
            ):
                return motion
            before = motion
    return None


def _form_error(formed: Motion, number: int, cross: int, plunge: int) -> DressProgramError:
    return _error(
        number,
        f"form dressing is not simulated, but line {formed.line} leads the diamond along a form; in a copy of the "
        f"program for the simulation dress with feed moves along {AXES[cross]} and {AXES[plunge]}, one at a time, at "
        "the feed and infeed of the form: it then grinds with a cylinder that is dressed alike",
    )


def _first_infeed(approach: Sequence[Motion], plunge: int, number: int, *, alone: bool) -> float:
    """Return the signed infeed before the first pass, mm; with `alone` no pass has an infeed, and 0 is legal."""
    moved = next((motion for motion in reversed(approach) if abs(_way(motion, plunge)) >= STEP), None)
    if moved is None:
        return 0.0
    way = _way(moved, plunge)
    if not isinstance(moved, Rapid) and math.dist(moved.start, moved.end) <= abs(way) + STEP:
        return way
    if alone:
        return 0.0
    raise _error(
        number,
        f"its first pass has no infeed of its own: the last move of {AXES[plunge]} before it is part of the "
        f"approach in line {moved.line}; infeed with a G01 that moves {AXES[plunge]} alone, by some 0.02 mm",
    )


def _way(motion: Motion, axis: int) -> float:
    return motion.end[axis] - motion.start[axis]


def _error(number: int, message: str) -> DressProgramError:
    return DressProgramError(f"dress program O{number}: {message}")
