"""Properties of compensated paths for random contours, sides and planes."""

import cmath
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, execute, read, record
from tests.control.contours import FIRST_AND_SECOND, Run, runs
from tests.examples import examples

START = -30.0 - 7j
WORD = 2e-3  #: uncertainty left by three decimals in ends and centres, mm
#: distance in radii beyond which two elements cannot interfere. The centre keeps one radius from each element and is up
#: to 2.4 from its own one where the offsets of two arcs meet at right angles outside. Points one radius apart suffice:
#: between two points, an element comes at most half a radius nearer
APART = 4.0
LETTERS = {"G17": ("XY", "IJ"), "G18": ("ZX", "KI"), "G19": ("YZ", "JK")}
planes = st.sampled_from(sorted(LETTERS))
sides = st.sampled_from(["G41", "G42"])


@dataclass(frozen=True)
class Piece:
    """A programmed element: a turn, then a line (bend 0) or an arc of a bend and a radius, degrees and mm."""

    turn: float
    size: float
    bend: float


straight = st.builds(Piece, st.floats(-130, 130), st.floats(15, 60), st.just(0.0))
curved = st.builds(Piece, st.floats(-100, 100), st.floats(15, 40), st.floats(40, 140) | st.floats(-140, -40))
contours = st.lists(straight | curved, min_size=2, max_size=6)


@dataclass(frozen=True)
class Element:
    start: complex
    end: complex
    centre: complex | None
    rotation: int

    def distance(self, point: complex) -> float:
        """Return the distance of a point from the element."""
        if self.centre is None:
            way = self.end - self.start
            share = ((point - self.start) * way.conjugate()).real / abs(way) ** 2
            return abs(point - self.start - min(max(share, 0.0), 1.0) * way)
        spoke = point - self.centre
        turned = (cmath.phase(spoke / (self.start - self.centre)) * self.rotation) % math.tau
        total = (cmath.phase((self.end - self.centre) / (self.start - self.centre)) * self.rotation) % math.tau
        if turned <= total:
            return abs(abs(spoke) - abs(self.start - self.centre))
        return min(abs(point - self.start), abs(point - self.end))

    def points(self, apart: float) -> list[complex]:
        """Return points along the element, both ends included, at most `apart` mm from each other."""
        if self.centre is None:
            way = self.end - self.start
            count = math.ceil(abs(way) / apart)
            return [self.start + share / count * way for share in range(count + 1)]
        spoke = self.start - self.centre
        total = (cmath.phase((self.end - self.centre) / spoke) * self.rotation) % math.tau
        count = math.ceil(abs(spoke) * total / apart)
        return [
            self.centre + spoke * cmath.rect(1.0, self.rotation * share / count * total) for share in range(count + 1)
        ]

    def reversed(self) -> "Element":
        """Return the element in the opposite direction."""
        return Element(self.end, self.start, self.centre, -self.rotation)


def rounded(point: complex) -> complex:
    return complex(round(point.real, 3), round(point.imag, 3))


def elements(pieces: list[Piece]) -> list[Element]:
    """Return the contour from the origin along the first axis, with points rounded as in words."""
    position, heading, result = 0j, 1.0 + 0j, []
    for index, piece in enumerate(pieces):
        heading *= cmath.rect(1.0, math.radians(piece.turn)) if index else 1.0
        if piece.bend == 0.0:
            end, centre, rotation = rounded(position + piece.size * heading), None, 0
        else:
            rotation = 1 if piece.bend > 0.0 else -1
            centre = rounded(position + piece.size * heading * 1j * rotation)
            end = rounded(centre + (position - centre) * cmath.rect(1.0, math.radians(piece.bend)))
            heading *= cmath.rect(1.0, math.radians(piece.bend))
        result.append(Element(position, end, centre, rotation))
        position = end
    return result


def text(path: list[Element], side: str, plane: str, corner: str = "G39") -> str:
    (first, second), (offset, other) = LETTERS[plane]
    blocks = [f"{plane} {corner} G90 {side} G01 {first}0 {second}0 F600."]
    for element in path:
        words = f"{first}{element.end.real:.3f} {second}{element.end.imag:.3f}"
        if element.centre is None:
            blocks.append(f"G01 {words}")
        else:
            spoke = element.centre - element.start
            code = "G03" if element.rotation == 1 else "G02"
            blocks.append(f"{code} {words} {offset}{spoke.real:.3f} {other}{spoke.imag:.3f}")
    away = path[-1].end + 30.0
    blocks.append(f"G40 G01 {first}{away.real:.3f} {second}{away.imag:.3f}")
    return "\n".join(blocks)


def records_of(program: str, plane: str, radius: float, start: complex) -> list[dict[str, Any]]:
    """Return the trace of a program; skip contours that cannot be compensated."""
    first, second = FIRST_AND_SECOND[plane]
    position = [0.0, 0.0, 0.0]
    position[first], position[second] = start.real, start.imag
    control = Control(radius=radius, start=(position[0], position[1], position[2]))
    try:
        found = [motion for event in execute(read(program), control) if (motion := record(event))]
    except ControlError as error:
        assume(error.name not in ("interference", "backwards-motion", "circular-departure-too-small"))
        raise
    return [{"kind": "rapid", "end": position}, *found]


def trace(program: str, plane: str, radius: float, start: complex = START) -> list[Run]:
    """Return the runs of a program without entry and exit."""
    return runs(records_of(program, plane, radius, start))[2:-1]


def points(run: Run) -> list[complex]:
    return [complex(*run.flat(point)) for point in run.points()]


@examples(150)
@given(contours, sides, planes, st.floats(0.2, 6.0), st.sampled_from(["G39", "G39.1"]))
def test_the_centre_keeps_one_radius_from_the_contour(
    pieces: list[Piece], side: str, plane: str, radius: float, corner: str
) -> None:
    path = elements(pieces)
    assume(stays_apart(path, radius))
    for own, way in followed(path, side, plane, radius, corner):
        for element in path[max(own - 1, 0) : own + 2]:
            assert all(element.distance(point) >= radius - WORD for point in way)


@pytest.mark.parametrize(
    ("pieces", "side", "plane", "radius"),
    [
        ([Piece(0.0, 15.0, -102.0), Piece(-130.0, 22.0, 0.0)], "G41", "G17", 3.0),
        (
            [Piece(0.0, 32.607, -46.606), Piece(-86.089, 19.277, -88.034), Piece(80.687, 30.798, -85.218)],
            "G42",
            "G19",
            5.859,
        ),
        ([Piece(0.0, 29.0, -140.0), Piece(-83.75, 29.0, -140.0)], "G41", "G17", 0.21875),
    ],
)
def test_a_contour_that_comes_back_to_itself_is_followed(
    pieces: list[Piece], side: str, plane: str, radius: float
) -> None:
    # the control looks at crossing vectors only (L 21-54): no wheel of this radius fits, but none of them cross
    path = elements(pieces)
    assert not stays_apart(path, radius)
    assert followed(path, side, plane, radius, "G39")


def followed(path: list[Element], side: str, plane: str, radius: float, corner: str) -> list[tuple[int, list[complex]]]:
    """Return element number and points of each motion; require one motion per element, one radius from it."""
    records = records_of(text(path, side, plane, corner), plane, radius, START)
    found, programmed = [], []
    for run, motion in zip(runs(records)[2:-1], records[2:-1], strict=True):
        own = motion["block"] - 2
        way = points(run if run.kind == "arc" else Run(run.kind, run.start, run.end, plane=plane))
        if motion["source"] == "program":
            programmed.append(own)
            assert all(abs(path[own].distance(point) - radius) <= WORD or beyond(path[own], point) for point in way)
        found.append((own, way))
    assert programmed == list(range(len(path)))
    return found


def stays_apart(path: list[Element], radius: float) -> bool:
    """Return whether neighbouring elements run away from their corner on both sides."""
    return all(
        opens(one, next_, radius) and opens(next_, one.reversed(), radius) for one, next_ in itertools.pairwise(path)
    )


def opens(first: Element, second: Element, radius: float) -> bool:
    """Return whether the distance from the first element grows along the second one, up to `APART` radii."""
    gaps = [min(first.distance(point), APART * radius) for point in second.points(radius)]
    return gaps == sorted(gaps)


def beyond(element: Element, point: complex) -> bool:
    """Return whether a point lies past an end of an element, where the path leads to a corner."""
    return min(abs(point - element.start), abs(point - element.end)) <= element.distance(point) + 1e-9


def ends(found: list[Run], plane: str) -> list[complex]:
    first, second = FIRST_AND_SECOND[plane]
    return [complex(run.end[first], run.end[second]) for run in found]


def transformed(path: list[Element], change: Callable[[complex], complex], flip: bool) -> list[Element]:
    return [
        Element(
            change(e.start),
            change(e.end),
            None if e.centre is None else change(e.centre),
            -e.rotation if flip else e.rotation,
        )
        for e in path
    ]


@pytest.mark.parametrize(
    ("change", "flip"),
    [
        (lambda p: p + (12.345 - 6.789j), False),
        (lambda p: p * 1j, False),
        (lambda p: -p, False),
        (lambda p: p.conjugate(), True),
    ],
    ids=["translated", "turned by 90 degrees", "turned by 180 degrees", "mirrored"],
)
@examples(40)
@given(pieces=contours, side=sides, plane=planes, radius=st.floats(0.2, 6.0))
def test_the_path_is_translated_turned_and_mirrored_with_its_contour(
    change: Callable[[complex], complex], flip: bool, pieces: list[Piece], side: str, plane: str, radius: float
) -> None:
    path = elements(pieces)
    other = {"G41": "G42", "G42": "G41"}[side] if flip else side
    here = ends(trace(text(path, side, plane), plane, radius, START), plane)
    first = transformed([Element(0j, 0j, None, 0), *path], change, flip)
    program = text(first[1:], other, plane)
    letters = LETTERS[plane][0]
    program = program.replace(
        f"{letters[0]}0 {letters[1]}0", f"{letters[0]}{first[0].end.real:.3f} {letters[1]}{first[0].end.imag:.3f}", 1
    )
    there = ends(trace(program, plane, radius, change(START)), plane)
    for moved, point in zip(there[:-1], here[:-1], strict=True):
        assert moved == pytest.approx(change(point), abs=1e-6)


@examples(40)
@given(pieces=contours, side=sides, plane=planes, radius=st.floats(0.2, 6.0), data=st.data())
def test_splitting_a_line_does_not_change_the_path(
    pieces: list[Piece], side: str, plane: str, radius: float, data: st.DataObject
) -> None:
    pieces = [
        Piece(p.turn, p.size, p.bend) if p.bend else Piece(round(p.turn / 90) * 90 % 180 * 1.0, round(p.size), 0.0)
        for p in pieces
    ]
    path = elements([Piece(0.0, 40.0, 0.0), *pieces])
    middle = complex(data.draw(st.integers(10, 30)), 0.0)
    split = [Element(0j, middle, None, 0), Element(middle, path[0].end, None, 0), *path[1:]]
    whole = trace(text(path, side, plane), plane, radius)
    parts = trace(text(split, side, plane), plane, radius)
    assert ends(parts, plane)[-1] == pytest.approx(ends(whole, plane)[-1])
    assert [p for p in ends(parts, plane) if abs(p.real - middle.real) > 1e-9 or abs(abs(p.imag) - radius) > 1e-9] == [
        pytest.approx(p) for p in ends(whole, plane)
    ]
