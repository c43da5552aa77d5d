import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest

from grind_env.control import Control, Infeed, Source
from grind_env.machine.job import Job, Stage
from grind_env.machine.part.groove_cuts import infeed_depth
from tests.machine.harness import CATALOGUE, job, run

LENGTH, WIDTH = 100.0, 25.0  #: ground length and width of the wheel a60j, mm
START = "G71 G94 G90 G18\nG00 X25. Z-10.\n"
G1 = "G77 X20. I2. D0 F60.\n"  #: worked example G1: three infeeds to X23, X21 and X20, retracts of 0.5 mm, and out
FINE = "G77 X24.9 I.02 D0 F6.\n"  #: five infeeds of 0.02 mm
CONTROL = Control(acceleration=1000.0, rapid_feed=18_000.0, groove_retract=0.5)
NEAR = Control(acceleration=1000.0, rapid_feed=18_000.0, groove_retract=0.01)


def groove_job(*, wheel: bool = True, stiffness: float = 20_000.0, **changes: Any) -> Job:
    """Return the job of a part 100 mm long, touched at X25, with stock for five infeeds of 0.02 mm."""
    machine = dataclasses.replace(CATALOGUE.machine("default"), stiffness=stiffness)
    setup = {"grooving_wheel": wheel, "machine": machine}
    values = {"length": LENGTH, "width": WIDTH, "surface": 25.0, "stock": 0.1, "load": 20.0, **changes}
    return job(setup=setup, **values)


def motion(length: float, speed: float) -> float:
    """Return the time of a motion from rest to rest at 1000 mm/s2, s."""
    return length / speed + speed / 1000.0 if length > speed**2 / 1000.0 else 2.0 * math.sqrt(length / 1000.0)


def infeed(start: float, end: float, axis: int = 0) -> Infeed:
    def point(x: float) -> tuple[float, float, float]:
        return (x, 0.0, 0.0) if axis == 0 else (0.0, 0.0, x)

    return Infeed(
        start=point(start),
        end=point(end),
        begin=0.0,
        seconds=1.0,
        block=1,
        line=1,
        source=Source.CYCLE,
        inch=False,
        axis=axis,
        feed=6.0,
        groove=1,
    )


# --- a turning tool -------------------------------------------------------------------------------


def test_a_turning_tool_takes_time_and_nothing_else() -> None:
    record = run(START + G1 + "M30\n", groove_job(wheel=False), control=CONTROL)
    part = record.parts[0]
    legs = [motion(2.0, 1.0), motion(0.5, 300.0), motion(2.5, 1.0), motion(0.5, 300.0), motion(1.5, 1.0)]
    legs.append(motion(5.0, 300.0))
    assert part["seconds"] == pytest.approx(20.0 + sum(legs), abs=1e-9)
    assert (part["strokes"], part["infeeds"], part["dresses"]) == (0, 3, 0)
    assert (part["S"], part["worn"], part["peak_power"], part["rise"]) == (0.0, 0.0, 0.0, 0.0)
    assert part["size_error"] == pytest.approx(100.0)
    rows = record.strokes
    assert list(rows["Z"]) == pytest.approx([2.0, 4.0, 5.0])
    assert list(rows["seconds"]) == pytest.approx([legs[0], legs[2], legs[4]])
    assert rows["time"] == pytest.approx([20.0, 20.0 + sum(legs[:2]), 20.0 + sum(legs[:4])])
    assert (list(rows["groove"]), list(rows["number"]), set(rows["E"])) == ([1, 1, 1], [0, 0, 0], {60.0})
    assert (rows["ae"] == 0.0).all() and (rows["power"] == 0.0).all()
    assert record.warnings == ()


def test_grooves_of_a_turning_tool_do_not_affect_the_wheel_of_a_later_cycle() -> None:
    cycle = "G00 X-130. Y0 Z0\nG19 G82 X130. I-130. Y-.02 J-.01 F60. E12000. P9100\nM30\n"
    grooved = run(START + G1 + cycle, groove_job(wheel=False, surface=0.0), control=CONTROL)
    plain = run(START + cycle, groove_job(wheel=False, surface=0.0), control=CONTROL)
    assert list(grooved.strokes["groove"]) == [1, 1, 1, 0, 0, 0]
    for name in ("A", "ae", "T"):
        assert list(grooved.strokes[name][3:]) == list(plain.strokes[name])


# --- the process model ----------------------------------------------------------------------------


def test_an_infeed_equals_a_stroke_of_the_same_removal_rate() -> None:
    # a pick of 0.02 mm at E12000 over 100 mm removes 4 mm2/s, as an infeed at 0.04 mm/s over 100 mm does
    stroke = run(
        "G71 G94 G90 G19\nG00 X-30. Y0 Z0\nG82 X130. I-30. Y-.02 J-.02 F60. E12000.\nM30\n", groove_job(surface=0.0)
    ).strokes[1]
    groove = run(START + "G77 X24.98 I.02 D0 F2.4\nM30\n", groove_job(), control=NEAR).strokes[0]
    for name in ("b", "Lw", "ae", "Q", "power", "T", "G", "dw", "Ra", "A", "V", "ds"):
        assert groove[name] == pytest.approx(stroke[name], rel=1e-6), name
    assert stroke["ae"] > 0.005


def test_infeeds_have_the_removal_rate_of_plunge_grinding() -> None:
    # Q' = pi dw vf: a part of 100 mm circumference at 6 mm/min, on the stiffest machine
    rows = run(START + FINE + "M30\n", groove_job(stiffness=500_000.0), control=NEAR).strokes
    assert (rows["ae"] + rows["dw"])[1:] - np.diff(rows["grown"]) == pytest.approx([0.02] * 4, rel=1e-2)
    assert rows["Q"][1:] == pytest.approx([LENGTH * 0.1] * 4, rel=0.05)
    assert (rows["Lw"] == LENGTH).all() and (rows["b"] == WIDTH).all()


def test_grooving_conserves_stock_wheel_and_cost() -> None:
    record = run(START + "G77 X24.9 Z-70. I.02 K30. D0 F6.\nM30\n", groove_job(), control=NEAR)
    rows, part = record.strokes, record.parts[0]
    assert len(rows) == part["infeeds"] == 15
    assert list(rows["groove"]) == [1] * 5 + [2] * 5 + [3] * 5
    assert rows["V"][-1] == pytest.approx(rows["ae"].sum() * LENGTH)
    assert part["S"] * 3 == pytest.approx(rows["ae"].sum())
    assert 300.0 - rows["ds"][-1] == pytest.approx(2.0 * rows["dw"].sum())
    assert part["worn"] == pytest.approx(rows["worn"].sum())
    assert part["peak_power"] == rows["power"].max()
    assert part["burn_ratio"] == rows["burn_ratio"].max() > 0.0
    # Q' times the time of the feed over 0.02 mm is the volume
    assert rows["Q"] * 0.02 / 0.1 == pytest.approx(rows["ae"] * LENGTH)
    total = sum(part[name] for name in ("time_cost", "wheel_cost", "dress_cost", "scrap_cost"))
    assert part["total_cost"] == pytest.approx(total)


def test_a_groove_lags_by_deflection_wheel_wear_and_growth() -> None:
    record = run(START + FINE + "M30\n", groove_job(), control=NEAR)
    rows = record.strokes
    residual = rows["Z"] - np.cumsum(rows["ae"])
    yielded = rows["Fn"] * WIDTH / 20_000.0
    worn_before = rows["W"] - rows["dw"]
    assert residual == pytest.approx(yielded + worn_before - rows["grown"], rel=1e-6)
    assert record.parts[0]["size_error"] == pytest.approx(1000.0 * residual[-1])
    assert record.parts[0]["Ra"] == rows["Ra"][-1]


def test_outer_and_inner_grooves_are_alike() -> None:
    outer = run(START + "G77 X24.9 Z-50. I.02 K40. D0 F6.\nM30\n", groove_job(), control=NEAR).strokes
    inner = run(START + "G77 X25.1 Z-50. I.02 K40. D0 F6.\nM30\n", groove_job(), control=NEAR).strokes
    assert outer["ae"].min() > 0.0
    for name in ("Z", "ae", "power", "T", "ds"):
        assert list(inner[name]) == pytest.approx(list(outer[name])), name


def test_face_grooves_remove_as_much_as_outer_grooves() -> None:
    text = "G71 G94 G90 G18\nG00 X10. Z2.\nG76 X90. Z1.9 I80. K.02 D0 F6.\nM30\n"
    face = run(text, groove_job(surface=2.0), control=NEAR).strokes
    outer = run(START + "G77 X24.9 Z-90. I.02 K80. D0 F6.\nM30\n", groove_job(), control=NEAR).strokes
    assert list(face["ae"]) == pytest.approx(list(outer["ae"]))


@pytest.mark.parametrize(("spacing", "width"), [("40.", 25.0), ("25.", 25.0), ("10.", 10.0), ("2.5", 2.5)])
def test_a_groove_beside_another_cuts_only_the_remaining_width(spacing: str, width: float) -> None:
    text = START + f"G91 G77 X-.1 Z-{spacing} I.02 K{spacing} D0 F6.\nM30\n"
    rows = run(text, groove_job(), control=NEAR).strokes
    assert list(rows["b"]) == pytest.approx([WIDTH] * 5 + [width] * 5)


def test_infeeds_below_the_neighbouring_groove_cut_the_whole_width() -> None:
    text = START + "G77 X24.96 I.02 D0 F6.\nG00 Z-20.\nG77 X24.9 I.02 D0 F6.\nM30\n"
    rows = run(text, groove_job(), control=NEAR).strokes
    assert list(rows["b"]) == pytest.approx([25.0, 25.0, 10.0, 10.0, 25.0, 25.0, 25.0])


def test_grooves_of_opposite_sides_do_not_share_their_width() -> None:
    text = START + FINE + "G00 Z-20.\nG77 X25.1 I.02 D0 F6.\nM30\n"
    rows = run(text, groove_job(), control=NEAR).strokes
    assert (rows["b"] == WIDTH).all()


def test_infeeds_through_air_cut_nothing() -> None:
    away = run(START.replace("X25.", "X25.05") + FINE.replace("I.02", "I.03") + "M30\n", groove_job(), control=NEAR)
    rows = away.strokes
    assert list(rows["Z"]) == pytest.approx([-0.02, 0.01, 0.04, 0.07, 0.1])
    assert (rows["ae"][0], rows["Lw"][0], rows["T"][0]) == (0.0, 0.0, 0.0)
    assert (rows["ae"][1:] > 0.0).all()
    assert rows["ae"][1] < 0.01
    again = run(START + FINE + FINE + "M30\n", groove_job(), control=NEAR)
    once = run(START + FINE + "M30\n", groove_job(), control=NEAR)
    assert (again.strokes["ae"][5:] == 0.0).all()
    assert again.parts[0]["S"] == once.parts[0]["S"]


@pytest.mark.parametrize(("start", "end", "depth"), [(25.0, 23.0, 2.0), (25.0, 27.0, 2.0), (26.0, 25.5, -0.5)])
def test_depth_counts_from_the_surface_in_the_direction_of_the_infeed(start: float, end: float, depth: float) -> None:
    assert infeed_depth(infeed(start, end), 25.0) == pytest.approx(depth)
    assert infeed_depth(infeed(start, end, axis=2), 25.0) == pytest.approx(depth)


# --- parts ----------------------------------------------------------------------------------------


def test_heat_counts_near_the_bottom_of_each_groove() -> None:
    # a shallow gentle groove, and a deep one that is first cut hard and then gently
    blocks = "G77 X24.9 I.01 D0 F1.\nG00 Z-60.\nG77 X24.8 I.02 D0 F9.\nG77 X24.7 I.01 D0 F1.\nM30\n"
    control = dataclasses.replace(NEAR, groove_retract=0.005)
    record = run(START + blocks, groove_job(), control=control)
    rows = record.strokes
    # the second block to X24.7 goes 0.2 mm through the existing groove
    cutting = rows["ae"] > 0.0
    depth = np.where(rows["line"] == 3, 0.1, 0.3)
    counts = cutting & (rows["Z"] >= depth - 0.05 - 1e-9)
    assert 0.0 < rows["T"][counts].max() < rows["T"][cutting & ~counts].max()
    assert record.parts[0]["rise"] == rows["T"][counts].max()
    allowed = run(START + blocks, groove_job(rise_allowance=100.0), control=control)
    assert allowed.parts[0]["rise"] == rows["T"].max()


def test_the_heat_of_a_groove_counts_in_its_own_stage() -> None:
    text = START + "G77 X24.9 I.02 D0 F9.\n{}G77 X24.894 I.006 D0 F1.\nM30\n"
    control = dataclasses.replace(NEAR, groove_retract=0.005)
    plain = run(text.format(""), groove_job(), control=control)
    staged = run(text.format("M01\n"), groove_job(stock=0.12, stages=(Stage(stock=0.1),)), control=control)
    hard, gentle = (staged.strokes["T"][staged.strokes["line"] == line].max() for line in (3, 5))
    assert 0.0 < gentle < 0.95 * hard
    assert plain.parts[0]["rise"] == pytest.approx(hard)  # it is within 0.05 mm of the bottom
    assert staged.parts[0]["rise"] == gentle


def test_groove_depth_counts_only_for_a_part_without_ground_surfaces() -> None:
    demands = {"tolerance": 30.0, "roughness_limit": 1.0}
    grooved = run(START + FINE + "M30\n", groove_job(**demands), control=NEAR).parts[0]
    assert abs(grooved["size_error"]) < 30.0
    assert grooved["survival"] > 0.9
    turned = run(START + FINE + "M30\n", groove_job(wheel=False, **demands), control=NEAR).parts[0]
    assert turned["survival"] < 0.1
    face = "G00 X30. Z0\nG19 G00 X-30. Y25.\nG82 X130. I-30. Y24.98 J-.01 L2 F60. E12000.\nM30\n"
    mixed = run(START + FINE + face, groove_job(), control=NEAR)
    ground = mixed.strokes["ae"][mixed.strokes["groove"] == 0].sum()
    assert mixed.parts[0]["S"] == pytest.approx(ground)
    assert mixed.parts[0]["infeeds"] == 5


def test_parts_are_divided_at_m00() -> None:
    text = START + FINE + "M00\n" + FINE + "M30\n"
    record = run(text, groove_job(), control=NEAR)
    assert list(record.parts["infeeds"]) == [5, 5]
    assert list(np.bincount(record.strokes["part"])[1:]) == [5, 5]
    assert (record.parts["S"] > 0.05).all()
    first = record.strokes[[0, 5]]
    assert first["time"] == pytest.approx([20.0, record.parts["seconds"][0] + 20.0])


# --- warnings and errors --------------------------------------------------------------------------


def test_an_infeed_beyond_the_model_warns_once_per_block() -> None:
    coarse = run(START + "G77 X24.4 I.3 D0 F60.\nM30\n", groove_job(), control=NEAR)
    cuts, stalls = coarse.warnings
    assert cuts.startswith("test.nc:3: an infeed cuts 0.")
    assert stalls.startswith("test.nc:3: in an infeed the spindle stalls") and "take smaller steps" in stalls
    creeping = run(START + "G77 X24.9 I.05 D0 F.06\nM30\n", groove_job(), control=NEAR)
    # 100 mm in the 50 s of an infeed are 120 mm/min
    (slow,) = creeping.warnings
    assert slow.startswith("test.nc:3: ") and "at 120 mm/min" in slow and "holds from 3000 to 40000 mm/min" in slow
    assert run(START + FINE + "M30\n", groove_job(), control=NEAR).warnings == ()


def test_a_surface_out_of_reach_warns_once() -> None:
    text = START + FINE + "M00\n" + FINE + "M30\n"
    record = run(text, groove_job(surface=0.0), control=NEAR)
    assert record.warnings == (
        "test.nc: no infeed reaches the part, whose surface is at 0; set part.surface to where the wheel touches",
    )
    assert (record.strokes["ae"] == 0.0).all()
    assert run(text, groove_job(surface=0.0, wheel=False), control=NEAR).warnings == ()


def test_an_infeed_that_destroys_the_wheel_warns_once() -> None:
    record = run(START + "G77 X5. I20. D0 F.01\nM30\n", groove_job(), control=NEAR)
    found = [warning for warning in record.warnings if "destroys the wheel" in warning]
    assert len(found) == 1
    assert re.match(r"test\.nc:3: an infeed .* at F0\.01 mm/min destroys the wheel; take", found[0])


def test_a_spindle_stall_in_a_groove_costs_time_and_the_part_and_warns() -> None:
    text = START + "G77 X24.4 I.2 D0 F60.\nG77 X24. I.2 D0 F60.\nM30\n"
    strong, weak = (groove_job(), groove_job())
    machine = dataclasses.replace(weak.setup.machine, power_limit=900.0, stall_time=450.0)
    strong = dataclasses.replace(
        strong, setup=dataclasses.replace(strong.setup, machine=dataclasses.replace(machine, power_limit=100_000.0))
    )
    weak = dataclasses.replace(weak, setup=dataclasses.replace(weak.setup, machine=machine))
    usual, stalled = (run(text, shop, control=NEAR) for shop in (strong, weak))
    first = int(np.argmax(stalled.strokes["torque"] >= 1.0))
    assert stalled.strokes["torque"][first] >= 1.0 > usual.strokes["torque"].max()
    assert (stalled.strokes["ae"][first + 1 :] == 0.0).all()
    later = np.where(np.arange(len(usual.strokes)) > first, 450.0, 0.0)
    assert stalled.strokes["time"] - usual.strokes["time"] == pytest.approx(later)
    (part,), (plain,) = stalled.parts, usual.parts
    assert part["seconds"] - plain["seconds"] == pytest.approx(450.0)
    assert part["survival"] == 0.0
    (warning,) = (each for each in stalled.warnings if "the spindle stalls" in each)
    assert warning.startswith("test.nc:3: in an infeed the spindle stalls, which has 0.9 kW")
    assert "450 s are lost; take smaller steps or a lower F" in warning
