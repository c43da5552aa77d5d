import dataclasses
import io
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from grind_env.machine.job import Job, Stage
from grind_env.machine.record import GrindingRecord
from grind_env.render.record_tables import cause_words, causes_of, print_record
from tests.machine.harness import CATALOGUE, HEAD, job, run

ROUGH = "G82 X230. I-30. Y-.03 J-.015 L0 F60. E15000. P9100\nG80\n"
FINISH = "G82 X230. I-30. Y-.05 J-.002 L3 F60. E15000.\n"
TWO = HEAD + ROUGH + "M01\n" + FINISH + "M30\n"
BOTH = {"stock": 0.05, "tolerance": 9.0}


def staged(stage: Stage | None = None, **part: Any) -> Job:
    return job(**{**BOTH, **part, "stages": (Stage(stock=0.03) if stage is None else stage,)})


def of_line(record: GrindingRecord, cycle: int) -> Any:
    """Return the strokes of a cycle, counted from 0."""
    lines = np.unique(record.strokes["line"])
    return record.strokes[record.strokes["line"] == lines[cycle]]


@pytest.fixture(scope="module")
def plain() -> GrindingRecord:
    return run(TWO, job(**BOTH))


def test_each_stage_keeps_its_own_roughness_limit(plain: GrindingRecord) -> None:
    rough, finish = (float(of_line(plain, k)["Ra"][-1]) for k in (0, 1))
    assert plain.parts[0]["survival"] > 0.99 and finish < 0.8 * rough
    # a limit that is just met is kept with a probability of one half
    met = run(TWO, staged(Stage(stock=0.03, roughness_limit=rough))).parts[0]
    assert met["survival"] == pytest.approx(0.5 * plain.parts[0]["survival"], rel=1e-6)
    both = run(TWO, staged(Stage(stock=0.03, roughness_limit=rough), roughness_limit=finish)).parts[0]
    assert both["survival"] == pytest.approx(0.25 * plain.parts[0]["survival"], rel=1e-6)
    assert both["scrap_cost"] == pytest.approx(40.0 * (1.0 - both["survival"]))
    assert both["total_cost"] == pytest.approx(
        sum(both[f"{name}_cost"] for name in ("time", "wheel", "dress", "scrap"))
    )
    assert run(TWO, staged(roughness_limit=rough)).parts[0]["survival"] > 0.99


def test_a_stage_is_judged_by_the_size_at_its_stop() -> None:
    for stock, good in ((0.03, True), (0.05, False)):
        part = run(TWO, staged(Stage(stock=stock, tolerance=13.0))).parts[0]
        assert bool(part["survival"] > 0.99) is good
        assert abs(part["size_error"]) < 9.0


def test_the_power_of_a_stage_is_counted_once(plain: GrindingRecord) -> None:
    rough, finish = (float(of_line(plain, k)["load"].max()) for k in (0, 1))
    assert finish < 0.9 * rough
    machine = CATALOGUE.machine("default")
    # at the power limit the torque is 0.98 of the stall torque, one width of the logistic step below it
    limited = dataclasses.replace(machine, power_limit=machine.idle_power + rough, stall_speed=0.98)
    part = run(TWO, dataclasses.replace(staged(), setup=dataclasses.replace(staged().setup, machine=limited))).parts[0]
    assert part["survival"] == pytest.approx(0.731059 * plain.parts[0]["survival"], rel=1e-5)
    assert (part["peak_power"], part["peak_torque"]) == pytest.approx((rough, 0.98))


def test_a_part_is_not_ground_further_after_a_spindle_stall() -> None:
    weak = dataclasses.replace(CATALOGUE.machine("default"), power_limit=1000.0, stall_speed=0.98)
    found = run(TWO, dataclasses.replace(staged(), setup=dataclasses.replace(staged().setup, machine=weak)))
    rows, part = found.strokes, found.parts[0]
    stalled = int(np.argmax(rows["torque"] >= 1.0))
    assert rows["torque"][stalled] >= 1.0 > rows["torque"][:stalled].max()
    after = rows[stalled + 1 :]
    assert (after["ae"] == 0.0).all() and (after["power"] == 0.0).all() and after.size > 10
    assert part["survival"] == 0.0
    usual = run(TWO, staged()).parts[0]
    assert part["seconds"] == pytest.approx(usual["seconds"] + weak.stall_time)


def test_the_heat_of_a_stage_counts_against_its_own_limit(plain: GrindingRecord) -> None:
    rough, finish = (float(of_line(plain, k)["T"].max()) for k in (0, 1))
    assert finish + 10.0 < rough
    assert plain.parts[0]["rise"] == pytest.approx(rough)  # it is within 0.05 mm of the end
    soft = dataclasses.replace(job().part.material, tempering_rise=50.0)
    burnt = dataclasses.replace(job(**BOTH), part=dataclasses.replace(job(**BOTH).part, material=soft))
    assert run(TWO, burnt).parts[0]["survival"] < 0.05
    asked = Stage(stock=0.03, rise_allowance=rough - 50.0)
    part = run(TWO, dataclasses.replace(burnt, part=dataclasses.replace(burnt.part, stages=(asked,)))).parts[0]
    assert part["rise"] == pytest.approx(finish)
    # the rough plunge just meets its limit
    lower = run(
        TWO, dataclasses.replace(burnt, part=dataclasses.replace(burnt.part, stages=(Stage(stock=0.03),)))
    ).parts[0]
    assert part["earlier"] == pytest.approx(0.5, rel=1e-6) and lower["earlier"] < 0.05


def test_only_a_stop_after_grinding_ends_a_stage() -> None:
    refused = staged(Stage(stock=0.03, roughness_limit=0.01))
    assert run(TWO, refused).parts[0]["survival"] < 0.01
    for text in (TWO.replace("M01\n", ""), HEAD + "M01\n" + ROUGH + FINISH + "M30\n"):
        record = run(text, refused)
        assert record.parts[0]["survival"] > 0.99
        (warning,) = record.warnings
        assert "1 stage before the last one, but the program stopped at 0 M01" in warning
    again = TWO.replace("M30", "M01\nM01\nM30")
    allowed = staged()
    assert run(again, allowed).parts[0]["survival"] == run(TWO, allowed).parts[0]["survival"]


def test_stages_apply_to_every_part() -> None:
    text = HEAD + (ROUGH + "M01\n" + FINISH + "G80\nG00 Y20.\nM00\nG00 X-30. Y0\n") * 2 + "M30\n"
    parts = run(text, staged(Stage(stock=0.03, roughness_limit=0.01))).parts
    assert len(parts) == 2 and (parts["earlier"] < 0.01).all()


def test_a_failed_stage_is_named_as_the_cause_of_scrap() -> None:
    refused = staged(Stage(stock=0.03, roughness_limit=0.01))
    assert causes_of(run(TWO, refused).parts[0], refused) == ("earlier",)
    assert causes_of(run(TWO, staged()).parts[0], staged()) == ()
    record = run(TWO, refused)
    assert cause_words(causes_of(record.parts[0], refused), record.stages[0]) == ["Ra in stage 1"]
    out = io.StringIO()
    print_record(record, "two.nc", Console(file=out))
    assert "beyond the limit of Ra in stage 1: part 1\n" in out.getvalue()


def test_the_number_of_a_failed_stage_is_named() -> None:
    first, second = Stage(stock=0.03), Stage(stock=0.05, tolerance=0.001, roughness_limit=0.01)
    asked = job(**BOTH, stages=(first, second))
    record = run(TWO.replace("M30", "M01\nM30"), asked)
    assert record.warnings == ()
    assert cause_words(causes_of(record.parts[0], asked), record.stages[0]) == ["Ra in stage 2", "size in stage 2"]


def test_stages_without_a_stop_cause_a_warning() -> None:
    asked = job(**BOTH, stages=(Stage(stock=0.03), Stage(stock=0.05)))
    (warning,) = run(TWO, asked).warnings
    assert warning.startswith("test.nc: the job has 2 stages before the last one, but the program stopped at 1 M01 ")
    assert run(TWO, staged()).warnings == ()
