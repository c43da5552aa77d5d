import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grind_env
from grind_env.control import Control, ControlError, Event, Execution, Programs, Spindle, read, read_file
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.machine import grind as grind_module
from grind_env.machine.dress.dress_run import DressProgramError
from grind_env.machine.grind import GrindingError, grind
from grind_env.machine.job import Diamond, PartConditions
from grind_env.machine.job.job_file import load_job
from grind_env.machine.record import GrindingRecord
from tests.machine.harness import CATALOGUE, CYCLE, DRESS, HEAD, STILL, job, run

EXAMPLES = Path(grind_env.__file__).parent / "examples"


def example(name: str) -> GrindingRecord:
    return grind(read_file(EXAMPLES / f"{name}.nc"), load_job(EXAMPLES / f"{name}.toml"))


def cutting(record: GrindingRecord) -> Any:
    """Return the strokes that cut at least 3 um, without spark-out."""
    return record.strokes[record.strokes["ae"] >= 0.003]


# --- examples -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["keyway_g81", "plate_g82", "rail_g83"])
def test_examples_lie_in_the_orders_of_magnitude_of_the_literature(name: str) -> None:
    record = example(name)
    strokes, part = cutting(record), record.parts[0]
    assert record.warnings == ()
    assert part["survival"] > 0.9
    assert ((strokes["u_s"] > 20.0) & (strokes["u_s"] < 130.0)).all()
    power_per_width = strokes["power"] / strokes["b"]
    assert ((power_per_width > 30.0) & (power_per_width < 200.0)).all()
    # the film may boil, but nothing tempers; early wear lowers the first G-ratios
    assert ((strokes["T"] > 50.0) & (strokes["T"] < 450.0)).all()
    assert ((strokes["G"] > 2.0) & (strokes["G"] < 100.0)).all()
    assert 0.2 < part["Ra"] < 0.8
    assert abs(part["size_error"]) < 6.0  # ground warm, a part may be too thin


def test_examples_make_the_expected_dresses_and_strokes() -> None:
    # plate: 17 picks, coverage; an idle stroke to the secondary; 6 picks, coverage, 4 spark-out strokes
    plate = example("plate_g82")
    assert plate.parts[0]["strokes"] == 17 + 1 + 0 + 6 + 1 + 4
    assert list(plate.dresses["after"]) == [9]
    rail = example("rail_g83")
    assert list(rail.dresses["cause"]) == ["auto"] * 3
    assert rail.parts[0]["taper"] > 0.1


# --- depth ----------------------------------------------------------------------------------------


def test_a_stroke_has_the_depth_at_its_middle() -> None:
    # 260 mm at 200 mm/s take 1.5 s; a feed of 0.01 mm/s runs beside, from 0 at time 0
    text = HEAD + "G81 X230. I-30. E12000.\nG01 Y-.1 F.6\nG80\nM30\n"
    control = Control(acceleration=1000.0, rapid_feed=1e6, reversal_dwell=0.0)
    depths = run(text, job(), control=control).strokes["Z"]
    # the wheel reaches X-30 Y0 first; strokes and feed start together
    assert depths[:6] == pytest.approx([0.01 * (0.75 + 1.5 * k) for k in range(6)], abs=1e-6)


def test_depth_counts_from_the_surface_of_the_job() -> None:
    here = run(HEAD + CYCLE + "M30\n", job()).strokes
    moved = HEAD.replace("Y0", "Y12.5") + CYCLE.replace("Y-.05", "Y12.45") + "M30\n"
    there = run(moved, job(surface=12.5)).strokes
    assert there["Z"] == pytest.approx(here["Z"], abs=1e-12)
    assert there["T"] == pytest.approx(here["T"], rel=1e-6)


def test_no_cut_above_the_surface() -> None:
    text = HEAD.replace("Y0", "Y.5") + CYCLE.replace("Y-.05", "Y.45") + "M30\n"
    record = run(text, job())
    assert (record.strokes["ae"] == 0.0).all()
    assert (record.strokes["power"] == 0.0).all()
    assert record.parts[0]["S"] == 0.0
    assert record.parts[0]["size_error"] == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("start", "length", "ground"), [(0.0, 200.0, 200.0), (100.0, 200.0, 130.0), (-80.0, 90.0, 40.0)]
)
def test_ground_length_is_the_overlap_of_stroke_and_part(start: float, length: float, ground: float) -> None:
    record = run(HEAD + CYCLE + "M30\n", job(start=start, length=length))
    assert (record.strokes["Lw"] == ground).all()


def test_a_stroke_beside_the_part_grinds_nothing() -> None:
    for beside in (job(start=240.0), job(across=26.0), job(across=-20.0)):
        record = run(HEAD + CYCLE + "M30\n", beside)
        assert (record.strokes["ae"] == 0.0).all()
        assert (record.strokes["b"] == 0.0).all()
        assert np.ptp(record.strokes["ds"]) == 0.0


# --- dresses --------------------------------------------------------------------------------------


def test_dresses_are_recorded_with_cause_count_and_cost() -> None:
    text = HEAD + CYCLE.replace("G82", "G82.1").replace("P9100", "P9100 D2") + "M30\n"
    control = dataclasses.replace(job().control, operator_dress_at=(3.0,))
    record = run(text, job(), control=control)
    assert sorted(record.dresses["cause"]) == ["auto", "auto", "operator", "pre"]
    assert record.dresses["after"][0] == 0
    assert record.parts[0]["dresses"] == 4
    # 2 passes of 0.02 mm: 0.08 mm off the diameter each
    assert record.dresses["ds"][0] == pytest.approx(300.0 - 0.08)
    assert record.parts[0]["dressed_off"] == pytest.approx(record.dresses["removed"].sum())
    assert record.dresses["removed"][0] == pytest.approx(2 * 0.02 * math.pi * 300.0 * 25.0)
    assert record.parts[0]["dress_cost"] == pytest.approx(4 * 0.10)


INCH = "G70 G94 G90 G19\nG00 X-2. Y0 Z0\nG82 X9. I-2. Y-.002 J-.001 F6. E400. P9200 D1\nM30\n"


def test_a_dress_program_inherits_the_modes_of_its_caller() -> None:
    inherited = "\nO9200\nG91 G01 Y-.001 F6.\nZ1.2 F7.5\nM99\n"
    own = inherited.replace("G91", "G70 G94 G91")
    found, expected = run(INCH + inherited, job()), run(INCH + own, job())
    assert found.parts[0]["dresses"] == 1
    assert found.strokes.tobytes() == expected.strokes.tobytes()
    assert found.dresses.tobytes() == expected.dresses.tobytes()


@pytest.mark.parametrize("shift", ["G10 L2 P1 X100. Z7.", "G52 X100. Z7.", "G92 X-100. Z-7."])
def test_a_shifted_origin_moves_the_dress_relative_to_the_diamond(shift: str) -> None:
    text = f"G71 G94 G90 G19\nG00 X0. Y0. Z0.\n{shift}\nG00 X-130. Z-7.\n"
    text += CYCLE.replace("X230. I-30.", "X130. I-130.").replace("P9100", "P9100 D1") + "M30\n"
    for tip, warnings in ((Diamond(x=-20.0, y=10.0, z=-3.0), 0), (Diamond(x=-120.0, y=10.0, z=-10.0), 1)):
        ground = dataclasses.replace(job(), diamond=tip)
        found = run(text, ground).warnings
        assert sum("dresses nothing" in warning for warning in found) == warnings
        why = JobSimulation(read(text + DRESS, "test.nc"), ground, 0.0).why
        assert ("misses the diamond" in str(why)) == bool(warnings)


def test_a_dress_program_includes_the_subprograms_it_calls() -> None:
    passes = "O9101\nG91 G01 Y-.02 F60.\nZ35. F191.\nY-.02 F60.\nZ-35. F191.\nG90\nM99\n"
    dress = f"O9100\nG71 G90 G94\nG00 Y20.\nG00 X-120. Z-40.\nG00 Y10.\nM98 P9101\nG00 Y20.\nM99\n{passes}"
    text = HEAD + CYCLE.replace("P9100", "P9100 D1") + "M30\n"
    record = grind(read(text + dress, "test.nc"), job())
    assert record.parts[0]["dresses"] == 1 and record.warnings == ()
    # called by the main program, it dresses nothing
    text = text.replace("M30", "G80\nG00 Y20.\nM98 P9101\nM30")
    (warning,) = grind(read(text + dress, "test.nc"), job()).warnings
    assert "test.nc:6: M98 P9101" in warning and "dresses nothing" in warning


def test_a_dress_program_that_depends_on_its_caller_is_refused() -> None:
    loose = "\nO9200\nG91 G01 Y-.02 F60.\nZ30. F191.\nM99\n"
    with pytest.raises(DressProgramError, match=r"O9200: the wheel moves 0\.508 mm"):
        run(INCH + loose, job())
    # an infeed to Y-.02 is 0.02 mm from Y0, where the cycle starts, but 0.01 mm from Y-.01, where it dresses
    absolute = "\nO9200\nG71 G90 G94 G01 Y-.02 F60.\nZ30. F191.\nM99\n"
    text = HEAD + "G82 X230. I-30. Y-.02 J-.01 F60. E12000. P9200 D1\nM30\n"
    with pytest.raises(DressProgramError, match=r"0\.01 mm .* when the cycle calls it, but .* 0\.02 mm"):
        run(text + absolute, job())


def test_invalid_programs_and_dress_programs_are_rejected() -> None:
    with pytest.raises(DressProgramError, match="O9300"):
        run(HEAD + CYCLE.replace("9100", "9300") + "M30\nO9300\nG00 Y20.\nM99\n", job())
    with pytest.raises(ControlError):
        run(HEAD + "G82 X230. Y-.05\nM30\n", job())
    with pytest.raises(GrindingError, match="makes no stroke"):
        run(HEAD + "G00 Y10.\nM30\n", job())


# --- conservation and limits ----------------------------------------------------------------------

TRAVERSE = HEAD + "G83 X230. I-30. Y-.04 J-.01 Z35. K10. L1 F1500. E12000. P9100 D2\nM30\n"


@pytest.mark.parametrize("wheel", ["a60j", "b126"])
@pytest.mark.parametrize(
    ("text", "width"), [(HEAD + CYCLE.replace("P9100", "P9100 D3") + "M30\n", 20.0), (TRAVERSE, 60.0)]
)
def test_grinding_conserves_stock_wheel_energy_and_cost(text: str, width: float, wheel: str) -> None:
    record = run(text, job(wheel=wheel, width=width))
    strokes, part = record.strokes, record.parts[0]
    removed = (strokes["ae"] * strokes["b"] * strokes["Lw"]).sum()
    assert removed == pytest.approx(part["S"] * width * 200.0, rel=1e-12)
    worn_diameter = 2.0 * strokes["dw"].sum() + 2.0 * 2 * 0.02 * len(record.dresses)
    assert 300.0 - strokes["ds"][-1] == pytest.approx(worn_diameter, rel=1e-9)
    assert part["worn"] == pytest.approx(strokes["worn"].sum())
    assert strokes["W"][-1] == pytest.approx(strokes["dw"][record.dresses["after"][-1] :].sum())
    energy = strokes["power"] * strokes["Lw"] / (strokes["E"] / 60.0)
    volume = strokes["ae"] * strokes["b"] * strokes["Lw"]
    assert energy == pytest.approx(strokes["u_s"] * volume, rel=1e-9, abs=1e3)
    assert part["total_cost"] == pytest.approx(
        sum(part[name] for name in ("time_cost", "wheel_cost", "dress_cost", "scrap_cost"))
    )
    assert part["scrap_cost"] == pytest.approx(40.0 * (1.0 - part["survival"]))
    assert part["time_cost"] == pytest.approx(80.0 * part["seconds"] / 3600.0)


def test_traverse_engages_the_fresh_strips_only() -> None:
    strokes = run(TRAVERSE.replace("L1", "L0"), job(width=60.0, setup={"machine": stiff()})).strokes
    # the whole wheel at first, then a cross pick each; the last one is shortened to 5 mm
    assert strokes["b"][1:6] == pytest.approx([25.0, 10.0, 10.0, 10.0, 5.0])


def test_wheel_wear_tapers_a_traversed_part() -> None:
    text = HEAD + "G83 X230. I-30. Y-.02 J-.02 Z75. K25. L0 F1500. E12000. P9100\nM30\n"
    wide = job(width=100.0, setup={"machine": stiff()})
    wide = dataclasses.replace(wide, part=dataclasses.replace(wide.part, material=STILL))
    record = run(text, wide)
    strokes = record.strokes[1:]
    assert list(strokes["b"]) == [25.0] * 4
    # ground volume over G-ratio, spread over the circumference of the wheel
    expected = sum(s["ae"] * 200.0 * 25.0 / (s["G"] * math.pi * 300.0 * 25.0) for s in strokes)
    assert strokes["W"][-1] == pytest.approx(expected, rel=1e-3)
    # the last band is ground with the wear of the three before it
    lost = 1000.0 * strokes["W"][2]
    assert 0.5 * lost < record.parts[0]["taper"] < lost
    hard = (PartConditions(factors={"Gref": 1e6, "wi": 1e-6}),)
    assert run(text, wide, parts=hard).parts[0]["taper"] < 0.02 * lost


def test_a_traversed_part_is_judged_by_its_largest_size_error() -> None:
    text = HEAD + "G83 X230. I-30. Y-.05 J-.025 Z75. K25. L0 F1500. E12000. P9100\nM30\n"

    def traversed(tolerance: float) -> Any:
        return run(text, job(width=100.0, stock=0.05, tolerance=tolerance)).parts[0]

    part = traversed(50.0)
    mean, worst = part["size_error"], part["worst_error"]
    assert mean + 0.25 * part["taper"] < worst < mean + part["taper"]
    # a logistic step of 0.8 um width, midway between the two errors
    share = 1.0 / (1.0 + math.exp(-0.5 * (worst - mean) / 0.8))
    assert traversed(0.5 * (mean + worst))["survival"] == pytest.approx(part["survival"] * (1.0 - share), rel=1e-6)


@pytest.mark.parametrize("width", [7.0, 19.3, 23.0])
def test_a_plunged_part_has_equal_mean_and_worst_size_error_to_the_last_bit(width: float) -> None:
    for stock in (0.0513, 0.0677, 0.0731):
        text = HEAD + CYCLE.replace("Y-.05", f"Y-{stock}") + "M30\n"
        part = run(text, job(width=width, stock=stock, tolerance=5.0)).parts[0]
        assert part["taper"] == 0.0
        assert part["worst_error"] == part["size_error"]


def stiff() -> Any:
    return dataclasses.replace(CATALOGUE.machine("default"), stiffness=500_000.0)


def test_a_rise_allowance_counts_every_plunge() -> None:
    text = HEAD + "G82 X230. I-30. Y-.2 J-.02 L2 F60. E12000.\nG82 Y-.26 J-.005 L2 F60.\nM30\n"
    strict = run(text, job(stock=0.26)).parts[0]
    allowed = run(text, job(stock=0.26, rise_allowance=100.0)).parts[0]
    strokes = run(text, job(stock=0.26)).strokes
    assert allowed["rise"] == strokes["T"].max()
    last = strokes["T"][strokes["Z"] >= 0.21 - 1e-9].max()
    assert strict["rise"] == last
    assert strict["rise"] < allowed["rise"]


def test_limits_decide_survival() -> None:
    text = HEAD + CYCLE + "M30\n"
    good = run(text, job(stock=0.05, tolerance=9.0, roughness_limit=0.5)).parts[0]
    assert good["survival"] > 0.99
    assert run(text, job(stock=0.07, tolerance=9.0)).parts[0]["survival"] < 0.01
    assert run(text, job(stock=0.05, roughness_limit=0.2)).parts[0]["survival"] < 0.01
    weak = dataclasses.replace(CATALOGUE.machine("default"), power_limit=7500.0, idle_power=6500.0)
    assert run(text, job(stock=0.05, setup={"machine": weak})).parts[0]["survival"] < 0.01


def test_a_stop_in_a_dress_program_begins_no_new_part() -> None:
    text = HEAD + CYCLE.replace("P9100", "P9400 D1") + "M30\n"
    dress = DRESS.replace("O9100", "O9400")
    stops = dress.replace("N9", "M01\nM00\nN9")
    plain, stopped = (grind(read(text + body), job()) for body in (dress, stops))
    assert len(stopped.parts) == 1
    assert stopped.strokes.tolist() == plain.strokes.tolist()


@pytest.mark.parametrize("feed", ["E1", "E15"])
def test_a_stroke_that_destroys_the_wheel_warns_once(feed: str) -> None:
    record = run(HEAD + CYCLE.replace("E12000", feed) + "M30\n", job())
    found = [warning for warning in record.warnings if "destroys the wheel" in warning]
    assert len(found) == 1
    assert re.match(rf"test\.nc:3: a stroke .* at {feed} mm/min destroys the wheel; usual are picks", found[0])
    limit = job().setup.wheel.wear_flat_limit
    assert record.strokes["A"].max() == limit
    assert record.parts["survival"][0] < 0.01


def test_non_finite_results_of_a_cut_are_rejected() -> None:
    beyond = (PartConditions(factors={"RaRef": 1e300, "ra_scale": 1e200}),)
    with pytest.raises(GrindingError, match=r"test\.nc:3: forces, heat or wear of a cut are no finite numbers; give "):
        run(HEAD + CYCLE + "M30\n", job(), parts=beyond)


def test_the_control_knows_the_wheel_radius_at_any_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under G96 the spindle speed shows the radius in entry 33 (12-41, 15-11)."""
    speeds = []

    def listening(programs: Programs, control: Control) -> Execution:
        class Listening(Execution):
            def __next__(self) -> Event:
                event = super().__next__()
                if isinstance(event, Spindle):
                    speeds.append(event.speed)
                return event

        return Listening(programs, control)

    monkeypatch.setattr(grind_module, "execute", listening)
    record = run(HEAD + "G96 S1800\n" + CYCLE + CYCLE.replace("Y-.05", "Y-.1 D2") + "M30", job(stock=0.2))
    radii = [1800.0 * 1000.0 / (2.0 * math.pi * speed) for speed in speeds]
    assert radii[0] == pytest.approx(0.5 * job().setup.wheel.diameter)
    after_dress = [0.5 * row["ds"] for row in record.dresses]
    assert len(after_dress) == 2 and after_dress[1] < after_dress[0]
    assert all(any(math.isclose(radius, found) for found in radii) for radius in after_dress)
