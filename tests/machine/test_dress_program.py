import dataclasses

import pytest

from grind_env.control import Control, read
from grind_env.control.modal_state import Modes
from grind_env.errors import GrindError
from grind_env.machine.dress.dress_run import DressPlan, DressProgramError, run_dress
from grind_env.machine.grind import grind
from tests.machine.harness import DRESS, job
from tests.shop.programs import PLATE

AT_PRIMARY = (230.0, -0.05, 0.0)
CONTROL = Control(acceleration=1000.0, rapid_feed=15_000.0)


def plan(body: str, dress_setup: float = 8.0) -> DressPlan:
    text = f"M30\nO9100\nG71 G90 G94\n{body}\nM99\n"
    return run_dress(read(text), 9100, job(dress_setup=dress_setup), CONTROL, AT_PRIMARY, 0).plan


def seconds(length: float, feed: float) -> float:
    """Return the time of a trapezoidal motion with 1000 mm/s2; feed in mm/min."""
    v = feed / 60.0
    return length / v + v / 1000.0


def test_passes_feed_depth_and_time_of_the_usual_program() -> None:
    found = run_dress(read("M30" + DRESS), 9100, job(dress_setup=8.0), CONTROL, AT_PRIMARY, 0).plan
    assert found.passes == 2
    assert found.feed == pytest.approx(191.0 / 60.0)
    assert found.depth == pytest.approx(0.020)
    # out: 20.05 up, 350 by 40 aside, 10 down, two infeeds and passes, 10.04 up;
    # back the first four moves reversed: the link to Y9.98 above the diamond, 10 up, aside, 20.05 down
    rapid = 15_000.0
    aside = (350.0**2 + 40.0**2) ** 0.5
    expected = 8.0 + 2 * seconds(35.0, 191.0) + 2 * seconds(0.02, 60.0) + 3 * 0.0
    forth = [20.05, aside, 10.0, 10.04]
    back = [10.02, 0.02, 10.0, aside, 20.05]
    expected += sum(short_rapid(length, rapid) for length in forth)
    expected += sum(seconds(length, 60.0) if length == 0.02 else short_rapid(length, rapid) for length in back)
    assert found.seconds == pytest.approx(expected, rel=1e-9)


def short_rapid(length: float, feed: float) -> float:
    """Return the time of a motion that may be too short to reach its feed."""
    v = feed / 60.0
    return seconds(length, feed) if length >= v * v / 1000.0 else 2.0 * (length / 1000.0) ** 0.5


@pytest.mark.parametrize(
    ("body", "passes", "depth"),
    [
        ("G91 G01 Y-.01 F60.\nZ30. F300.\nY-.03 F60.\nZ-30. F300.", 2, 0.020),
        # retracting and coming back in the same direction
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nG00 Y1.\nZ-30.\nG01 Y-1.02 F60.\nZ30. F300.", 2, 0.020),
        # a spark-out pass without infeed counts as a pass
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nZ-30.", 2, 0.010),
        # an overhead dresser: the wheel goes up
        ("G91 G01 Y.015 F60.\nZ25. F300.", 1, 0.015),
        # away from the wheel any way is legal
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nZ1. Y1.", 1, 0.020),
        ("G91 G01 Y.015 F60.\nZ25. F300.\nZ1. Y-1.", 1, 0.015),
        # moves to and fro beside the wheel, or two moves at one depth, dress no form
        ("G91 G01 Z5. F500.\nY-1. F60.\nZ-5.\nY-.02\nZ30. F300.", 1, 0.020),
        # a feed move that does not cross the wheel is no pass
        ("G91 G01 Z5. F500.\nY-.02 F60.\nZ30. F300.", 1, 0.020),
    ],
)
def test_infeed_is_the_mean_over_the_passes(body: str, passes: int, depth: float) -> None:
    found = plan(body)
    assert found.passes == passes
    assert found.depth == pytest.approx(depth, abs=1e-9)
    assert found.feed == pytest.approx(5.0)


def test_inch_programs_give_millimetres() -> None:
    found = plan("G70 G91 G01 Y-.001 F2.\nZ1.2 F10.")
    assert found.depth == pytest.approx(0.0254)
    assert found.feed == pytest.approx(254.0 / 60.0)


def test_a_wider_wheel_needs_a_longer_traverse() -> None:
    body = "G91 G01 Y-.02 F60.\nZ30. F300."
    assert plan(body).passes == 1
    wide = job(setup={"wheel": dataclasses.replace(job().setup.wheel, width=65.0)})
    with pytest.raises(DressProgramError, match="65 mm along Z"):
        run_dress(read(f"M30\nO9100\n{body}\nM99\n"), 9100, wide, CONTROL, AT_PRIMARY, 0)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("G00 Y20.", "no feed move takes the diamond over the wheel"),
        ("G91 G01 Y-.02 F60.\nG00 Z30.", "no feed move takes the diamond over the wheel"),
        ("G91 G01 Y-.02 F60.\nZ20. F300.", "add one of 25 mm along Z"),
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nY-.02 F60.\nZ-30. F200.", "F200, F300"),
        ("G00 Y10.\nG01 Z30. F300.\nG91 Y-.02\nZ-30.", "part of the approach in line 4"),
        ("G01 Y10. F500.\nZ30. F300.", "before pass 1, but an infeed is at most 0.1 mm"),
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nY-.2 F60.\nZ-30. F300.", "0.2 mm along Y before pass 2"),
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nY-.02 F60.\nZ-15. Y-.5\nZ-30. F300.", "form dressing is not simulated"),
        # in steps, alone and before a pass over all of the wheel
        ("G91 G01 Y-.02 F60.\nZ17. F300.\nY-.5\nZ18.\nY.5", "form dressing is not simulated, but line 7 leads"),
        ("G91 G01 Y-.02 F60.\nZ17. F300.\nY-.05\nZ18.\nY.05\nZ-35.", "form dressing is not simulated, but line 7"),
        # a chamfer and a corner radius after the last pass
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nZ1. Y-1.", "form dressing is not simulated, but line 6 leads"),
        ("G91 G01 Y-.02 F60.\nZ30. F300.\nG19 G03 Z1. Y-1. R1.", "form dressing is not simulated, but line 6 leads"),
    ],
)
def test_programs_that_do_not_dress_are_rejected(body: str, words: str) -> None:
    with pytest.raises(DressProgramError) as caught:
        plan(body)
    assert isinstance(caught.value, GrindError)
    assert "O9100" in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "body", ["G91 G01 Z30. F300.\nZ-30.", "G00 Y10.\nG01 Z30. F300.\nZ0.", "G00 Y10.\nG01 Z30. F300.\nZ0. F900."]
)
@pytest.mark.parametrize("infeed", [None, 0.005])
def test_a_dresser_advances_by_itself_where_no_pass_has_an_infeed(body: str, infeed: float | None) -> None:
    advancing = job(setup={"dresser_infeed": infeed})
    run = run_dress(read(f"M30\nO9100\n{body}\nM99\n"), 9100, advancing, CONTROL, AT_PRIMARY, 0)
    # a way back with another feed is no pass
    assert run.plan[:3] == (1 if "F900" in body else 2, 5.0, infeed or 0.02)
    assert run.advances


def test_a_way_back_with_another_feed_is_no_pass() -> None:
    found = plan("G91 G01 Y-.02 F60.\nZ30. F300.\nZ-30. F900.\nY-.01 F60.\nZ30. F300.\nZ-30. F900.")
    assert found[:3] == (2, 5.0, pytest.approx(0.015))


@pytest.mark.parametrize("back", ["300.", "900."])
@pytest.mark.parametrize("sign", ["-", ""], ids=["the wheel comes down", "overhead"])
def test_a_way_back_off_the_diamond_is_no_pass(sign: str, back: str) -> None:
    out = "" if sign else "-"
    way = f"Y{out}2. F900.\nZ-30. F{back}\nY{sign}2.01 F60.\nZ30. F300."
    found = plan(f"G91 G01 Y{sign}.02 F60.\nZ30. F300.\n{way}\n{way}")
    # infeeds of 20, 10 and 10 um
    assert found[:3] == (3, 5.0, pytest.approx(0.04 / 3.0))


def test_an_assumed_dresser_infeed_warns_until_the_job_sets_it() -> None:
    text = PLATE.replace("N5 G91 G01 Y-.02 F60.\nN6 Z35. F191.", "N6 G91 G01 Z35. F191.").replace("N7 Y-.02 F60.\n", "")
    warned, removed = {}, {}
    for infeed in (None, 0.02, 0.01):
        found = grind(read(text), job(setup={"dresser_infeed": infeed}))
        warned[infeed] = [warning for warning in found.warnings if "O9100 has no infeed" in warning]
        removed[infeed] = found.dresses["removed"].sum()
    assert ["taken to advance 0.02 mm by itself" in warning for warning in warned[None]] == [True]
    assert warned[0.02] == warned[0.01] == []
    assert removed[None] == removed[0.02] == pytest.approx(2.0 * removed[0.01], rel=1e-3)


def test_a_dress_without_f_needs_the_f_of_its_caller() -> None:
    body = "G01 G91 Y-.02\nZ30."
    with pytest.raises(DressProgramError, match=r"O9100: it fails: .*G01 is commanded without F"):
        plan(body)
    programs, modes = read(f"M30\nO9100\n{body}\nM99\n"), Modes(feed=300.0)
    assert run_dress(programs, 9100, job(), CONTROL, AT_PRIMARY, 0, modes).plan.feed == 5.0
