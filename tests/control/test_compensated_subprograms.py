"""A compensated contour is the same path whether its blocks stand in the main program or in subprograms."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, execute, read, record
from tests.examples import examples

PLANES = {"G17": ("XY", "IJ"), "G18": ("ZX", "KI"), "G19": ("YZ", "JK")}
signs = st.sampled_from([-1, 1])
lines = st.tuples(st.just("G01"), st.integers(-20, 20), st.integers(1, 20), signs)
arcs = st.tuples(st.sampled_from(["G02", "G03"]), st.integers(3, 12), signs, signs)
contours = st.lists(lines | arcs, min_size=2, max_size=6)


def block(element: tuple[str, int, int, int], plane: str) -> str:
    """Return the incremental block of a line, or of a quarter arc whose centre lies along the first axis."""
    (first, second), (offset, _) = PLANES[plane]
    code, size, other, sign = element
    if code == "G01":
        return f"G01 {first}{size}. {second}{sign * other}."
    return f"{code} {first}{other * size}. {second}{sign * size}. {offset}{other * size}."


def path(text: str, radius: float, budget: int = 1000) -> list[Any]:
    """Return the trace without block and line numbers; a refusal appears by its name."""
    found: list[Any] = []
    try:
        for event in execute(read(text), Control(radius=radius, block_budget=budget)):
            if motion := record(event):
                found.append({key: value for key, value in motion.items() if key not in ("block", "line")})
    except ControlError as error:
        found.append(error.name)
    return found


def framed(contour: list[tuple[str, int, int, int]], plane: str, side: str) -> tuple[str, list[str], str]:
    """Return the entry, the blocks and the exit of a compensated contour."""
    first, second = PLANES[plane][0]
    head = f"{plane} G91 {side} G01 {first}5. {second}3. F100."
    return head, [block(element, plane) for element in contour], f"G40 G01 {first}30. {second}7.\nM30"


@examples(150)
@given(contours, st.sampled_from(sorted(PLANES)), st.sampled_from(["G41", "G42"]), st.integers(1, 3), st.data())
def test_a_contour_split_into_subprograms_gives_the_same_path(
    contour: list[tuple[str, int, int, int]], plane: str, side: str, times: int, data: st.DataObject
) -> None:
    """Both subprograms have motions, because M99, M99 and M98 in a row would end the compensation."""
    cut = data.draw(st.integers(1, len(contour) - 1))
    head, blocks, tail = framed(contour, plane, side)
    inline = "\n".join([head, *blocks * times, tail])
    called = "\n".join(
        [head, f"M98 P1 L{times}", tail, "O1", *blocks[:cut], "M98 P2", "M99", "O2", *blocks[cut:], "M99"]
    )
    assert path(called, 1.0) == path(inline, 1.0)


@examples(100)
@given(contours, st.sampled_from(sorted(PLANES)), st.sampled_from(["G41", "G42"]), st.integers(1, 3))
def test_m99_in_the_last_motion_block_gives_the_same_path(
    contour: list[tuple[str, int, int, int]], plane: str, side: str, times: int
) -> None:
    """Blocks after the M99 are never executed, so the last motion must not be joined to them."""
    first, second = PLANES[plane][0]
    head, blocks, tail = framed(contour, plane, side)
    called = [head, f"M98 P1 L{times}", tail, "O1", *blocks]
    own = "\n".join([*called, "M99"])
    shared = "\n".join([*called[:-1], f"{called[-1]} M99", f"G01 {first}-9. {second}4."])
    assert path(shared, 1.0) == path(own, 1.0)


def test_a_g92_after_an_m99_restart_makes_the_last_motion_the_exit_move() -> None:
    """The G92 after the restart makes the motion in the block of the M99 the exit move (lathe 21-51)."""
    blocks = ["G19 G91 F60.", "G92 Y48.57", "G42 Y5.", "Z-26.", "{} Y13. Z-39. {}"]
    arc = "\n".join(blocks).format("M99 G03", "R25.")
    assert path(arc, 3.0)[-1] == "block-format"
    line = "\n".join(blocks).format("M99 G01", "")
    assert path(line, 3.0, 6)[2]["end"] == [0.0, 18.0, -65.0]
