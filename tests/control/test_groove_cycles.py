import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import ControlError, Infeed, Line, Position, Rapid, Source, read
from grind_env.control.block_decoding import decode
from grind_env.control.block_words import read_block
from grind_env.control.groove_cycles import GroovePlan, divided, groove_legs, groove_positions, plan_groove
from grind_env.control.modal_state import Modes
from grind_env.control.numbers import NumberFormat
from tests.control.harness import motions

FEED = Modes(feed=0.1)
LETTERS = "XYZ"
INFEED_AXES = {("G77", "G17"): 1, ("G77", "G18"): 0, ("G77", "G19"): 2} | {
    ("G76", "G17"): 0,
    ("G76", "G18"): 2,
    ("G76", "G19"): 1,
}
#: from "the first and the second axis of the plane": XY, ZX, YZ
SPACING_AXES = {("G77", "G17"): 0, ("G77", "G18"): 2, ("G77", "G19"): 1} | {
    ("G76", "G17"): 1,
    ("G76", "G18"): 0,
    ("G76", "G19"): 2,
}


def plan(text: str, position: Position, e: float = 0.5, modes: Modes = FEED) -> GroovePlan:
    block = read_block(next(iter(read(text).main.blocks)))
    return plan_groove(decode(block, modes, NumberFormat()), position, e)


def path(text: str, position: Position, e: float = 0.5, modes: Modes = FEED) -> str:
    """Return the legs by the axis that moves: `fX23` for an infeed, `rZ-15` for a rapid."""
    words = []
    here = position
    for leg in groove_legs(plan(text, position, e, modes)):
        (axis,) = (axis for axis in range(3) if leg.end[axis] != here[axis])
        words.append(f"{'f' if leg.kind == 'infeed' else 'r'}{LETTERS[axis]}{leg.end[axis]:g}")
        here = leg.end
    return " ".join(words)


def refusal(text: str, position: Position = (25.0, 0.0, -10.0), modes: Modes = FEED) -> ControlError:
    with pytest.raises(ControlError) as caught:
        plan(text, position, modes=modes)
    return caught.value


# --- worked examples of grooving-g77.md, section 4 -----------------------------------------------

ONE_GROOVE = "fX23 rX23.5 fX21 rX21.5 fX20 rX25"


def test_g1_a_groove_is_cut_in_steps_with_retracts() -> None:
    assert path("G77 X20 I2 D0 F0.1", (25.0, 0.0, -10.0), modes=Modes()) == ONE_GROOVE


def test_g2_last_spacing_is_shorter() -> None:
    found = path("G77 X20 Z-22 I2 K5 D0", (25.0, 0.0, -10.0))
    assert found == f"{ONE_GROOVE} rZ-15 {ONE_GROOVE} rZ-20 {ONE_GROOVE} rZ-22 {ONE_GROOVE}"


def test_g3_even_spacing_has_no_duplicate_at_the_end() -> None:
    assert list(groove_positions(plan("G77 X20 Z-20 I2 K5 D0", (25.0, 0.0, -10.0)))) == [-10.0, -15.0, -20.0]


def test_g4_a_spacing_beyond_the_last_groove_is_shortened() -> None:
    assert list(groove_positions(plan("G77 X20 Z-13 I2 K5 D0", (25.0, 0.0, -10.0)))) == [-10.0, -13.0]


def test_g5_cutoff_shifts_before_it_withdraws() -> None:
    found = path("G77 X0 I5 D0.2", (12.0, 0.0, -30.0), e=0.25)
    assert found == "fX7 rX7.25 fX2 rX2.25 fX0 rZ-29.8 rX12"


def test_g6_diameter_mode_gives_the_same_path() -> None:
    assert path("G08 G77 X40 I2 D0", (25.0, 0.0, -10.0)) == ONE_GROOVE
    assert path("G08 G91 G77 X-10 I2 D0", (25.0, 0.0, -10.0)) == ONE_GROOVE


def test_g7_an_inside_groove_is_cut_outwards() -> None:
    assert path("G77 X26 I3 D0", (20.0, 0.0, -10.0), e=0.25) == "fX23 rX22.75 fX26 rX20"


def test_g8_g76_cuts_face_grooves() -> None:
    one = "fZ-0.5 rZ0 fZ-3 rZ-2.5 fZ-4 rZ2"
    found = path("G76 X18 Z-4 I4 K2.5 D0", (10.0, 0.0, 2.0))
    assert found == f"{one} rX14 {one} rX18 {one}"


def test_figure_23_2_has_the_stated_numbers_of_legs() -> None:
    # three grooves with one I, three I + e, four e and a shorter last infeed each, and three D (23-3)
    start = (25.0, 0.0, -10.0)
    legs = list(groove_legs(plan("G77 X16 Z-20 I2 K5 D.2", start)))
    begins = [start, *(leg.end for leg in legs)]
    infeeds = [abs(leg.end[0] - here[0]) for here, leg in zip(begins, legs, strict=False) if leg.kind == "infeed"]
    backs = [leg.end[0] - here[0] for here, leg in zip(begins, legs, strict=False) if leg.kind == "rapid"]
    shifts = [leg for here, leg in zip(begins, legs, strict=False) if leg.end[0] == here[0] == 16.0]
    assert infeeds == pytest.approx(3 * [2.0, 2.5, 2.5, 2.5, 1.5])
    assert sum(math.isclose(back, 0.5) for back in backs) == 12
    assert len(shifts) == 3
    assert legs[-1].end == (25.0, 0.0, -19.8)


# --- words and modes ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("G77 X20 Z-22 I-2 K-5 D0", "G77 X20 Z-22 I2 K5 D0"),
        ("G91 G77 X-5 Z-12 I2 K5 D.2", "G77 X20 Z-22 I2 K5 D.2"),
        ("G91 G77 X-5 G90 Z-22 I2 K5 D0", "G77 X20 Z-22 I2 K5 D0"),
        ("G77 X20 I2 K0 D0", "G77 X20 I2 D0"),
        ("G77 X20 Z-10 I2 D0", "G77 X20 I2 D0"),
        ("G77 X20 Z-22 I7 K12 D0", "G77 X20 Z-22 I5 K99 D0"),
        ("G77 X20 I2 D0 F3 S500 T0101 E9", "G77 X20 I2 D0"),
        ("G70 G77 X.5 I.1 D.01", "G77 X12.7 I2.54 D.254"),
    ],
)
def test_equivalent_blocks_give_the_same_path(text: str, same: str) -> None:
    assert path(text, (25.0, 0.0, -10.0)) == path(same, (25.0, 0.0, -10.0))


def test_a_retract_of_zero_adds_no_leg() -> None:
    assert path("G77 X20 I2 D0", (25.0, 0.0, -10.0), e=0.0) == "fX23 fX21 fX20 rX25"


def test_a_shift_onto_the_next_groove_adds_no_move_to_it() -> None:
    assert path("G77 X24 Z-15 I2 K5 D-5", (25.0, 0.0, -10.0)) == "fX24 rZ-15 rX25 fX24 rZ-20 rX25"


def test_floating_point_residue_adds_neither_an_infeed_nor_a_groove() -> None:
    # 12.3 - 12 is a little more than three times 0.1, and 0.1 + 0.2 is not 0.3
    found = path("G77 X12 Z.3 I.1 D0", (12.3, 0.0, 0.1 + 0.2), e=0.05)
    assert found == "fX12.2 rX12.25 fX12.1 rX12.15 fX12 rX12.3"


@pytest.mark.parametrize("code", ["G76", "G77"])
@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
def test_the_groove_axes_follow_from_the_plane(code: str, plane: str) -> None:
    # 22-2: in another plane the axes are exchanged; in G18 the roles are those of G1 and G8
    infeed, space = INFEED_AXES[code, plane], SPACING_AXES[code, plane]
    start = [7.0, 7.0, 7.0]
    start[infeed], start[space] = 25.0, -10.0
    text = f"{plane} {code} {LETTERS[infeed]}20 {LETTERS[space]}-15 {'IJK'[infeed]}2 {'IJK'[space]}5 D0"
    one = ONE_GROOVE.replace("X", LETTERS[infeed])
    assert path(text, (start[0], start[1], start[2])) == f"{one} r{LETTERS[space]}-15 {one}"


# --- in a program ---------------------------------------------------------------------------------


def test_a_groove_acts_once_and_its_feed_stays_modal() -> None:
    text = "G71 G94 G18 G08 G00 X50. Z-10.\nG77 X40. I2. D0 F90.\nX60.\nG01 Z-12.\nM30"
    _, *cycle, away, line = motions(text)
    assert [motion.end[0] for motion in cycle] == [23.0, 23.5, 21.0, 21.5, 20.0, 25.0]
    assert [type(motion) for motion in cycle] == [Infeed, Rapid] * 3
    assert {motion.source for motion in cycle} == {Source.CYCLE}
    infeeds = [motion for motion in cycle if isinstance(motion, Infeed)]
    assert {(motion.axis, motion.feed, motion.groove, motion.line) for motion in infeeds} == {(0, 90.0, 1, 2)}
    # 2.5 mm at 1.5 mm/s, with ramps of 1000 mm/s2
    assert infeeds[1].seconds == pytest.approx(2.5 / 1.5 + 1.5 / 1000.0)
    assert isinstance(away, Rapid) and away.end == (30.0, 0.0, -10.0)
    assert isinstance(line, Line) and line.feed == 90.0


# --- errors ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "name", "word", "words"),
    [
        ("N7 G77 X20 I2 D0 Z-12 K0", "out-of-range", "K0", "K0 counts as 0"),
        ("N7 G76 Z-12 K2 D0 X12", "missing-parameter", "G76", "lacks I, the spacing of the grooves up to X12"),
        ("N7 G76 Z-12 I2 D0", "missing-parameter", "G76", "lacks K, the infeed of each step"),
        ("N7 G77 X20 I2 D0 Y3", "block-format", "Y3", "where X infeeds and Z spaces"),
        ("N7 G17 G76 X20 I2 D0 K3", "block-format", "K3", "where X infeeds and Y spaces"),
        ("N7 G77 X20 I2 D0 P3", "block-format", "P3", "no meaning"),
        ("N7 G77 X20 I2 D1234567.", "number-format", "D", "integer digits"),
    ],
)
def test_a_faulty_groove_word_is_refused_by_name_block_and_column(text: str, name: str, word: str, words: str) -> None:
    error = refusal(text)
    assert (error.name, error.block) == (name, 7)
    assert error.column == text.index(word) + 1
    assert words in error.message


def test_a_groove_needs_a_feed_which_may_be_an_earlier_one() -> None:
    error = refusal("G77 X20 I2 D0", modes=Modes())
    assert (error.name, error.column) == ("no-feedrate", 1)
    assert path("G77 X20 I2 D0", (25.0, 0.0, -10.0), modes=Modes(feed=3.0)) == ONE_GROOVE


# --- properties -----------------------------------------------------------------------------------

microns = st.integers(1, 30_000)
signs = st.sampled_from([-1, 1])


def mm(um: int) -> str:
    return f"{um / 1000:.3f}"


@given(total=st.integers(1, 10_000_000), step=st.integers(1, 50_000_000), count=st.integers(1, 2000))
def test_divided_covers_the_way_in_the_fewest_steps(total: int, step: int, count: int) -> None:
    step = max(step, -(-total // count))
    ways = list(divided(total / 1000, step / 1000))
    assert len(ways) == -(-total // step)
    assert ways[-1] == total / 1000
    assert [round(1000 * way) for way in ways[:-1]] == [step * k for k in range(1, len(ways))]


@st.composite
def grooving(draw: st.DrawFn) -> tuple[str, Position, float, dict[str, int]]:
    """Return a block, the tool position and e in mm, and the words of the block in micrometres."""
    word = {
        "depth": draw(microns),
        "down": draw(signs),
        "distance": draw(st.just(0) | microns),
        "way": draw(signs),
        "shift": draw(st.just(0) | st.integers(-2000, 2000)),
        "x": draw(st.integers(-30_000, 30_000)),
        "z": draw(st.integers(-30_000, 30_000)),
    }
    word["step"] = draw(st.integers(-(-word["depth"] // 20) + 1, 40_000))
    word["retract"] = draw(st.integers(0, word["step"] - 1))
    word["spacing"] = draw(st.integers(-(-word["distance"] // 6) + 1, 40_000))
    if draw(st.booleans()):
        text = f"G91 G77 X{mm(word['down'] * word['depth'])} Z{mm(word['way'] * word['distance'])}"
    else:
        bottom, last = word["x"] + word["down"] * word["depth"], word["z"] + word["way"] * word["distance"]
        text = f"G90 G77 X{mm(bottom)} Z{mm(last)}"
    text += f" I{mm(word['step'])} K{mm(word['spacing'])} D{mm(word['shift'])}"
    return text, (word["x"] / 1000, 3.0, word["z"] / 1000), word["retract"] / 1000, word


@given(grooving())
def test_random_grooves_are_cut_once_and_to_the_bottom(case: tuple[str, Position, float, dict[str, int]]) -> None:
    text, start, e, word = case
    here = start
    depth, cut = {}, {}
    for leg in groove_legs(plan(text, start, e)):
        across, before, after = leg.end[2], *(1000 * word["down"] * (x - start[0]) for x in (here[0], leg.end[0]))
        assert leg.end[1] == 3.0
        assert -1e-3 < after < word["depth"] + 1e-3
        if leg.kind == "infeed":
            reached = depth.get(across, 0.0)
            assert here[2] == across
            assert before - 1e-3 < reached < after - 0.5
            assert after - reached <= word["step"] + 1e-3
            assert reached - before == pytest.approx(word["retract"] if reached else 0.0, abs=1e-3)
            depth[across], cut[across] = after, cut.get(across, 0.0) + after - reached
        else:
            assert after <= before + 1e-3
        here = leg.end
    assert list(cut.values()) == pytest.approx([word["depth"]] * len(cut))
    places = [1000 * word["way"] * (across - start[2]) for across in cut]
    assert places[0] == 0.0
    assert places[-1] == pytest.approx(word["distance"], abs=1e-3)
    gaps = [b - a for a, b in itertools.pairwise(places)]
    assert gaps[:-1] == pytest.approx([word["spacing"]] * len(gaps[:-1]))
    assert all(0.0 < gap <= word["spacing"] + 1e-3 for gap in gaps)
    assert here == pytest.approx((start[0], 3.0, start[2] + (word["way"] * word["distance"] + word["shift"]) / 1000))
