"""Grooving cycles G76 and G77: the plan of a block, and the legs of its path (lathe manual 23-3, 23-4, 23-7).

G77 infeeds along the second axis of the plane and spaces its grooves along the first one, G76 the other way
round; in G18 that is X and Z (22-2). What the manual leaves open is decided in `grooving-g77.md`, section 3(b).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

from grind_env.control import numbers
from grind_env.control.block_decoding import Command
from grind_env.control.cli_options import CHECK_COMMANDS
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.events import Position, placed
from grind_env.control.modes import PLANES
from grind_env.control.motion_paths import AXES, INTEGRANDS, coordinate, displaced, no_feed_rate

LegKind: TypeAlias = Literal["infeed", "rapid"]

METRIC_RETRACT = 0.5  #: default retract amount e under G71, mm (D)
INCH_RETRACT = 0.508  #: default retract amount e under G70, mm: 0.02 in (D)


@dataclass(frozen=True, slots=True, kw_only=True)
class GroovePlan:
    """The parameters of a grooving cycle; lengths in mm, X as a radius."""

    code: str  #: G76 or G77
    axis: int  #: infeed axis; 0 = X, 1 = Y, 2 = Z
    spacing_axis: int  #: axis along which the grooves follow one another
    start: Position  #: position of the tool before the block; the first groove is here
    bottom: float  #: bottom of the grooves, a coordinate of `axis`
    step: float  #: infeed of a step, positive
    retract: float  #: e, distance back after every step but the last; smaller than `step`
    last: float  #: position of the last groove, a coordinate of `spacing_axis`
    spacing: float  #: distance between grooves, positive; 0 if there is one groove only
    shift: float  #: D, signed shift along `spacing_axis` at full depth

    @property
    def depth(self) -> float:
        return abs(self.bottom - self.start[self.axis])

    def point(self, infeed: float, across: float) -> Position:
        return placed(self.start, {self.axis: infeed, self.spacing_axis: across})


@dataclass(frozen=True, slots=True)
class GrooveLeg:
    """A straight leg from the end of the leg before; the way to a groove counts to this groove, numbered from 1."""

    end: Position
    kind: LegKind
    groove: int


def plan_groove(command: Command, position: Position, retract: float) -> GroovePlan:
    """Return the plan of a G76 or G77 block, in coordinates of the program, with the retract amount e, mm."""
    code = command.action
    axis, spacing_axis = PLANES[command.modes.plane][:: -1 if code == "G77" else 1]
    infeed, space = AXES[axis], AXES[spacing_axis]
    letters = infeed + space + INTEGRANDS[axis] + INTEGRANDS[spacing_axis] + "D"
    command.allow_only(
        letters, f"a {code} block in {command.modes.plane}, where {infeed} infeeds and {space} spaces the grooves"
    )
    if command.modes.compensation != "G40":
        message = f"{code} is programmed under {command.modes.compensation}; program G40 before"
        raise command.error("compensation", message)
    bottom = _bottom(command, axis, position[axis])
    last, spacing = _last_groove(command, spacing_axis, position[spacing_axis])
    step = _step(command, INTEGRANDS[axis], retract)
    if "D" not in command.words:
        raise command.error("missing-parameter", f"{code} lacks D, the shift at full depth; give D0 for none")
    plan = GroovePlan(
        code=code,
        axis=axis,
        spacing_axis=spacing_axis,
        start=position,
        bottom=bottom,
        step=step,
        retract=retract,
        last=last,
        spacing=spacing,
        shift=numbers.length(command.block, command.words["D"], command.modes.inch, command.number_format),
    )
    if command.modes.feed is None:
        raise no_feed_rate(command)
    return plan


def groove_legs(plan: GroovePlan) -> Iterator[GrooveLeg]:
    """Yield the legs of a grooving cycle; legs without length are left out."""
    here = plan.start
    for groove, across in enumerate(groove_positions(plan), 1):
        for end, kind in _one_groove(plan, across):
            if end != here:
                yield GrooveLeg(end, kind, groove)
                here = end


def least_legs(plan: GroovePlan) -> int:
    """Return the least number of legs: infeeds, retracts between them, and the way out of each groove."""
    spaces = _steps(abs(plan.last - plan.start[plan.spacing_axis]), plan.spacing) if plan.spacing else 0
    return (1 + spaces) * 2 * _steps(plan.depth, plan.step)


def groove_positions(plan: GroovePlan) -> Iterator[float]:
    """Yield the coordinates of the grooves, mm; the first is at the tool, the last at Z (G76: X) (23-3, 23-7)."""
    start = plan.start[plan.spacing_axis]
    yield start
    if plan.last != start:
        for done in divided(abs(plan.last - start), plan.spacing):
            yield _on_the_way(start, plan.last, done)


def divided(total: float, step: float) -> Iterator[float]:
    """Yield the distances covered after 1, 2, ... steps, mm; the last step is shortened to end at `total` (23-7).

    Distances are multiples of `step`, not sums, so rounding errors do not accumulate.
    """
    for count in range(1, _steps(total, step)):
        yield count * step
    yield total


def _steps(total: float, step: float) -> int:
    return math.ceil((total - DEPTH_TOLERANCE) / step)


def _one_groove(plan: GroovePlan, across: float) -> Iterator[tuple[Position, LegKind]]:
    surface = plan.start[plan.axis]
    yield plan.point(surface, across), "rapid"
    for done in divided(plan.depth, plan.step):
        yield plan.point(_on_the_way(surface, plan.bottom, done), across), "infeed"
        if done < plan.depth:
            yield plan.point(_on_the_way(surface, plan.bottom, done - plan.retract), across), "rapid"
    aside = displaced(across, plan.shift) if plan.shift else across
    yield plan.point(plan.bottom, aside), "rapid"
    yield plan.point(surface, aside), "rapid"


def _on_the_way(start: float, end: float, done: float) -> float:
    return end if done >= abs(end - start) else displaced(start, math.copysign(done, end - start))


def _bottom(command: Command, axis: int, start: float) -> float:
    letter = AXES[axis]
    if letter not in command.words:
        raise command.error("missing-parameter", f"{command.action} lacks {letter}, the bottom of the groove; give it")
    bottom = coordinate(command, letter, start)
    if abs(bottom - start) <= DEPTH_TOLERANCE:
        raise command.error(
            "no-depth", f"{command.words[letter]} leaves the groove no depth; it must lead away from the start", letter
        )
    return bottom


def _step(command: Command, letter: str, retract: float) -> float:
    step = _size(command, letter, "the infeed of each step")
    if step <= retract:
        raise command.error(
            "groove-retract",
            f"{command.words[letter]} is a step of {step:g} mm, from which the retract of {retract:g} mm leaves "
            "nothing; program a larger step, or give a smaller retract with --groove-retract of "
            f"{CHECK_COMMANDS} (groove_retract)",
            letter,
        )
    return step


def _last_groove(command: Command, axis: int, start: float) -> tuple[float, float]:
    """Return the place of the last groove, and the spacing; K, or I in G76, counts only for several grooves."""
    letter = AXES[axis]
    last = coordinate(command, letter, start) if letter in command.words else start
    if abs(last - start) <= DEPTH_TOLERANCE:
        return start, 0.0
    return last, _size(command, INTEGRANDS[axis], f"the spacing of the grooves up to {command.words[letter]}")


def _size(command: Command, letter: str, meaning: str) -> float:
    """Return the size of an integrand, mm, which must not be 0; it is incremental in G90, too (23-4, 23-7)."""
    if letter not in command.words:
        raise command.error("missing-parameter", f"{command.action} lacks {letter}, {meaning}; give it in the block")
    size = abs(command.lengths[letter].mm)
    if size == 0.0:
        raise command.error("out-of-range", f"{command.words[letter]} counts as 0; {meaning} must be more", letter)
    return size
