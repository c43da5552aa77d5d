"""Several parts on the table: a program grinds the stations one after the other, or returns to them."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobProgramError
from grind_env.machine.grind import grind
from grind_env.machine.job import Job, JobError, Part, PartConditions, Station
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.job_writer import job_text
from grind_env.machine.part.unsimulated_cuts import UnjudgedError
from grind_env.machine.program_run import GrindingError
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from grind_env.render.record_tables import as_data, part_table
from tests.examples import examples
from tests.machine.harness import CATALOGUE, DRESS, LONG_AFTER, job, run, warnings_when_stepped

HEAD = "G71 G94 G90 G19\n"
STEEL = {"length": 100.0, "width": 20.0, "stock": 0.05, "scrap_cost": 40.0}
COST, HANDOVER = Outcome._fields.index("cost"), Outcome._fields.index("handover_cost")


def part(material: str = "aisi_52100", **changes: Any) -> Part:
    return Part(**{"material": CATALOGUE.material(material), **STEEL, **changes})


def table(*stations: Station, **changes: Any) -> Job:
    """Return a job with stations."""
    whole = job(**changes)
    return dataclasses.replace(whole, part=stations[0].part, stations=stations)


def two(origin: tuple[float, float, float] = (300.0, 0.0, 0.0), **changes: Any) -> Job:
    left = Station(name="left", offset="G54", part=part())
    return table(left, Station(name="right", offset="G55", origin=origin, part=part(**changes)))


def strokes(shift: str, depth: float = 0.05, above: float = 0.0, dress: int = 0) -> str:
    """Return the text that grinds a part in a work system, coming from beside and above it."""
    return (
        f"{shift}\nG00 Y600.\nG00 X-30. Z-2.\nG00 Y-{above:g}\n"
        f"G82 X130. I-30. Y-{depth:g} J-.01 L2 F60. E12000. P9100 D{dress}\nG80\nG00 Y600.\n"
    )


def alone(text: str, job: Job, whole: Job) -> GrindingRecord:
    """Run the text with M00 between parts at the places of the stations, on a job without stations."""
    kinds = tuple(PartConditions(part=each.part) for each in whole.lying(0))
    plain = dataclasses.replace(job, stations=(), part=kinds[0].part)
    return run(text, plain, control=whole.control, parts=kinds)


@st.composite
def places(draw: st.DrawFn) -> tuple[Job, list[str]]:
    """Draw a job with two stations apart, and the words that lead a program to each zero."""
    way = st.integers(-2000, 2000).map(lambda number: 0.125 * number)
    first = draw(way), draw(way), draw(way)
    along = draw(st.sampled_from([-1.0, 1.0])) * (300.0 + abs(draw(way)))  # a wheel of 300 mm goes down between them
    second = first[0] + along, draw(way), draw(way)
    kinds = part(), part(draw(st.sampled_from(["aisi_52100", "aisi_1020"])), length=draw(st.sampled_from([80.0, 99.5])))
    if draw(st.booleans()):
        stations = [
            Station(name=name, offset=offset, origin=origin, part=kind)
            for name, offset, origin, kind in zip("ab", ("G57", "G54"), (first, second), kinds, strict=True)
        ]
        return table(*stations), ["G57", "G54"]
    stations = [
        Station(name=name, part=dataclasses.replace(kind, start=x, surface=y, across=z))
        for name, (x, y, z), kind in zip("ab", (first, second), kinds, strict=True)
    ]
    shifts = [f"G52 X{x:.3f} Y{y:.3f} Z{z:.3f}" for x, y, z in (first, second)]
    return table(*stations), shifts


@examples(25)
@given(places(), st.integers(0, 2))
def test_two_stations_are_ground_as_two_parts_one_after_the_other(found: tuple[Job, list[str]], dress: int) -> None:
    whole, (one, other) = found
    first, second = strokes(one, dress=dress), strokes(other)
    together = run(HEAD + first + second + "M30\n", whole)
    apart = alone(HEAD + first + "M00\n" + second + "M30\n", whole, whole)
    assert [each.name for each in together.job.part_stations] == ["a", "b"]
    for name in together.strokes.dtype.names or ():
        if name not in ("time", "line"):
            np.testing.assert_array_equal(together.strokes[name], apart.strokes[name], name)
    timeless = [name for name in together.parts.dtype.names or () if name not in ("seconds", "time_cost", "total_cost")]
    for name in timeless:
        np.testing.assert_array_equal(together.parts[name], apart.parts[name], name)
    # all stations are loaded together
    least, most = together.seconds, apart.seconds
    assert least == pytest.approx(most - whole.times.load, abs=1e-6) or most - whole.times.load < least < most
    # a dress may go through the part of the other station; the run apart lacks it
    crashes = [each for each in together.warnings if "dress program" in each and "into the part of station b" in each]
    assert [each for each in together.warnings if each not in crashes] == list(apart.warnings)


def test_the_way_to_the_diamond_is_checked_from_every_station() -> None:
    low, high = two().stations
    job = dataclasses.replace(two(), stations=(low, dataclasses.replace(high, origin=(500.0, 25.0, 0.0))))
    cycles = [
        strokes(offset, depth, dress=dress) for depth, dress in ((0.03, 0), (0.06, 1)) for offset in ("G54", "G55")
    ]
    text = HEAD + "".join(cycle.replace("9100", "9400") for cycle in cycles) + "M30\n"
    straight = DRESS.replace("G00", "G53 G00").replace("O9100", "O9400")
    record = grind(read(text + straight, "test.nc"), job)
    (crash,) = [each for each in record.warnings if "dress program" in each and "into the part of" in each]
    assert "into the part of station right" in crash


def test_stations_loaded_together_count_one_loading_time() -> None:
    short, long = (dataclasses.replace(two(), times=dataclasses.replace(two().times, load=t)) for t in (20.0, 50.0))
    text = HEAD + (strokes("G54") + strokes("G55") + "M00\n") * 2 + "M30\n"
    assert run(text, long).seconds - run(text, short).seconds == pytest.approx(60.0)


def stepped(text: str, whole: Job) -> tuple[JobSimulation, Any, list[Any], float]:
    """Step a program block by block with its own words, beside two other machines."""
    simulation = JobSimulation(read(text + DRESS, "test.nc"), whole, 1.0)
    episodes = simulation.start([np.random.default_rng(k) for k in range(3)])
    blocks, cost = [], 0.0
    for block in simulation.blocks:
        E, D = block.plan.feed, float(block.plan.dresses)
        blocks.append(simulation.writer.block(episodes, 1, E, D))
        outcomes, _ = simulation.step(episodes, np.full(3, E), np.full(3, D))
        cost += outcomes[1, COST] - outcomes[1, HANDOVER]  # a record has no handover cost
    return simulation, episodes, blocks, cost


@pytest.mark.parametrize("wide", [False, True])
def test_a_script_of_stations_ends_as_the_program_in_the_control(wide: bool) -> None:
    width = 38.0 if wide else 20.0
    left = Station(name="left", offset="G54", part=part(width=width, roughness_limit=0.4))
    softer = part("aisi_1020", stock=0.04, width=width, start=1.5, roughness_limit=1.0)
    whole = table(left, Station(name="right", offset="G55", origin=(250.0, 3.0, 7.0), part=softer))
    text = strokes("G54", dress=1) + strokes("G55", 0.04)
    if wide:
        text = text.replace("G82 ", "G83 ").replace("F60.", "F1500. Z15. K9. R9.")
    simulation, episodes, blocks, cost = stepped(HEAD + (text + "M00\n") * 2 + "M30\n", whole)
    assert simulation.compiled and [block.finished for block in simulation.blocks] == [1, 1, 1, 1]
    written = simulation.writer.written(episodes, 1, blocks)
    record = grind(read(written.program, "test.nc"), written.job)
    assert [each.name for each in record.job.part_stations] == ["left", "right"] * 2
    last = record.strokes[-1]
    wheel = dict(zip(("ds", "A", "lam", "V"), episodes.wheels[1], strict=False))
    for name in ("ds", "A", "V", "lam"):
        assert float(last[name]) == pytest.approx(wheel[name], rel=1e-9), name
    assert cost == pytest.approx(record.parts["total_cost"].sum(), rel=1e-9)


def test_a_program_without_a_stroke_at_a_station_is_rejected() -> None:
    with pytest.raises(JobProgramError, match=r"test\.nc makes no stroke"):
        JobSimulation(read(HEAD + "G54\nG00 X-30. Z-2.\nM30\n", "test.nc"), two(), 1.0)


def test_a_program_may_return_to_a_station_but_has_no_script() -> None:
    passes = [("G54", 0.03, 0.0), ("G55", 0.03, 0.0), ("G54", 0.05, 0.03), ("G55", 0.05, 0.03)]
    record = run(HEAD + "".join(strokes(*each) for each in passes) + "M30\n", two())
    assert record.warnings == () and record.parts["part"].tolist() == [1, 2]
    assert record.strokes["part"][record.strokes["number"] == 1].tolist() == [1, 2, 1, 2]
    # ground warm, each is a little too thin
    assert np.allclose(record.parts["S"] + 0.001 * record.parts["size_growth"], 0.048, atol=0.001)
    end, control = record.strokes[-1], two().control
    speed = control.rapid_feed / 60.0
    retract = 600.05 / speed + speed / control.acceleration
    assert record.seconds == pytest.approx(end["time"] + end["seconds"] + retract, abs=1e-6)
    assert record.strokes["ae"].sum() == pytest.approx(record.parts["S"].sum(), rel=1e-9)
    with pytest.raises(ScriptError, match=r"its strokes come back to station left"):
        script_of(read(HEAD + "".join(strokes(*each) for each in passes) + "M30\n" + DRESS), two())
    with pytest.raises(JobProgramError, match=r"come back to station left; .*\[\[stations\]\]"):
        JobSimulation(read(HEAD + "".join(strokes(*each) for each in passes) + "M30\n" + DRESS), two(), 1.0)


def test_a_part_cools_while_the_other_station_is_ground() -> None:
    passes = [("G54", 0.03, 0.0), ("G55", 0.03, 0.0), ("G54", 0.05, 0.03), ("G55", 0.05, 0.03)]
    whole = two()
    record = run(HEAD + "".join(strokes(*each) for each in passes) + "M30\n", whole)
    p = whole.parameters
    for number in (1, 2):
        rows = record.strokes[record.strokes["part"] == number]
        assert rows["grown"][0] == 0.0 < rows["grown"][6]
        # heat of each stroke, eps Ft vs b/(vw rho c H B): each mode has a share, which decays afterwards
        heat = rows["eps"] * rows["Ft"] * rows["vs"] * rows["b"] / (rows["E"] / 60.0) * p.per_capacity * p.swell
        after = np.subtract.outer(rows["time"], rows["time"])
        modes = ((p.w_1, p.r_1), (p.w_2, p.r_2), (p.w_3, p.r_3), (p.w_4, p.r_4))
        left = [share * np.exp(-after * rate) for share, rate in modes]
        grown = np.where(after > 0.0, np.sum(left, axis=0), 0.0) @ heat
        assert rows["grown"] == pytest.approx(grown, rel=1e-4)


def test_a_part_reached_by_a_running_table_begins_cold() -> None:
    text = "G54\nG00 Y20.\nG00 X-30. Z-2.\nG00 Y0\nG81 X130. I-30. E12000.\nG01 Y-.03 F.4\n"
    text += "G01 Y1. F600.\nG01 Z58. F1500.\nG01 Y0 F600.\nG01 Y-.03 F.4\nG80\nG00 Y20.\nM30\n"
    rows = run(HEAD + text, two((0.0, 0.0, 60.0))).strokes
    first, second = (rows[rows["part"] == number] for number in (1, 2))
    assert first["grown"].max() > 0.0 and second["ae"][0] > 0.0
    assert second["grown"][0] == 0.0 < second["grown"][-1]


def test_a_stroke_over_two_stations_warns_and_leaves_both_unjudged() -> None:
    text = HEAD + strokes("G54").replace("X130.", "X430.") + "M30\n"
    record = run(text, two())
    (warning,) = record.warnings
    assert warning.startswith("test.nc:6: its strokes meet the parts of stations left and right at once")
    assert record.parts["survival"].tolist() == [0.0, 0.0]
    assert [each.name for each in record.job.part_stations] == ["left", "right"]
    assert [found[0].lines for found in record.unjudged] == [(6,), (6,)]
    with pytest.raises(UnjudgedError, match="left and right at once"):
        script_of(read(text + DRESS, "test.nc"), two())
    side_by_side = run(HEAD + strokes("G54") + "M30\n", two((0.0, 0.0, 21.0)))  # the wheel is 25 mm wide
    assert "left and right at once" in side_by_side.warnings[0]
    lower = run(HEAD + strokes("G54").replace("X130.", "X430.") + "M30\n", two((300.0, -1.0, 0.0)))
    assert len(lower.parts) == 1 and not lower.unjudged[0]  # the wheel passes above the other one


def test_a_stroke_over_two_stations_needs_conditions_of_both_parts() -> None:
    both = HEAD + strokes("G54").replace("X130.", "X430.") + "M30\n" + DRESS
    whole = two()
    with pytest.raises(UnjudgedError, match="at once"):
        JobSimulation(read(both, "test.nc"), whole, 1.0)
    few = dataclasses.replace(whole, parts=(PartConditions(),))
    with pytest.raises(JobError, match=r"test\.nc grinds more parts than the 1 that have conditions"):
        JobSimulation(read(both, "test.nc"), few, 1.0)


def test_an_unused_station_warns_once_and_has_no_row() -> None:
    record = run(HEAD + (strokes("G54") + "M00\n") * 2 + "M30\n", two())
    assert record.parts["part"].tolist() == [1, 2]
    (warning,) = record.warnings
    assert warning.startswith("station right: no stroke of test.nc meets its part")


def test_a_rapid_into_the_part_of_another_station_is_a_crash() -> None:
    through = "G54\nG00 Y-1.\nG00 X350.\nG00 Y20.\n"
    record = run(HEAD + strokes("G54") + "G00 X200.\n" + through + strokes("G55") + "M30\n", two())
    (warning,) = record.warnings
    assert "a rapid outside a cycle takes the wheel 1 mm into the part of station right" in warning


def test_a_rapid_of_a_dress_into_another_station_warns() -> None:
    dress = "O9200\n" + DRESS.split("O9100\n")[1].replace("G71", "G54 G71")
    text = HEAD + strokes("G54", dress=1) + strokes("G55", dress=1) + "M30\n"
    text = text.replace("P9100", "P9200") + dress
    high = two((300.0, 30.0, 0.0))
    record = run(text, high)
    (warning,) = record.warnings
    # 30 mm beside it, the rim of a 300 mm wheel is 3.03 mm above its lowest point, which is 10 mm too low
    assert "a rapid of the dress program takes the wheel 6.95 mm into the part of station right" in warning
    late = dataclasses.replace(high.control, operator_dress_at=LONG_AFTER)
    assert warnings_when_stepped(run(text, high, control=late)) == (warning,)
    assert run(text, two()).warnings == ()


def test_strokes_after_m00_in_a_running_cycle_belong_to_the_next_parts() -> None:
    going_on = strokes("G55").replace("G80\n", "M00\n")
    both = strokes("G54").replace("X130.", "X430.")
    record = run(HEAD + strokes("G54") + going_on + both + "M30\n", two())
    assert [bool(found) for found in record.unjudged] == [False, False, True, True]
    assert (record.parts["survival"][:2] > 0.9).all() and not record.parts["survival"][2:].any()


def test_feed_moves_are_strokes_at_each_station() -> None:
    stroke = "{}\nG00 Y20.\nG00 X-30. Z-2.\nG00 Y-.01\nG01 X130. F12000.\nG00 Y20.\n"
    record = run(HEAD + stroke.format("G54") + stroke.format("G55") + "M30\n", two())
    assert record.warnings == () and record.strokes["part"].tolist() == [1, 2]
    assert (record.strokes["Lw"] == 100.0).all()


def test_records_name_the_stations() -> None:
    record = run(HEAD + strokes("G54") + strokes("G55") + "M30\n", two(roughness_limit=0.1))
    shown = part_table(record)
    assert shown.fields[:2] == ("part", "station") and [row[1].text for row in shown.rows] == ["left", "right"]
    data = as_data(record, "test.nc")
    assert [each["station"] for each in data["parts"]] == ["left", "right"]
    assert [each["beyond"] for each in data["parts"]] == [[], ["Ra"]]
    frame = record.to_dataframe("parts")
    assert frame["station"].tolist() == ["left", "right"]


TEXT = """
[part]
material = "aisi_52100"
length = 100
width = 20
stock = 0.05

[[stations]]
offset = "G54"
scrap_cost = 40

[[stations]]
name = "right"
offset = "G55"
origin = [300, 0, 0.5]
scrap_cost = 5
material = "aisi_1020"
stages = [{ stock = 0.02 }]
"""


def loaded(folder: Path, text: str) -> Job:
    path = folder / "job.toml"
    path.write_text(text)
    return load_job(path)


def test_a_job_file_with_stations_is_read_and_written(tmp_path: Path) -> None:
    found = loaded(tmp_path, TEXT)
    left, right = found.stations
    assert (left.name, right.name, found.part) == ("1", "right", left.part)
    assert (right.part.material.name, right.part.length, len(right.part.stages)) == ("aisi_1020", 100.0, 1)
    assert found.control.work_offsets == {"G54": (0.0, 0.0, 0.0), "G55": (300.0, 0.0, 0.5)}
    assert right.on_machine(0).part.start == 300.0 and right.on_machine(2).part.across == 300.0 - 300.0
    assert loaded(tmp_path, job_text(found)) == found


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[[stations]]", "[stations]"), r"stations is .*tables, each headed \[\[stations\]\]"),
        (('offset = "G55"', 'offset = "G60"'), r"station right: stations.offset is 'G60', but must be one of G54, "),
        (("[300, 0, 0.5]", "[300, 0]"), r"station right: stations.origin is .* must be 3 numbers from -10000"),
        (('offset = "G55"\n', ""), r"station right: stations.origin is that of an offset, and there is none"),
        (('offset = "G55"', 'offset = "G54"'), r"station right: .* another than that of a station before it"),
        (('name = "right"', 'name = "1"'), r"there are two stations '1'; name them differently"),
        (('name = "right"', 'name = " "'), r"station  : stations.name is ' ', but must be a text"),
        (("scrap_cost = 5", "stock = 5"), r"station right: part.scrap_cost is missing"),
        (
            ("scrap_cost = 5", "scrap_cost = 5\nlenght = 5"),
            r"station right: there is no key stations.lenght .did you mean",
        ),
        (("scrap_cost = 5", "scrap_cost = -5"), r"station right: part.scrap_cost is -5"),
        (("stages = [{ stock", "stages = [{ stok"), r"station right: stage 1: there is no key"),
        (("[part]", "[[parts]]\npart = { length = 50 }\n[part]"), r"parts.part says what parts are that lie at stat"),
    ],
)
def test_a_bad_stations_table_is_reported_on_one_line(change: tuple[str, str], said: str, tmp_path: Path) -> None:
    text = TEXT.replace(*change)
    if change[0] == "[[stations]]":
        text = TEXT[: TEXT.index("[[")] + "[stations]\nname = 'a'\n"
    with pytest.raises(JobError, match=said) as error:
        loaded(tmp_path, text)
    assert "\n" not in str(error.value)


def test_grooves_are_rejected_in_a_job_with_stations() -> None:
    with pytest.raises(GrindingError, match=r"^test.nc:3: a groove is cut, and grooves lie at no station"):
        run("G71 G94 G90 G18\nG00 X18. Z0\nG76 X18. Z-.5 I4. K.9 D.1 F60.\nM30\n", two())
