"""A compensated contour is the same path whether its blocks stand in the main program or in subprograms."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, execute, read, record

PLANES = {"G17": ("XY", "IJ"), "G18": ("ZX", "KI"), "G19": ("YZ", "JK")}
signs = st.sampled_from([-1, 1])
lines = st.tuples(st.just("G01"), st.integers(-20, 20), st.integers(1, 20), signs)
arcs = st.tuples(st.sampled_from(["G02", "G03"]), st.integers(3, 12), signs, signs)
contours = st.lists(lines | arcs, min_size=2, max_size=6)


def block(element: tuple[str, int, int, int], plane: str) -> str:
    """A line, or a quarter arc whose centre is along the first axis, in incremental words."""
    (first, second), (offset, _) = PLANES[plane]
    code, size, other, sign = element
    if code == "G01":
        return f"G01 {first}{size}. {second}{sign * other}."
    return f"{code} {first}{other * size}. {second}{sign * size}. {offset}{other * size}."


def path(text: str, radius: float) -> list[Any]:
    """The trace without the places of the blocks; a refusal as its name."""
    found: list[Any] = []
    try:
        for event in execute(read(text), Control(radius=radius)):
            if motion := record(event):
                found.append({key: value for key, value in motion.items() if key != "block"})
    except ControlError as error:
        found.append(error.name)
    return found


@settings(max_examples=150)
@given(contours, st.sampled_from(sorted(PLANES)), st.sampled_from(["G41", "G42"]), st.integers(1, 3), st.data())
def test_a_contour_in_subprograms(
    contour: list[tuple[str, int, int, int]], plane: str, side: str, times: int, data: st.DataObject
) -> None:
    """The cut leaves blocks on both sides, or M99, M99 and M98 in a row would be more than compensation survives."""
    cut = data.draw(st.integers(1, len(contour) - 1))
    first, second = PLANES[plane][0]
    blocks = [block(element, plane) for element in contour]
    head = f"{plane} G91 {side} G01 {first}5. {second}3. F100."
    tail = f"G40 G01 {first}30. {second}7.\nM30"
    inline = "\n".join([head, *blocks * times, tail])
    called = "\n".join(
        [head, f"M98 P1 L{times}", tail, "O1", *blocks[:cut], "M98 P2", "M99", "O2", *blocks[cut:], "M99"]
    )
    assert path(called, 1.0) == path(inline, 1.0)
