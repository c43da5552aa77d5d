import cmath
import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grind_env.control.compensation.corners import corner
from grind_env.control.compensation.plane import Bow, Element, Offset, PathSegment
from tests.control.compensation.chain import (
    Run,
    clear_of_curve,
    contour,
    distance,
    element_from,
    joined,
    path_of,
    point,
    samples,
    swept,
)
from tests.examples import examples

STEPS = 400
TOLERANCE = 1e-6

sides = st.sampled_from([1, -1])
turns = st.integers(-179, 179)
lines = st.tuples(st.just(0.0), st.floats(20.0, 60.0))


def arcs(radius: float, angle: float) -> st.SearchStrategy[tuple[float, float]]:
    """Bend in degrees and radius, both from a smallest one on."""
    bend = st.builds(lambda way, size: way * size, sides, st.floats(angle, 150.0))
    return st.tuples(bend, st.floats(radius, 40.0))


parts = lines | arcs(4.0, 20.0)
# Corners of up to 110 degrees between elements of this size trim and lengthen them by less than 0.4.
gentle = st.lists(
    st.builds(lambda turned, part: (float(turned), *part), st.integers(-110, 110), lines | arcs(20.0, 60.0)),
    min_size=1,
    max_size=6,
)


def parallel(element: Element, offset: Offset) -> list[complex]:
    """Points one radius beside an element, from its start to its end.

    No further apart than the radius, so that none of another element that it crosses lies between two of them.
    """
    length = element.length if isinstance(element, PathSegment) else element.radius * swept(element)
    places = samples(element, max(STEPS, math.ceil(length / offset.radius)))
    if isinstance(element, PathSegment):
        normal = 1j * (complex(*element.end) - complex(*element.start)) / element.length
        return [place + offset.side * offset.radius * normal for place in places]
    centre, ratio = complex(*element.centre), 1.0 - offset.side * element.rotation * offset.radius / element.radius
    return [centre + ratio * (place - centre) for place in places]


def crossing(a: complex, b: complex, c: complex, d: complex) -> bool:
    """Whether the lines from a to b and from c to d cross."""

    def left(start: complex, end: complex, place: complex) -> bool:
        return ((place - start) / (end - start)).imag > 0.0

    return left(a, b, c) != left(a, b, d) and left(c, d, a) != left(c, d, b)


def pair(turned: float, before: tuple[float, float], after: tuple[float, float]) -> tuple[Element, Element]:
    """Two elements with a corner at the origin."""
    bend, size = before
    backwards = element_from(0j, math.pi, -bend, size)
    first: Element = PathSegment(backwards.end, backwards.start)
    if isinstance(backwards, Bow):
        first = Bow(backwards.end, backwards.start, backwards.centre, -backwards.rotation)
    return first, element_from(0j, math.radians(turned), *after)


def sound(first: Element, second: Element, runs: list[Run], radius: float) -> None:
    """No gouge of either element; every piece begins where the one before ends."""
    for before, after in pairwise(runs):
        assert math.dist(before.path.end, after.path.start) < TOLERANCE
    for run in runs:
        for sample in samples(run.path):
            assert min(distance(sample, first), distance(sample, second)) > radius - TOLERANCE


@examples(600)
@given(turned=turns, before=parts, after=parts, radius=st.floats(0.05, 5.0), side=sides, circular=st.booleans())
def test_a_corner_is_not_gouged(
    turned: int, before: tuple[float, float], after: tuple[float, float], radius: float, side: int, circular: bool
) -> None:
    """Where the offset paths hurt the other element only next to the corner, the compensated path hurts none.

    Inside it is trimmed just to the point from which on it would.
    """
    offset = Offset(radius, side)
    first, second = pair(turned, before, after)
    for element in (first, second):
        assume(isinstance(element, PathSegment) or element.rotation != side or element.radius > 1.01 * radius)
    beside_first, beside_second = parallel(first, offset), parallel(second, offset)
    hurt_first = [distance(sample, second) < radius - 1e-9 for sample in beside_first]
    hurt_second = [distance(sample, first) < radius - 1e-9 for sample in beside_second]
    assume(hurt_first == sorted(hurt_first) and hurt_second == sorted(hurt_second, reverse=True))
    assume(not hurt_first[0] and not hurt_second[-1])
    inside = side * turned > 0
    assume(inside or not any(hurt_first + hurt_second))
    trimmed = sum(hurt_first) and sum(hurt_second)
    if trimmed:
        step_first = beside_first[-sum(hurt_first) - 1], beside_first[-sum(hurt_first)]
        step_second = beside_second[sum(hurt_second) - 1], beside_second[sum(hurt_second)]
        assume(crossing(*step_first, *step_second))
    runs = contour([first, second], offset, circular)
    sound(first, second, runs, radius)
    if trimmed:
        met = complex(*runs[0].path.end)
        assert abs(met - step_first[0]) < 1.01 * abs(step_first[1] - step_first[0])
        assert abs(met - step_second[1]) < 1.01 * abs(step_second[1] - step_second[0])
    assert len(runs) == 2 or not inside


@examples(300)
@given(turned=st.integers(1, 179), radius=st.floats(0.01, 10.0), side=sides, circular=st.booleans())
def test_lines_outside(turned: int, radius: float, side: int, circular: bool) -> None:
    """Any angle: never nearer than one radius to the corner, never further away than its diagonal."""
    first, second = pair(-side * turned, (0.0, 50.0), (0.0, 50.0))
    runs = contour([first, second], Offset(radius, side), circular)
    sound(first, second, runs, radius)
    assert len(runs) == (2 if turned <= 90 else 3)
    for run in runs[1:-1]:
        farthest = max(abs(sample) for sample in samples(run.path))
        assert farthest <= radius * (1.0 if circular else math.sqrt(2.0)) + TOLERANCE


@examples(300)
@given(turned=st.integers(1, 179), radius=st.floats(0.01, 10.0), side=sides)
def test_lines_inside(turned: int, radius: float, side: int) -> None:
    """Both paths end on the bisector, one radius from either line."""
    length = 1.5 * radius * math.tan(math.radians(turned / 2)) + 1.0
    first, second = pair(side * turned, (0.0, length), (0.0, length))
    offset = Offset(radius, side)
    junction = corner(first, second, offset, False, 0.0)
    assert junction.generated == ()
    met = complex(*junction.end)
    assert clear_of_curve(met, first) == pytest.approx(radius)
    assert clear_of_curve(met, second) == pytest.approx(radius)
    sound(first, second, contour([first, second], offset), radius)


@examples(300)
@given(path=gentle, radius=st.floats(0.05, 2.5), side=sides, circular=st.booleans())
def test_contours(path: list[tuple[float, float, float]], radius: float, side: int, circular: bool) -> None:
    """Every compensated element keeps one radius from its curve on its side; the pieces join."""
    elements = path_of(3 - 2j, 0.4, path)
    runs = contour(elements, Offset(radius, side), circular)
    for before, after in pairwise(runs):
        assert math.dist(before.path.end, after.path.start) < TOLERANCE
    assert [run.of for run in runs if run.of is not None] == list(range(len(elements)))
    for run in runs:
        if run.of is None:
            continue
        element = elements[run.of]
        start, end = complex(*element.start), complex(*element.end)
        for sample in samples(run.path):
            assert clear_of_curve(sample, element) == pytest.approx(radius, abs=TOLERANCE)
            if isinstance(element, Bow):
                inwards = abs(sample - complex(*element.centre)) < element.radius
                assert inwards == (element.rotation == side)
            else:
                assert side * ((sample - start) / (end - start)).imag > 0.0
        if isinstance(element, Bow):
            assert isinstance(run.path, Bow)
            assert (run.path.centre, run.path.rotation) == (element.centre, element.rotation)
            assert abs(swept(run.path) - swept(element)) < 0.9 * math.pi


@examples(200)
@given(
    path=gentle,
    radius=st.floats(0.05, 2.5),
    side=sides,
    circular=st.booleans(),
    shift=st.complex_numbers(max_magnitude=500.0),
)
@pytest.mark.parametrize(
    ("move", "turned_over"),
    [
        (lambda z, shift: z + shift, False),
        (lambda z, shift: 1j * z, False),
        (lambda z, shift: z * cmath.exp(1j * abs(shift)), False),
        (lambda z, shift: z.conjugate(), True),
        (lambda z, shift: -z.conjugate(), True),
    ],
    ids=["translation", "90 degrees", "any angle", "mirror in u", "mirror in v"],
)
def test_symmetry(
    move: Callable[[complex, complex], complex],
    turned_over: bool,
    path: list[tuple[float, float, float]],
    radius: float,
    side: int,
    circular: bool,
    shift: complex,
) -> None:
    def image(element: Element) -> Element:
        ends = [point(move(complex(*place), shift)) for place in (element.start, element.end)]
        if isinstance(element, PathSegment):
            return PathSegment(ends[0], ends[1])
        centre = point(move(complex(*element.centre), shift))
        return Bow(ends[0], ends[1], centre, -element.rotation if turned_over else element.rotation)

    elements = path_of(0j, 0.1, path)
    expected = [image(run.path) for run in contour(elements, Offset(radius, side), circular)]
    other_side = -side if turned_over else side
    found = [run.path for run in contour([image(e) for e in elements], Offset(radius, other_side), circular)]
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        assert type(one) is type(other)
        assert one.start == pytest.approx(other.start, abs=TOLERANCE)
        assert one.end == pytest.approx(other.end, abs=TOLERANCE)
        if isinstance(one, Bow) and isinstance(other, Bow):
            assert one.centre == pytest.approx(other.centre, abs=TOLERANCE)
            assert one.rotation == other.rotation


@examples(200)
@given(path=gentle, radius=st.floats(0.05, 2.5), side=sides, share=st.floats(0.4, 0.6), data=st.data())
def test_splitting_an_element_changes_nothing(
    path: list[tuple[float, float, float]], radius: float, side: int, share: float, data: st.DataObject
) -> None:
    """The pieces of the cut line or arc add up, the others stay."""
    elements = path_of(0j, 0.1, path)
    which = data.draw(st.integers(0, len(elements) - 1))
    cut = elements[which]
    if isinstance(cut, PathSegment):
        where = point(complex(*cut.start) + share * (complex(*cut.end) - complex(*cut.start)))
        halves: list[Element] = [PathSegment(cut.start, where), PathSegment(where, cut.end)]
    else:
        centre = complex(*cut.centre)
        there = centre + (complex(*cut.start) - centre) * cmath.exp(1j * cut.rotation * share * swept(cut))
        halves = [
            Bow(cut.start, point(there), cut.centre, cut.rotation),
            Bow(point(there), cut.end, cut.centre, cut.rotation),
        ]
    offset = Offset(radius, side)
    whole = contour(elements, offset)
    split = contour([*elements[:which], *halves, *elements[which + 1 :]], offset)
    assert len(split) == len(whole) + 1
    assert sum(run.path.length for run in split) == pytest.approx(sum(run.path.length for run in whole), abs=1e-5)
    for run in whole:
        assert min(math.dist(run.path.end, other.path.end) for other in split) < TOLERANCE


@examples(200)
@given(path=gentle, side=sides, circular=st.booleans())
def test_radius_0_gives_the_programmed_path(path: list[tuple[float, float, float]], side: int, circular: bool) -> None:
    elements = path_of(1 + 1j, 0.1, path)
    runs = list(joined(elements, Offset(0.0, side), circular, elements[0].start, elements[-1].end))
    assert [run.path for run in runs] == elements


def rounded(number: complex) -> complex:
    return complex(round(number.real, 3), round(number.imag, 3))


@examples(300)
@given(
    before=parts,
    after=parts,
    radius=st.floats(0.05, 3.0),
    side=sides,
    circular=st.booleans(),
    heading=st.floats(0.0, 6.0),
)
def test_tangential_words_rounded_to_a_micrometre_generate_nothing(
    before: tuple[float, float], after: tuple[float, float], radius: float, side: int, circular: bool, heading: float
) -> None:
    """The tangents then differ by up to some 1e-3 rad; the junction stays by the perpendicular point."""
    elements: list[Element] = []
    for element in path_of(0j, heading, [(0.0, *before), (0.0, *after)]):
        start, end = (point(rounded(complex(*place))) for place in (element.start, element.end))
        if isinstance(element, PathSegment):
            elements.append(PathSegment(start, end))
        else:
            assume(element.rotation != side or element.radius > 1.05 * radius)
            elements.append(Bow(start, end, point(rounded(complex(*element.centre))), element.rotation))
    offset = Offset(radius, side)
    junction = corner(elements[0], elements[1], offset, circular, 0.0)
    assert junction.generated == ()
    assert math.dist(junction.end, offset.beside_end(elements[0])) < 0.1 * radius
    assert len(contour(elements, offset, circular)) == 2
