import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from grind_env.machine.job import Job, JobError, PartConditions, Times, WheelStart
from grind_env.machine.record import GrindingRecord
from tests.machine.harness import CYCLE, HEAD, STROKE, job, run


def test_loading_covers_the_time_until_the_first_cycle() -> None:
    text = HEAD + CYCLE + "M30\n"
    short, long = run(text, job(load=20.0)), run(text, job(load=50.0))
    assert long.parts[0]["seconds"] - short.parts[0]["seconds"] == pytest.approx(30.0)
    assert short.strokes["time"][0] == pytest.approx(20.0)
    assert short.parts[0]["seconds"] == pytest.approx(20.0 + len(short.strokes) * STROKE, abs=1e-6)


def test_a_long_approach_takes_its_own_time() -> None:
    text = HEAD + "G04 P35.\n" + CYCLE + "M30\n"
    approach = 35.0 + 2.0 * math.sqrt(30.0 / 1000.0)
    record = run(text, job(load=20.0))
    assert record.strokes["time"][0] == pytest.approx(approach)
    assert record.parts[0]["seconds"] == pytest.approx(approach + len(record.strokes) * STROKE, abs=1e-6)


def gauged(seconds: float) -> Job:
    return dataclasses.replace(job(), times=Times(load=20.0, gauge=seconds))


def test_gauging_covers_the_time_from_m01_until_the_next_cycle() -> None:
    again = CYCLE.replace("Y-.05", "Y-.08")
    text = HEAD + CYCLE + "G80\nG00 Y20.\nM01\nG04 P2.\nG00 Y-.05\n" + again + "M30\n"
    way, brief, slow = (run(text, gauged(seconds)) for seconds in (0.0, 1.0, 30.0))
    # 2 s and the way down, 20.05 mm at 1 m/s2, are longer than a second
    assert brief.strokes["time"].tolist() == way.strokes["time"].tolist()
    later = slow.strokes["time"] - way.strokes["time"]
    assert later == pytest.approx(np.where(np.arange(len(later)) < 8, 0.0, 28.0 - 2.0 * math.sqrt(20.05 / 1000.0)))
    assert slow.parts[0]["seconds"] - way.parts[0]["seconds"] == pytest.approx(later[-1])
    # and the part cools meanwhile
    assert slow.strokes["grown"][8] < way.strokes["grown"][8] < way.strokes["grown"][7]


@pytest.mark.parametrize("stop", ["M01\nG80\n", "G80\nM00\nM01\n"], ids=["table goes on", "no part"])
def test_gauging_takes_no_time_without_a_part_or_on_a_moving_table(stop: str) -> None:
    text = HEAD + CYCLE + stop + "G00 Y20.\nG00 X-30.\nG00 Y0\n" + CYCLE + "M30\n"
    assert run(text, gauged(0.0)).strokes.tolist() == run(text, gauged(30.0)).strokes.tolist()


def test_gauging_takes_no_time_before_the_first_stroke() -> None:
    text = HEAD + "M01\nM01\n" + CYCLE + "M30\n"
    times = [dataclasses.replace(job(), times=Times(load=0.0, gauge=seconds)) for seconds in (0.0, 30.0)]
    assert run(text, times[0]).strokes.tolist() == run(text, times[1]).strokes.tolist()


def test_a_dress_takes_the_time_of_its_plan() -> None:
    text = HEAD + CYCLE.replace("P9100", "P9100 D2") + "M30\n"
    brief, slow = run(text, job(dress_setup=0.0)), run(text, job(dress_setup=100.0))
    assert slow.parts[0]["seconds"] - brief.parts[0]["seconds"] == pytest.approx(200.0)
    assert len(set(slow.dresses["seconds"])) == 1
    gap = slow.strokes["time"][2] - slow.strokes["time"][1] - slow.strokes["seconds"][1]
    assert list(slow.dresses["after"]) == [2, 4]
    assert gap == pytest.approx(slow.dresses["seconds"][0], abs=1e-6)


def test_parts_are_divided_at_m00() -> None:
    part = "G00 X-30. Y0\n" + CYCLE + "G80\nG00 Y20.\nM00\n"
    text = HEAD + "M98 P500 L3\nG00 Y100.\nM30\nO500\n" + part + "M99\n"
    record = run(text, job())
    assert list(record.parts["part"]) == [1, 2, 3]
    assert list(record.parts["strokes"]) == [8, 8, 8]
    assert (np.bincount(record.strokes["part"])[1:] == 8).all()
    first = record.strokes[record.strokes["number"] == 1]
    assert (first["ae"] == 0.0).all()  # touched off: the surface is at Z 0 again
    assert record.strokes["V"][-1] == pytest.approx(record.parts["S"].sum() * 200.0)
    # the way up after the last part belongs to it
    last = record.strokes[-1]
    assert record.seconds > last["time"] + last["seconds"]
    starts = np.cumsum(record.parts["seconds"]) - record.parts["seconds"]
    assert record.strokes["time"][record.strokes["number"] == 1] == pytest.approx(starts + 20.0)


@pytest.mark.parametrize("beside", ["", "G04 X2.\n", "G01 Y-.06 F3.\nG04 X1.5\n"])
def test_m00_on_a_moving_table_takes_effect_once_it_stops(beside: str) -> None:
    again = "G00 Y20.\nG00 X-30.\nG00 Y0\n" + CYCLE + "G80\nG00 Y20.\nM30\n"
    early = run(HEAD + CYCLE + "M00\n" + beside + "G80\n" + again, job())
    late = run(HEAD + CYCLE + beside + "G80\nM00\n" + again, job())
    assert early.parts.tolist() == late.parts.tolist() and len(early.parts) == 2
    assert early.strokes.tolist() == late.strokes.tolist()
    warned = [each for each in early.warnings if "from which no part is taken" in each]
    assert [each.startswith("test.nc:4: ") for each in warned] == [True] * bool(beside)


def test_m00_before_the_first_part_only_loads_it() -> None:
    record = run(HEAD + "M00\n" + CYCLE + "M30\n", job())
    assert list(record.parts["part"]) == [1]


def test_wear_is_compensated_by_touch_off_and_gauging() -> None:
    part = CYCLE + "G80\nG00 Y0\nG00 X-30.\n"
    for stop, compensated in (("", False), ("M01\n", True), ("M00\n", True)):
        strokes = run(HEAD + part + stop + part + "M30\n", job()).strokes
        second = strokes[np.flatnonzero(np.diff(strokes["line"]))[0] + 1]
        assert second["ae"] == 0.0
        assert bool(second["W"] == 0.0) is compensated


def test_part_conditions_change_stock_and_process() -> None:
    part = "G00 X-30. Y0\n" + CYCLE + "G80\nG00 Y20.\nM00\n"
    text = HEAD + part + part + "M30\n"

    def with_lot(factor: float) -> GrindingRecord:
        lot = PartConditions(stock=0.075, factors={"kA": factor})
        return run(text, job(), parts=(PartConditions(), lot))

    nominal, changed = run(text, job()), with_lot(10.0)
    assert list(changed.parts["stock"]) == [0.1, 0.075]
    assert changed.parts["size_error"] == pytest.approx(1000.0 * (changed.parts["stock"] - changed.parts["S"]))
    same = nominal.strokes["part"] == 1
    assert (changed.strokes[same] == nominal.strokes[same]).all()

    def growth(record: GrindingRecord) -> float:
        A = record.strokes["A"][record.strokes["part"] == 2]
        return float(A[1] - A[0])

    # growth of the wear flats is linear in kA, and their renewal does not depend on kA
    assert growth(with_lot(3.0)) - growth(with_lot(2.0)) == pytest.approx(
        growth(with_lot(2.0)) - growth(nominal), rel=1e-6
    )
    assert growth(changed) > 9.0 * growth(nominal)


def test_invalid_part_conditions_are_rejected() -> None:
    with pytest.raises(JobError, match="did you mean RaRef"):
        PartConditions(factors={"RaReff": 2.0})
    with pytest.raises(JobError, match="stock is -1"):
        PartConditions(stock=-1.0)
    part = CYCLE + "G80\nM00\n"
    with pytest.raises(JobError, match="more parts than the 1"):
        run(HEAD + part + part + "M30\n", job(), parts=(PartConditions(),))


def test_the_wheel_begins_dressed_or_in_its_given_state() -> None:
    cycle = HEAD + CYCLE + "M30\n"
    first = run(cycle, job()).strokes[0]
    # O9100 dresses with a lead of 0.1 mm and a depth of 0.02 mm, the medium dress of catalogue entries
    assert first["A"] == pytest.approx(job().setup.wheel.dressed_wear_flat, rel=1e-4)
    assert first["ds"] == 300.0
    start = WheelStart(diameter=280.0, wear_flat_area=0.03, volume_since_dress=200.0)
    worn = run(cycle, job(wheel_start=start)).strokes[0]
    assert (worn["A"], worn["V"], worn["ds"]) == (0.03, 200.0, 280.0)
    coarse = run(cycle.replace("P9100", "").replace("L2", "L3"), job()).strokes[0]
    assert coarse["A"] == pytest.approx(first["A"], rel=1e-4)


def test_parts_of_several_kinds_are_ground_in_one_run() -> None:
    cycle = "G00 X-30. Y0\n" + CYCLE + "G80\nG00 Y20.\n"
    # the second part is of a soft steel, half as long, and lies 12.5 mm higher
    higher = "G00 X-30. Y12.5\n" + CYCLE.replace("Y-.05", "Y12.45") + "G80\nG00 Y20.\n"
    soft = job(material="aisi_1020", length=100.0, surface=12.5, scrap_cost=5.0, roughness_limit=1.0).part
    kinds = (PartConditions(), PartConditions(part=soft, stock=0.05), PartConditions())
    record = run(HEAD + cycle + "M00\n" + higher + "M00\n" + cycle + "M30\n", job(), parts=kinds)
    assert record.warnings == ()
    assert [record.strokes["Lw"][record.strokes["part"] == k][0] for k in (1, 2, 3)] == [200.0, 100.0, 200.0]
    assert record.parts["stock"].tolist() == [0.1, 0.05, 0.1]
    assert np.allclose(record.parts["S"], 0.05, atol=0.005)
    # the part equals a single part with the wheel of the part before, but for loading and waves
    strokes = record.strokes[record.strokes["part"] == 1][-1]
    start = WheelStart(diameter=strokes["ds"], wear_flat_area=strokes["A"], volume_since_dress=strokes["V"])
    alone = run(HEAD + higher + "M30\n", dataclasses.replace(job(wheel_start=start), part=soft)).strokes
    second = record.strokes[record.strokes["part"] == 2]
    for name in ("Z", "ae", "power", "A", "V"):
        assert second[name] == pytest.approx(alone[name], rel=0.01), name
    hard = run(HEAD + higher + "M30\n", job(length=100.0, surface=12.5, wheel_start=start)).strokes
    assert second["power"][3] < 0.97 * hard["power"][3]


BATCH = HEAD + "M00\n".join(["G00 X-30. Y0\n" + CYCLE.replace("P9100", "P9100 D1") + "G80\nG00 Y20.\n"] * 3) + "M30\n"


def test_a_worn_out_wheel_is_changed_when_the_part_is_taken_off() -> None:
    small = WheelStart(diameter=220.1, diamond_flat=0.05)
    worn = job(wheel_start=small)
    asked = dataclasses.replace(worn, times=dataclasses.replace(worn.times, wheel_change=2400.0))
    before, after = run(BATCH, worn), run(BATCH, asked)
    assert len(before.warnings) == 1 and after.warnings == ()
    # 0.08 mm of diameter to a dress: the second one takes it below 220 mm
    diameters = [after.strokes["ds"][after.strokes["part"] == k] for k in (1, 2, 3)]
    assert diameters[0].min() > 220.0 > diameters[1][-1] and diameters[2][0] == pytest.approx(300.0, abs=1e-3)
    extra = after.parts["seconds"] - before.parts["seconds"]
    assert extra == pytest.approx([0.0, 2400.0, 0.0], abs=1e-6)
    # the program dresses the new wheel: strokes before the first dress are alike in parts 1 and 3
    flats = [after.strokes["A"][after.strokes["part"] == k][0] for k in (1, 3)]
    assert flats[1] == pytest.approx(flats[0], rel=0.05)


def test_a_new_wheel_has_factors_of_its_own() -> None:
    worn = job(wheel_start=WheelStart(diameter=220.01))
    worn = dataclasses.replace(worn, times=dataclasses.replace(worn.times, wheel_change=0.0))
    plain = run(BATCH, worn, parts=(PartConditions(),) * 3)
    rough = PartConditions(new_wheel_factors={"ra_scale": 1.5})
    other = run(BATCH, worn, parts=(rough,) * 3)
    ratio = other.parts["Ra"] / plain.parts["Ra"]
    assert ratio[0] == 1.0
    assert (ratio[1:] > 1.2).all()


def test_a_worn_wheel_is_changed_at_a_gauging_stop_within_a_part() -> None:
    two = "G00 X-30. Y0\n" + CYCLE.replace("P9100", "P9100 D1") + "{}" + CYCLE.replace("Y-.05", "Y-.08") + "M30\n"
    worn = job(wheel_start=WheelStart(diameter=220.01))
    worn = dataclasses.replace(worn, times=dataclasses.replace(worn.times, wheel_change=100.0))
    strokes = run(HEAD + two.format("M01\n"), worn).strokes
    lines = np.unique(strokes["line"])
    assert strokes["ds"][strokes["line"] == lines[0]][-1] < 220.0
    assert strokes["ds"][strokes["line"] == lines[1]][0] == pytest.approx(300.0, abs=1e-3)
    # without a stop nobody changes the wheel
    assert run(HEAD + two.format(""), worn).strokes["ds"].max() < 221.0


ENDS = "G82 X{}. I{}. Y-.05 J-.01 L2 F60. E12000. P9100\n"


def reach(text: str, **part: Any) -> Any:
    return run(HEAD + text + "M30\n", job(**{"stock": 0.05, "tolerance": 9.0, **part})).parts[0]


def test_a_part_not_fully_passed_by_the_table_is_scrap() -> None:
    whole = reach(CYCLE)
    assert whole["survival"] > 0.99 and whole["unground"] == 0.0
    for start, length, unground in ((225.0, 200.0, 0.975), (0.0, 400.0, 0.425), (240.0, 200.0, 1.0)):
        for tolerance in (9.0, 0.0):
            part = reach(CYCLE, start=start, length=length, tolerance=tolerance)
            assert part["unground"] == pytest.approx(unground)
            assert part["worst_error"] == pytest.approx(50.0)
            assert part["survival"] == 0.0
            assert part["scrap_cost"] == 40.0
            assert part["total_cost"] == pytest.approx(
                part["time_cost"] + part["wheel_cost"] + part["dress_cost"] + part["scrap_cost"]
            )


def test_a_table_may_turn_at_the_very_edge_of_the_part() -> None:
    assert reach(ENDS.format(200, 0), start=0.0)["survival"] > 0.99
    assert reach(ENDS.format(200, -30), length=200.4)["unground"] == 0.0
    assert reach(ENDS.format(200, -30), length=201.0)["unground"] > 0.0


def test_two_strokes_that_meet_grind_the_whole_part() -> None:
    halves = ENDS.format(100, -30) + "G80\nG00 Y20.\nG00 X230.\nG00 Y0\n" + ENDS.format("{}", 230)
    met, apart = (reach(halves.format(end)) for end in (100, 120))
    assert met["unground"] == 0.0 and apart["unground"] == pytest.approx(0.1)
    assert apart["worst_error"] == pytest.approx(50.0) != met["worst_error"]


def test_finishing_stock_is_left_where_only_rough_strokes_passed() -> None:
    finish = "G82 X{}. I-30. Y-.05 J-.005 L2 F60. E12000.\n"
    rough = CYCLE.replace("Y-.05", "Y-.03")
    short, whole = (reach(rough + finish.format(end)) for end in (150, 230))
    assert whole["survival"] > 0.99
    assert short["unground"] == 0.0
    assert short["worst_error"] == pytest.approx(20.0)
    assert short["survival"] < 0.01
