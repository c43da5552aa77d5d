"""Numbers that compare runs: energies and volumes are conserved, and dresses have the numbers of their programs."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

import grind_env
from grind_env.machine.grind import grind_file
from grind_env.machine.job import Diamond, PartConditions
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.machine.record import GrindingRecord
from grind_env.render.block_comparison import compared_blocks, compared_dresses
from tests.machine.harness import CYCLE, HEAD, job, run
from tests.machine.test_grooving import NEAR, groove_job

EXAMPLES = Path(grind_env.__file__).parent / "examples"
PART = "G00 X-30. Y0\n" + CYCLE + "G80\nG00 Y20.\n"


@pytest.fixture(scope="module", params=["plate_g82", "rail_g83", "keyway_g81"])
def example(request: pytest.FixtureRequest) -> GrindingRecord:
    program = EXAMPLES / f"{request.param}.nc"
    # this table reaches E over the whole part
    return grind_file(
        program, with_entries(load_job(program.with_suffix(".toml")), {"machine": {"acceleration": 5000.0}})
    )


def test_specific_energy_times_volume_is_the_power_over_the_strokes(example: GrindingRecord) -> None:
    strokes, rows = example.strokes, example.executions
    over = strokes[strokes["Lw"] > 0.0]
    integral = float((over["power"] * over["Lw"] / (over["E"] / 60.0)).sum())
    assert (rows["u_s"] * rows["ground"]).sum() == pytest.approx(integral, rel=1e-12)
    # also stroke by stroke, because no spindle is at its limit; rubbing strokes have no specific energy
    rubs = over[over["ae"] == 0.0]
    rubbed = float((rubs["power"] * rubs["Lw"] / (rubs["E"] / 60.0)).sum())
    assert integral == pytest.approx((over["u_s"] * over["ae"] * over["b"] * over["Lw"]).sum() + rubbed, rel=1e-9)


def test_volumes_sum_to_the_removed_stock(example: GrindingRecord) -> None:
    part = example.job.part
    ground = example.parts["S"] * part.width * part.length
    assert example.executions["ground"].sum() == pytest.approx(ground.sum(), rel=1e-12)


def test_specific_volumes_of_a_covered_part_are_stock_times_length() -> None:
    record = run(HEAD + PART + "M00\n" + PART.replace("E12000.", "E6000.") + "M30\n", job(stock=0.05))
    rows = record.executions
    assert rows["part"].tolist() == [1, 2] and rows["strokes"].sum() == len(record.strokes)
    assert rows["V"].tolist() == pytest.approx((200.0 * record.parts["S"]).tolist())
    assert rows["V"] * 20.0 == pytest.approx(rows["ground"])
    assert rows["speed_ratio"].tolist() == pytest.approx([150.0, 300.0], rel=1e-3)  # 30 m/s over 12 and 6 m/min


def test_peaks_of_a_block_are_the_numbers_of_its_deepest_stroke() -> None:
    record = run(HEAD + CYCLE + "M30\n", job())
    (row,), strokes = record.executions, record.strokes
    deepest = strokes[strokes["ae"].argmax()]
    assert row["peak_Q"] == deepest["Q"] == pytest.approx(200.0 * deepest["ae"])
    by_hand = 1e6 * 200.0 / (1000.0 * deepest["vs"]) * math.sqrt(deepest["ae"] / deepest["ds"])
    assert row["aggressiveness"] == pytest.approx(by_hand)


def test_a_cycle_in_the_air_has_only_zeros_to_compare() -> None:
    record = run(
        HEAD + "G00 Y5.\n" + PART.replace("G00 X-30. Y0\n", "").replace("Y-.05", "Y4.95") + PART + "M30\n",
        job(stock=0.05),
    )
    assert len(record.executions) == 2
    for row in record.executions[:1]:
        assert row["u_s"] == row["speed_ratio"] == row["peak_Q"] == row["aggressiveness"] == 0.0


def test_infeeds_of_a_grooving_wheel_are_compared_by_their_work_speed() -> None:
    record = run("G71 G94 G90 G18\nG00 X25. Z-10.\nG77 X24.9 I.02 D0 F6.\nM30\n", groove_job(), control=NEAR)
    (row,), strokes = record.executions, record.strokes
    vw = strokes["Q"] / strokes["ae"]
    assert row["speed_ratio"] == pytest.approx((1000.0 * strokes["vs"] / vw).mean())
    assert row["energy"] == pytest.approx((strokes["u_s"] * strokes["ae"] * strokes["b"] * 100.0).sum())
    assert row["ground"] == pytest.approx(record.parts["S"][0] * 100.0 * 25.0)


def test_a_dress_has_the_lead_overlap_and_severity_of_its_program() -> None:
    record = run(HEAD + CYCLE.replace("G82", "G82.1").replace("P9100", "D2 P9100") + "M30\n", job())
    dresses = record.dresses
    assert set(dresses["cause"]) == {"pre", "auto"} and dresses.size == 3
    turns = 1000.0 * 30.0 / (math.pi * 300.0)  # turns of the wheel per second; dresses hardly change its diameter
    lead = 191.0 / 60.0 / turns
    assert dresses["lead"] == pytest.approx(lead)
    width = 2.0 * math.sqrt(2.0 * 0.5 * 0.02 - 0.02**2)
    assert dresses["overlap"] == pytest.approx(width / lead, rel=1e-12)
    assert dresses["severity"] == pytest.approx(math.sqrt(lead / 0.1), rel=1e-9)
    assert compared_dresses(record) == [
        "dress O9100: lead 0.100 mm, overlap ratio 2.80, severity 1.00 of a medium dress"
    ]


def test_a_dress_that_misses_the_diamond_has_no_lead_overlap_or_severity() -> None:
    beside = replace(job(), diamond=Diamond(x=300.0, y=0.0, z=0.0))
    record = run(HEAD + CYCLE.replace("P9100", "D2 P9100") + "M30\n", beside)
    assert record.dresses.size == 2
    for name in ("lead", "overlap", "severity"):
        assert not record.dresses[name].any()
    assert compared_dresses(record) == []


def test_blocks_of_the_same_words_share_a_row() -> None:
    record = run(
        HEAD + "M00\n".join([PART] * 4) + "M30\n", job(stock=0.05), parts=tuple(PartConditions() for _ in range(4))
    )
    ((name, *texts),) = compared_blocks(record)
    assert name.endswith(" and 3 more") and len(texts) == 5
