"""Variables of a program: words of its cycle blocks and values of its dress programs, with legal ranges."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control import Programs
from grind_env.control.cycles import list_codes
from grind_env.control.motion_paths import INTEGRANDS
from grind_env.control.numbers import MILLIMETRES_PER_INCH
from grind_env.control.program_scanner import SourceText
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import BlockOutline
from grind_env.envs.job.repeated_program import jumps
from grind_env.envs.tasks.tables import USUAL_SPEEDS
from grind_env.machine.dress.dress_run import DEEPEST_INFEED
from grind_env.machine.part.feed_moves import FEED_WORD, speed_word
from grind_env.machine.script import block_settings
from grind_env.message_text import listed
from grind_env.shop.dress_interval import LONGEST, DressInterval, intervals_between
from grind_env.shop.optimise.dress_program_editing import DressText, DressTextError, dress_text
from grind_env.shop.optimise.word_editing import Assignments, ProgramText, Spot, number_text, variable_of, word_of
from grind_env.shop.search_options import INTERVAL, OptionError, SearchOptions, whole_ends_of

#: column of `BlockSettings` of each value that can be varied
COLUMNS = {
    "E": block_settings.E,
    "D": block_settings.D,
    "J": block_settings.J,
    "L": block_settings.L,
    "passes": block_settings.DRESS_PASSES,
    "lead": block_settings.DRESS_FEED,
    "depth": block_settings.DRESS_DEPTH,
}
IN_SCRIPTS = ("J", "L", "lead", "depth", "passes")  #: values that can be varied only if the program has a script
#: words that a block takes over from the block before (16-13); E is F of a feed move that is a stroke
INHERITED = ("E", "J")

ONE = MILLIMETRE = Decimal(1)
WHOLE = {"D": (0, 3), "L": (0, 8), "passes": (1, 4)}  #: default ranges of whole values
WIDTH = Decimal("2.5")  #: picks, leads and depths are tried up to this factor above and below the program's own
#: steps of values, metric and in inches; of a lead the steps of its F
STEPS = {
    "E": (Decimal(100), Decimal(5)),
    "J": (Decimal(".001"), Decimal(".0001")),
    "lead": (Decimal(1), Decimal(".1")),
    "depth": (Decimal(".001"), Decimal(".0001")),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchVariable:
    """Value that a search may change."""

    name: str  #: one of `VARIED`, except the interval
    place: str  #: its block or program, as tables show it
    blocks: tuple[int, ...]  #: numbers of the cycle blocks of one run to which it applies
    own: Decimal  #: programmed value, in the units of the program; of a lead the F of the passes
    levels: tuple[Decimal, ...]  #: values to try, ascending, in the same units
    unit: Decimal  #: unit of the values, mm
    at: Spot | DressText  #: place in the text: a word of a cycle block, or a dress program
    # the same word in equal blocks of other parts; their blocks are among `blocks`
    twins: tuple["SearchVariable", ...] = ()

    @property
    def places(self) -> str:
        """Return all blocks or programs that contain the value, as text for tables."""
        return ", ".join(each.place for each in (self, *self.twins))

    @property
    def settings(self) -> NDArray[np.float64]:
        """Return the levels in the units of `BlockSettings`."""
        values = [float(level * self.unit) for level in self.levels]
        if isinstance(self.at, DressText):
            values = [self.at.setting(self.name, value) for value in values]
        return np.array(values)

    @property
    def start(self) -> int:
        """Number of the level nearest to the programmed value."""
        return self.nearest(self.own)

    def nearest(self, value: Decimal) -> int:
        return min(range(len(self.levels)), key=lambda k: abs(self.levels[k] - value))


class SearchSpace(NamedTuple):
    """Variables, and sentences on words that cannot be varied."""

    variables: tuple[SearchVariable, ...]  #: variables of words and dress programs
    # possible dress intervals of blocks with D words; only every part if there is no choice
    intervals: tuple[DressInterval, ...]
    remarks: tuple[str, ...]  #: sentences on words that cannot be varied


def choices_of(
    simulation: JobSimulation, text: ProgramText, options: SearchOptions, runs: int, *, of_all: bool = False
) -> SearchSpace:
    """Return the search space of a program; `of_all`: whether the simulation has the blocks of all runs."""
    blocks, remarks = simulation.blocks, []
    labels = {block.block.place.block for block in blocks}
    for label in sorted(options.fixed - labels):
        known = listed([f"N{each}" for each in sorted(labels)])
        raise OptionError(f"--fix: N{label} is no cycle block of {simulation.programs.name}; there are {known}")
    names = tuple(name for name in options.words if name != INTERVAL)
    if simulation.script is None:
        names = tuple(name for name in names if name not in IN_SCRIPTS)
        remarks.append(f"E and D alone are varied, and few programs can be tried: {simulation.why}")
    assignments = Assignments(simulation.programs, simulation.job.variables)
    found: list[SearchVariable] = []
    for name in names:
        if name in ("E", "D", "J", "L"):
            found += _words(name, simulation, options, assignments, remarks)
        else:
            found += _dresses(name, simulation, text, options, remarks)
    intervals: tuple[DressInterval, ...] = (DressInterval(1),)
    if INTERVAL in options.words:
        if "D" not in names:
            words = _words("D", simulation, options, assignments, remarks)
            found += [replace(each, levels=(each.own,)) for each in words if each.own]
        dressing = [each for each in found if each.name == "D"]
        parts = simulation.parts // runs if of_all else simulation.parts
        # lines before each dressing block count the blocks: impossible if a jump may skip these lines
        counted = not (of_all or any(jumps(block) for program in simulation.programs for block in program.blocks))
        intervals = _intervals(dressing, options, runs, parts, counted=counted)
    several = intervals[-1].every > 1
    varied = [each for each in found if each.levels != (each.own,) or (each.name == "D" and several)]
    if not varied:
        lacks = f"; it has no word {' or '.join(names)} in a {list_codes('or')}; --vary adds words that a block lacks"
        why = f": {remarks[0]}" if remarks else lacks
        raise OptionError(f"{simulation.programs.name} has nothing to vary{why}")
    return SearchSpace(tuple(varied), intervals, tuple(dict.fromkeys(remarks)))


def _intervals(
    dressing: Sequence[SearchVariable], options: SearchOptions, runs: int, parts: int, *, counted: bool
) -> tuple[DressInterval, ...]:
    """Return the possible dress intervals of blocks with these D words."""
    low, high = whole_ends_of("--bounds", INTERVAL, options.bounds.get(INTERVAL, (1, max(min(LONGEST, runs), 1))))
    if not 1 <= low <= high <= max(runs, 1):
        raise OptionError(
            f"--bounds: a dress every {low} to {high} parts; it may be from 1 to --parts, which is {runs}"
        )
    if not dressing:
        return (DressInterval(1),)
    counted &= all(isinstance(each.at, Spot) and each.at.variable is None for each in dressing)
    blocks = sum(len(each.blocks) for each in dressing) if counted else 1
    return intervals_between(low, high, blocks=blocks, parts=parts)


def _words(
    name: str, simulation: JobSimulation, options: SearchOptions, assignments: Assignments, remarks: list[str]
) -> Iterator[SearchVariable]:
    """Yield the words of cycle blocks; one word applies to all runs of its block, and to blocks that take it over.

    If words read a # variable, its number applies to all these words.
    """
    assigned = _assigned(name, simulation.blocks, options, assignments)
    blocks: dict[tuple[int, int], list[int]] = {}
    spots: dict[tuple[int, int], tuple[Spot, int]] = {}
    governing: dict[str, tuple[int, int] | None] = {}
    for number, outline in enumerate(simulation.blocks):
        source, letter = outline.block.source, _letter(name, outline)
        if letter is None:
            continue
        word = word_of(source, letter)
        at = assigned.get((variable_of(word), source))
        place = (at.source.line, at.source.column) if isinstance(at, Spot) else (source.line, source.column)
        usable = isinstance(at, Spot) or _usable(letter, outline, simulation.programs, options, remarks, at)
        if word is None and not (options.add and usable and (name != "D" or outline.takes_dresses)):
            before = governing.get(letter)
            # the F in force may come from another feed move
            if name in INHERITED and before is not None:
                feed = simulation.blocks[blocks[before][-1]].plan.feed
                if letter != FEED_WORD or feed == outline.plan.feed:
                    blocks[before].append(number)
            continue
        governing[letter] = place if usable else None
        if usable:
            blocks.setdefault(place, []).append(number)
            if not isinstance(at, Spot):
                sign = "-" if name == "J" and outline.plan.depth_target < outline.plan.plunge_start else ""
                new = f"{sign}." if name in INHERITED else ""  # form of the number of a new word
                form = new if word is None else number_text(source, word)
                at = Spot(source, letter, form, word is None)
            spots[place] = at, number
    for place, (spot, number) in spots.items():
        outline = simulation.blocks[number]
        unit = MILLIMETRES_PER_INCH if outline.inch and name in ("E", "J") else MILLIMETRE
        own = _own(name, outline, spot, unit)
        yield SearchVariable(
            name=name,
            place=_place(outline, simulation.blocks) if spot.variable is None else spot.place,
            blocks=tuple(blocks[place]),
            own=own,
            levels=_levels(name, own, unit, options, simulation, _fastest(simulation, blocks[place])),
            unit=unit,
            at=spot,
        )


def _letter(name: str, outline: BlockOutline) -> str | None:
    """Return the letter of a word in a block, F for E in a feed move; None if the block takes no such word."""
    plan = outline.plan
    if name == "E":
        return speed_word(plan)
    if plan.plunge_axis is None or (name == "D" and not outline.takes_dresses):
        return None
    return INTEGRANDS[plan.plunge_axis] if name == "J" else name


def _assigned(
    name: str, blocks: Sequence[BlockOutline], options: SearchOptions, assignments: Assignments
) -> dict[tuple[int | None, SourceText], Spot | str]:
    """Return the place of the number of each # variable that these words read, or how the user can add one."""
    readers: dict[tuple[int, SourceText | None], list[BlockOutline]] = {}
    for outline in blocks:
        letter = _letter(name, outline)
        read = variable_of(word_of(outline.block.source, letter)) if letter else None
        if read is not None:
            readers.setdefault((read, assignments.place(read, outline.block.source)), []).append(outline)
    found: dict[tuple[int | None, SourceText], Spot | str] = {}
    for (variable, _), outlines in readers.items():
        sources = [each.block.source for each in outlines]
        kept = next((_label(each) for each in outlines if each.block.place.block in options.fixed), None)
        if kept is not None:
            at: Spot | str = f"give it a variable of its own, for {kept}, which is kept, reads this one, too"
        elif len({each.inch for each in outlines}) > 1:
            at = "give it a variable of its own, for this one is read in inches and in millimetres"
        else:
            letter = _letter(name, outlines[0]) or name
            at = assignments.spot(variable, letter, sources)
        found |= {(variable, source): at for source in sources}
    return found


def _usable(
    letter: str,
    outline: BlockOutline,
    programs: Programs,
    options: SearchOptions,
    remarks: list[str],
    remedy: str | None,
) -> bool:
    """Return whether a word may be changed; if not, a remark says why, with the remedy."""
    source, label = outline.block.source, _label(outline)
    if outline.block.place.block in options.fixed:
        return False
    if source.file != programs.name:
        remarks.append(f"{label} stands in {source.file} and is kept as it is; put its program into {programs.name}")
        return False
    expression = next((each.expression for each in outline.block.words if each.letter == letter), "")
    if expression:
        remarks.append(
            f"{label}: {letter}{expression.strip()} is kept as it is; write a number there, or "
            f"{remedy or 'change what is assigned'}"
        )
        return False
    return True


def _own(name: str, outline: BlockOutline, spot: Spot, unit: Decimal) -> Decimal:
    if not spot.missing:
        return abs(Decimal("".join(spot.form.split())))
    plan = outline.plan
    value = {"E": plan.feed, "D": plan.dresses, "J": plan.primary_pick, "L": plan.spark_out}[name]
    return Decimal(str(value)) / unit if unit == MILLIMETRE else round(Decimal(str(value)) / unit, 4)


def _dresses(
    name: str, simulation: JobSimulation, text: ProgramText, options: SearchOptions, remarks: list[str]
) -> Iterator[SearchVariable]:
    """Yield lead, depth or passes of the dress programs as variables."""
    programs: dict[int, list[int]] = {}
    for number, outline in enumerate(simulation.blocks):
        if outline.plan.program is not None and outline.dress is not None:
            programs.setdefault(outline.plan.program, []).append(number)
    assert simulation.script is not None
    for program, blocks in programs.items():
        run = simulation.script.blocks[blocks[0]].dress
        assert run is not None
        try:
            at = dress_text(simulation, text, program, run)
            own, unit = at.own(name), MILLIMETRE if name == "passes" else at.unit
            levels = at.writable(name, _levels(name, own, unit, options, simulation))
        except DressTextError as error:
            remarks.append(f"{name} of O{program} is kept as it is: {error}")
            continue
        yield SearchVariable(
            name=name, place=f"O{program}", blocks=tuple(blocks), own=own, levels=levels, unit=unit, at=at
        )


def _levels(
    name: str, own: Decimal, unit: Decimal, options: SearchOptions, simulation: JobSimulation, fastest: float = math.inf
) -> tuple[Decimal, ...]:
    """Return the values to try: multiples of the step between the bounds, and the programmed value if it is legal."""
    inch = unit != MILLIMETRE
    turns = Decimal(str(round(60.0 * simulation.task.wheel_revolutions, 6))) if name == "lead" else ONE
    step = STEPS.get(name, (ONE, ONE))[inch]
    low, high = _usual_bounds(name, own, unit, fastest)
    if name in options.bounds:
        low, high = (bound * turns for bound in options.bounds[name])
        _refuse_bounds(name, high, unit, simulation)
    first = (low / step).to_integral_value(ROUND_CEILING)
    last = (high / step).to_integral_value(ROUND_FLOOR)
    values = {k * step for k in map(Decimal, range(int(first), int(last) + 1))}
    least = 0 if name in ("D", "L") else step.min(own)
    values = {value for value in values if value >= least}
    if low <= own <= high:
        values.add(own)
    if not values:
        raise OptionError(f"no multiple of {step:f} lies in the bounds of {name}, {low:f} to {high:f}; widen --bounds")
    return tuple(sorted(values))


def _fastest(simulation: JobSimulation, blocks: Sequence[int]) -> float:
    """Return the highest table speed in some blocks, mm/min, as machine and acceleration allow it."""
    machine, control = simulation.job.setup.machine, simulation.job.control
    plans = [simulation.blocks[number].plan for number in blocks]
    way = min(abs(plan.primary - plan.secondary) for plan in plans)
    return min(machine.maximum_table_speed, 60.0 * math.sqrt(control.acceleration * way))


def _usual_bounds(name: str, own: Decimal, unit: Decimal, fastest: float) -> tuple[Decimal, Decimal]:
    if name in WHOLE:
        low, high = map(Decimal, WHOLE[name])
        return min(low, own), max(high, own)
    if name == "E":
        return min(Decimal(USUAL_SPEEDS[0]) / unit, own), max(Decimal(min(USUAL_SPEEDS[1], fastest)) / unit, own)
    low, high = own / WIDTH, own * WIDTH
    return low, max(own, min(high, Decimal(str(DEEPEST_INFEED)) / unit)) if name == "depth" else high


def _refuse_bounds(name: str, high: Decimal, unit: Decimal, simulation: JobSimulation) -> None:
    """Refuse bounds beyond the legal values of machine or control."""
    machine = simulation.job.setup.machine
    most = {"E": machine.maximum_table_speed, "D": 999.0, "L": 999.0, "passes": 99.0, "depth": DEEPEST_INFEED}
    limit = most.get(name, math.inf)
    if float(high * unit) > limit:
        raise OptionError(f"--bounds: {name} goes up to {high:f}, but {Decimal(limit) / unit:.6g} is the most here")


def _place(outline: BlockOutline, blocks: Sequence[BlockOutline]) -> str:
    """Return the label of a block, with its line if blocks in other lines have the same label."""
    same = {each.block.source.line for each in blocks if _label(each) == _label(outline)}
    return f"{_label(outline)}, line {outline.block.source.line}" if len(same) > 1 else _label(outline)


def _label(outline: BlockOutline) -> str:
    place = outline.block.place
    labelled = outline.block.source.text.lstrip("/").lstrip().upper().startswith("N")
    return f"N{place.block}" if labelled else f"line {place.line}"


def join_equal(variables: Iterable[SearchVariable], simulation: JobSimulation) -> tuple[SearchVariable, ...]:
    """Join the variables of the same word in equal blocks of different parts.

    Blocks are equal if they have the same place in the order of their part, the same strokes, depth and words, and
    parts with the same limits.
    """
    kinds = _kinds(simulation)
    found: dict[tuple[object, ...], SearchVariable] = {}
    for each in variables:
        # variables of two dress programs are never joined
        place = "" if isinstance(each.at, Spot) else each.place
        alike = place, each.name, each.own, each.unit, each.levels, frozenset(kinds[number] for number in each.blocks)
        first = found.get(alike)
        found[alike] = (
            each if first is None else replace(first, blocks=(*first.blocks, *each.blocks), twins=(*first.twins, each))
        )
    return tuple(found.values())


def _kinds(simulation: JobSimulation) -> list[tuple[object, ...]]:
    """Return for each block its number within its part, its strokes, its words, and its part without the position."""
    count: dict[int, int] = {}
    kinds: list[tuple[object, ...]] = []
    for block in simulation.blocks:
        number = count[block.part] = count.get(block.part, 0) + 1
        plan, job = block.plan, simulation.job.of_part(block.part + 1)
        depth = round(abs(plan.depth_target - plan.plunge_start), 6)
        strokes = plan.code, round(abs(plan.primary - plan.secondary), 6), depth, round(block.depth, 6), plan.spark_out
        said = plan.feed, plan.dresses, plan.primary_pick, plan.secondary_pick
        kinds.append((number, strokes, said, replace(job.part, start=0.0, across=0.0, surface=0.0)))
    return kinds
