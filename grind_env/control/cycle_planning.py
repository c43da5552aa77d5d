"""Plan of a cycle block, with defaults from the program-modal memory (tables 16.A to 16.C)."""

from dataclasses import dataclass, replace

from grind_env.control import numbers
from grind_env.control.block_decoding import Command
from grind_env.control.cycles import RULES, Rules
from grind_env.control.errors import ControlError
from grind_env.control.events import CyclePlan, Position
from grind_env.control.modes import PLANES
from grind_env.control.motion_paths import AXES, INTEGRANDS, coordinate, displaced
from grind_env.control.program_reader import HIGHEST_PROGRAM
from grind_env.control.reciprocation import Reciprocation

MOST = 999  #: highest D and L

WORDS = {"G81": "", "G82": "QLD", "G83": "QLDR"}  #: letters of each cycle besides P and the letters of its axes


@dataclass(frozen=True, slots=True)
class ModalWords:
    """Words that later cycle blocks may omit, per role and not per letter (ruling 5), in program coordinates.

    Picks are signed; all lengths are mm.
    """

    axis: int | None = None
    primary: float | None = None
    secondary: float | None = None
    depth_target: float | None = None
    primary_pick: float | None = None
    cross_end: float | None = None
    primary_cross_pick: float | None = None
    feed: float | None = None
    program: int | None = None


@dataclass(frozen=True, slots=True)
class Situation:
    """Context of a cycle block besides its words, mm in program coordinates and mm/min."""

    position: Position
    reciprocating: int | None  #: the axis that reciprocates; None if none does
    secondary: float  #: secondary reversal point of that axis in force
    maximum_feed: float


def plan_cycle(command: Command, memory: ModalWords, situation: Situation) -> tuple[CyclePlan, ModalWords]:
    """Return the plan of a cycle block in coordinates of the program, and the words that later blocks may omit."""
    code, _, pre_dress = command.action.partition(".")
    rules = RULES[code]
    if command.modes.per_revolution:
        raise command.error("feed-mode", f"{code} is programmed under G95; grinding cycles need G94")
    axis = _reciprocating_axis(command, memory, rules)
    if situation.reciprocating not in (None, axis):
        other = AXES[situation.reciprocating or 0]
        raise command.error(
            "axis-conflict", f"{code} is for {AXES[axis]} while {other} reciprocates; program G80 before"
        )
    plunge, cross = PLANES[command.modes.plane]
    roles = f" in {command.modes.plane}, where {AXES[axis]} reciprocates and {AXES[plunge]} plunges"
    moved = [axis, *([plunge] if rules.plunges else []), *([cross] if rules.cross is not None else [])]
    legal = WORDS[code] + "P" + "".join(AXES[each] + INTEGRANDS[each] for each in moved)
    if rules.plunges:
        command.allow_only(legal, f"a {code} block{roles}")
    else:
        command.allow_only(legal, f"a {code} block", common="EST")

    memory, secondary = _reversal_points(command, memory, situation, axis)
    memory, feed, program, dresses = _feed_and_dress(command, memory, bool(pre_dress))
    plan = CyclePlan(
        code=code,
        pre_dress=bool(pre_dress),
        axis=axis,
        primary=_given(memory.primary),
        secondary=secondary,
        feed=min(feed, situation.maximum_feed),
        program=program,
        dresses=dresses,
        block=command.block.place.block,
        line=command.block.place.line,
        text=command.block.source.text,
    )
    if rules.plunges:
        plan, memory = _add_plunge(plan, command, memory, situation, plunge)
    if rules.cross is not None:
        plan, memory = _add_crossover(plan, command, memory, situation, cross)
    return plan, memory


def redirect(
    command: Command, memory: ModalWords, table: Reciprocation, origin: float, maximum_feed: float
) -> ModalWords:
    """Change reversal points and speed by the words of a block without a cycle (16-9, PD-7, PD-8).

    `memory` is in coordinates of the program, `table` in those of the machine, with the `origin` of its axis, mm.
    """
    axis, end = AXES[table.axis], INTEGRANDS[table.axis]
    start = displaced(table.secondary, -origin)
    if axis in command.lengths:
        memory = replace(memory, primary=coordinate(command, axis, start))
        table.primary = displaced(origin, _given(memory.primary))
    if end in command.lengths:
        memory = replace(memory, secondary=integrand(command, end, start))
        table.secondary = displaced(origin, _given(memory.secondary))
    if table.primary == table.secondary:
        raise _zero_stroke(command, table.axis, displaced(table.primary, -origin))
    if command.reciprocation_feed is not None:
        table.feed, table.feed_reprogrammed = min(command.reciprocation_feed, maximum_feed), True
    return memory


def integrand(command: Command, letter: str, start: float) -> float:
    """Return an integrand as reversal point: the last G90 or G91 of the block decides (16-9)."""
    value = command.lengths[letter]
    return displaced(start, value.mm) if command.modes.incremental else value.mm


def _reciprocating_axis(command: Command, memory: ModalWords, rules: Rules) -> int:
    """Return the reciprocating axis: across the plane; for G81 named in the block (16-13) or that of the last cycle."""
    first, second = PLANES[command.modes.plane]
    if rules.plunges:
        return 3 - first - second
    named = {letters.index(letter) for letters in (AXES, INTEGRANDS) for letter in command.words if letter in letters}
    if len(named) > 1:
        raise command.error("block-format", "G81 names two axes; it takes one axis and its own integrand")
    if named:
        return named.pop()
    if memory.axis is None:
        raise command.error("missing-parameter", "G81 names no axis; X, Y or Z with its integrand is needed")
    return memory.axis


def _reversal_points(command: Command, memory: ModalWords, situation: Situation, axis: int) -> tuple[ModalWords, float]:
    start = situation.position[axis] if situation.reciprocating is None else situation.secondary
    memory = replace(memory, axis=axis)
    if AXES[axis] in command.words:
        memory = replace(memory, primary=coordinate(command, AXES[axis], start))
    if INTEGRANDS[axis] in command.words:
        memory = replace(memory, secondary=integrand(command, INTEGRANDS[axis], start))
    if memory.primary is None:
        raise _missing(command, AXES[axis], "the primary reversal point")
    secondary = start if memory.secondary is None else memory.secondary
    if secondary == memory.primary:
        raise _zero_stroke(command, axis, secondary)
    return memory, secondary


def _feed_and_dress(command: Command, memory: ModalWords, pre_dress: bool) -> tuple[ModalWords, float, int | None, int]:
    block, words = command.block, command.words
    dresses = numbers.integer(block, words["D"], 0, MOST) if "D" in words else 0
    if "P" in words:
        memory = replace(memory, program=numbers.integer(block, words["P"], 1, HIGHEST_PROGRAM))
    if memory.program is None and (pre_dress or dresses > 0):
        raise command.error(
            "missing-parameter",
            f"no dress program is known for {words['D'] if dresses else command.action}; "
            "P is needed, here or in an earlier cycle",
            "D",
        )
    if command.reciprocation_feed is not None:
        memory = replace(memory, feed=command.reciprocation_feed)
    feed = command.modes.feed if memory.feed is None else memory.feed
    if feed is None:
        raise command.error("no-feedrate", f"{command.action} has no reciprocation feed; E or an F before is needed")
    return memory, feed, memory.program, dresses


def _add_plunge(
    plan: CyclePlan, command: Command, memory: ModalWords, situation: Situation, axis: int
) -> tuple[CyclePlan, ModalWords]:
    start, letter = situation.position[axis], INTEGRANDS[axis]
    target, pick = _end_and_pick(
        command, axis, start, memory.depth_target, memory.primary_pick, ("the plunge depth", "the plunge pick")
    )
    feed = command.modes.feed
    if feed is None:
        raise command.error("no-feedrate", f"{plan.code} has no feed for its picks; F is needed")
    words = command.words
    way = target - start
    plan = replace(
        plan,
        plunge_axis=axis,
        plunge_start=start,
        depth_target=target,
        primary_pick=_magnitude(command, letter, pick, way, zero=False),
        secondary_pick=_other_pick(command, "Q", letter, pick, way),
        spark_out=numbers.integer(command.block, words["L"], 0, MOST) if "L" in words else 0,
        pick_feed=min(feed, situation.maximum_feed),
    )
    return plan, replace(memory, depth_target=target, primary_pick=pick)


def _add_crossover(
    plan: CyclePlan, command: Command, memory: ModalWords, situation: Situation, axis: int
) -> tuple[CyclePlan, ModalWords]:
    start, letter = situation.position[axis], INTEGRANDS[axis]
    end, pick = _end_and_pick(
        command, axis, start, memory.cross_end, memory.primary_cross_pick, ("the crossover amount", "the cross pick")
    )
    way = end - start
    plan = replace(
        plan,
        cross_axis=axis,
        cross_start=start,
        cross_end=end,
        primary_cross_pick=_magnitude(command, letter, pick, way, zero=way == 0.0),
        secondary_cross_pick=_other_pick(command, "R", letter, pick, way),
    )
    return plan, replace(memory, cross_end=end, primary_cross_pick=pick)


def _end_and_pick(
    command: Command, axis: int, start: float, end: float | None, pick: float | None, missing: tuple[str, str]
) -> tuple[float, float]:
    """Return target and pick of an axis, mm, from the block or from earlier blocks."""
    letter, integrand = AXES[axis], INTEGRANDS[axis]
    if letter in command.words:
        end = coordinate(command, letter, start)
    if integrand in command.words:
        pick = command.lengths[integrand].mm
    if end is None:
        raise _missing(command, letter, missing[0])
    if pick is None:
        raise _missing(command, integrand, missing[1])
    return end, pick


def _other_pick(command: Command, letter: str, first: str, default: float, way: float) -> float:
    """Return the size of Q or R, mm: that of J or K if omitted; 0 is legal (ruling 4)."""
    if letter in command.words:
        return _magnitude(command, letter, command.lengths[letter].mm, way, zero=True)
    return _magnitude(command, first, default, way, zero=True)


def _magnitude(command: Command, letter: str, pick: float, way: float, zero: bool) -> float:
    """Return the size of a pick, mm, which must point along `way`; its sign is free if `way` is 0 (ruling 3)."""
    named = command.named(letter, pick)
    if pick == 0.0 and not zero:
        least = "0.0001" if command.modes.inch else "0.001"
        raise command.error("zero-pick", f"{named} is no pick; it must be {least} or more in size", letter)
    if pick * way < 0.0:
        sign = "positive" if way > 0.0 else "negative"
        origin = "" if letter in command.words else ", from an earlier cycle,"
        raise command.error("pick-direction", f"{named}{origin} points away from its target; it must be {sign}", letter)
    return abs(pick)


def _missing(command: Command, letter: str, meaning: str) -> ControlError:
    return command.error(
        "missing-parameter", f"{command.action} lacks {letter}, {meaning}; give it here or in an earlier cycle"
    )


def _zero_stroke(command: Command, axis: int, mm: float) -> ControlError:
    point = command.named(AXES[axis], mm)
    return command.error("zero-stroke", f"both reversal points are {point}; a stroke needs a length", AXES[axis])


def _given(value: float | None) -> float:
    assert value is not None  # checked where it was read
    return value
