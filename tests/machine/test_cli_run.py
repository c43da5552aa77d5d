import gc
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import grind_env
from grind_env.control import read_file
from grind_env.machine.grind import grind as run_grind
from grind_env.machine.grind import grind_file
from grind_env.machine.job.job_file import load_job
from grind_env.machine.part.stroke_record import STROKE_ROW
from grind_env.render.limit_causes import shares
from grind_env.render.record_tables import COLUMNS, print_record
from tests.command import status as grind
from tests.machine import harness

EXAMPLES = Path(grind_env.__file__).parent / "examples"
HEAD = harness.HEAD.replace("G19\n", "G19 S1910 M03 M08\n")
PROGRAMS = Path(__file__).parents[1] / "behaviour" / "programs"
PLATE = str(EXAMPLES / "plate_g82.nc")


def test_run_prints_the_table_of_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", PLATE) == 0
    out = capsys.readouterr().out
    assert "plate_g82.nc" in out
    assert "1 part, good with 100.0 %; " in out
    assert "limit" not in out and "taper" not in out
    assert max(map(len, out.splitlines())) <= 80


def test_run_prints_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", PLATE, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parts"][0]["strokes"] == 29
    assert found["dresses"][0]["cause"] == "auto"
    assert found["warnings"] == []
    assert found["cost"] == pytest.approx(found["parts"][0]["total_cost"])


def test_scrap_has_exit_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = tmp_path / "strict.toml"
    text = (EXAMPLES / "plate_g82.toml").read_text()
    job.write_text(text.replace("roughness_limit = 0.50", "roughness_limit = 0.10"))
    assert grind("run", PLATE, "--job", job) == 1
    out = capsys.readouterr().out
    assert "1 part, good with 0.0 %; " in out
    assert "$, no good part" in out and "per good part" not in out
    assert "beyond the limit of Ra: part 1" in out
    assert grind("run", PLATE, "--job", job, "--json") == 1
    assert json.loads(capsys.readouterr().out)["parts"][0]["beyond"] == ["Ra"]


def test_every_cause_of_scrap_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, job = tmp_path / "parts.nc", tmp_path / "parts.toml"
    cycle = "G00 X-30.\nG00 Y0\nG82 X{}. I-30. Y-{} J-{} L4 F60. E15000.\nG80\nG00 Y20.\nM00\n"
    cuts = [(230, ".1", ".01")] * 4 + [(100, ".1", ".01"), (230, ".15", ".01"), (230, ".1", ".1")]
    program.write_text(HEAD + "".join(cycle.format(*cut) for cut in cuts) + "M30\n")
    text = (EXAMPLES / "plate_g82.toml").read_text()
    weak = "[setup.machine_overrides]\npower_limit = 4000\n"
    job.write_text(text.replace("stock = 0.2 ", "stock = 0.1 ") + weak)
    assert "stock = 0.1 " in job.read_text()
    assert grind("run", program, "--json") == 1
    found = [part["beyond"] for part in json.loads(capsys.readouterr().out)["parts"]]
    assert found[:6] == [[]] * 4 + [["size", "unground"], ["size"]]
    assert {"stall", "size"} <= set(found[6])
    assert grind("run", program) == 1
    out = capsys.readouterr().out
    assert re.search(r"^7 parts, \d\.\d\d good ones expected; .* \$ per good part$", out, re.MULTILINE)
    assert "the spindle stalled: part 7\n" in out
    assert "not ground everywhere: part 5\n" in out


def test_run_shows_the_worst_size_error(capsys: pytest.CaptureFixture[str]) -> None:
    rail = str(EXAMPLES / "rail_g83.nc")
    assert grind("run", rail, "--json") == 0
    part = json.loads(capsys.readouterr().out)["parts"][0]
    assert grind("run", rail) == 0
    out = capsys.readouterr().out
    (row,) = (line.split() for line in out.splitlines() if re.match(r" *1 +\d", line))
    assert row[4:6] == [f"{part['worst_error']:.1f}", f"{part['taper']:.1f}"]
    assert part["worst_error"] != pytest.approx(part["size_error"], abs=0.05)
    assert max(map(len, out.splitlines())) <= 80


def write_parts(path: Path, parts: int) -> None:
    """Write a program of `parts` example plates with a dress so shallow that the wheel lasts."""
    text = Path(PLATE).read_text().split("%\n")[1].replace("N100 M30\n", "N100 M00\nM99\n")
    path.write_text(f"M98 P2001 L{parts}\nM30\n" + text.replace("Y-.02 F60.", "Y-.005 F60."))


def test_similar_parts_share_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "parts.nc"
    write_parts(program, 40)
    (tmp_path / "parts.toml").write_text((EXAMPLES / "plate_g82.toml").read_text())
    grind("run", program)
    out = capsys.readouterr().out
    rows = [line for line in out.splitlines() if re.match(r" *\d+( to \d+)? +\d+\.\d", line)]
    parts = [number for row in rows for number in part_numbers(row)]
    assert parts == list(range(1, 41))
    assert len(rows) < 40


def part_numbers(row: str) -> range:
    found = re.match(r" *(\d+)(?: to (\d+))? ", row)
    assert found is not None
    return range(int(found[1]), int(found[2] or found[1]) + 1)


def test_a_table_of_very_many_rows_is_shortened(capsys: pytest.CaptureFixture[str]) -> None:
    settings = load_job(Path(PLATE).with_suffix(".toml"))
    one = run_grind(read_file(PLATE), settings)
    parts = np.repeat(one.parts, 1000)
    parts["part"], parts["seconds"] = np.arange(1, 1001), np.arange(1000.0)
    many = replace(one, parts=parts, stages=one.stages * 1000, unjudged=one.unjudged * 1000)
    print_record(many, "many.nc", Console())
    out = capsys.readouterr().out
    assert "... 940 more rows, which --json has" in out
    assert len(out.splitlines()) < 75 + 8  # table of blocks, and the dress


def test_a_cause_of_scrap_names_its_block_and_stroke(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, job = tmp_path / "weak.nc", tmp_path / "weak.toml"
    program.write_text(HEAD + "N50 G82 X230. I-30. Y-.2 J-.04 F60. E15000.\nM30\n")
    job.write_text((EXAMPLES / "plate_g82.toml").read_text() + "\n[setup.machine_overrides]\npower_limit = 2000\n")
    assert grind("run", program) == 1
    out = capsys.readouterr().out
    record = run_grind(read_file(program), load_job(job))
    stroke = record.strokes[record.strokes["torque"].argmax()]
    share = f"{100.0 * stroke['torque']:.0f} of 100 % of the torque at which the spindle stalls"
    said = f"N50 stroke {stroke['number']}: {share}; lower J or E"
    assert f"the spindle stalled: part 1\n  {said}\n" in out
    assert grind("run", program, "--json") == 1
    assert json.loads(capsys.readouterr().out)["reasons"]["stall"] == said
    # a block without an N word goes by its line
    program.write_text(program.read_text().replace("N50 ", ""))
    assert grind("run", program, "--json") == 1
    by_line = said.replace("N50", f"line {stroke['line']}")
    assert json.loads(capsys.readouterr().out)["reasons"]["stall"] == by_line
    assert re.search(
        r"^mean size error \d+\.\d µm: wheel wear [\d.]+, growth -?[\d.]+, deflection [\d.]+, rest 0\.0$", out, re.M
    )


@pytest.mark.parametrize("name", ["keyway_g81", "plate_g82", "rail_g83"])
def test_the_shares_of_the_size_error_add_up(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", EXAMPLES / f"{name}.nc", "--json") == 0
    (part,) = json.loads(capsys.readouterr().out)["parts"]
    wear, growth, deflection, rest = (part[f"size_{share}"] for share in ("wear", "growth", "deflection", "rest"))
    assert wear + growth + deflection + rest == pytest.approx(part["size_error"])
    # a part that is ground hot is too thin when it is cold
    assert wear > 0.0 and growth < 0.0 and deflection > 0.0 and rest == pytest.approx(0.0, abs=1e-9)


def test_run_skips_blocks_with_block_delete(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "deleted.nc"
    text = HEAD + "{}G82 X230. I-30. Y-.02 J-.01 F60. E12000.\nM30\n"
    program.write_text(text.format("/G04 P60.\n"))
    (tmp_path / "deleted.toml").write_text((EXAMPLES / "plate_g82.toml").read_text())
    seconds = []
    for options in ([], ["--block-delete"]):
        grind("run", program, "--json", *options)
        seconds.append(json.loads(capsys.readouterr().out)["seconds"])
    assert seconds[1] < seconds[0] - 30.0


ALL = [path for folder in (EXAMPLES, PROGRAMS) for path in sorted(folder.glob("*.nc"))]
#: options of a program with steps as small as the usual retract amount
RETRACT = {"grooving_wheel": ["--groove-retract", "0.01"]}


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_a_check_with_a_job_has_the_times_and_warnings_of_a_run(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = RETRACT.get(path.stem, [])
    assert grind("run", path, "--json", *options) < 2
    record = json.loads(capsys.readouterr().out)
    assert grind("check", path, "--job", path.with_suffix(".toml"), "--json", *options) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["seconds"] == record["seconds"]
    assert report["warnings"] == record["warnings"]


def test_run_and_report_take_the_retract_that_the_error_recommends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, page = PROGRAMS / "grooving_wheel.nc", tmp_path / "page.html"
    assert grind("run", program) == 2
    said = capsys.readouterr().err
    assert "give a smaller retract with --groove-retract of grind check, trace, run or report (groove_retract)" in said
    assert grind("report", program, "-o", page) == 2
    times = {}
    for retract in (0.01, 0.005):
        grind("run", program, "--json", "--groove-retract", retract)
        times[retract] = json.loads(capsys.readouterr().out)["seconds"]
    grind("report", program, "-o", page, "--groove-retract", retract)
    assert f"{times[retract]:.1f} s" in page.read_text("utf-8")
    # 12 retracts at F6 and 2 at F3: a shorter infeed after each, and rapids from rest to rest
    rapid = 2.0 * ((0.01 / 1000.0) ** 0.5 - (0.005 / 1000.0) ** 0.5)
    saved = 12 * 0.005 / (6.0 / 60.0) + 2 * 0.005 / (3.0 / 60.0) + 14 * rapid
    assert times[0.01] - times[0.005] == pytest.approx(saved, abs=1e-6)


@pytest.mark.parametrize("name", ["keyway_g81", "plate_g82", "rail_g83"])
def test_check_and_trace_count_the_strokes_and_motions_of_a_run(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    program, job = str(EXAMPLES / f"{name}.nc"), str(EXAMPLES / f"{name}.toml")
    grind("run", program, "--json")
    record = json.loads(capsys.readouterr().out)
    grind("check", program, "--job", job, "--json")
    report = json.loads(capsys.readouterr().out)
    grind("trace", program, "--job", job)
    motions = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    strokes = sum(cycle["strokes"] for cycle in report["cycles"]) + report["strokes_between"]
    assert strokes == record["parts"][0]["strokes"] and report["warnings"] == []
    assert len(motions) == report["motions"]


def test_help_names_the_pages_that_explain_stops_dresses_and_columns(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", "--help") == 0
    out, docs = capsys.readouterr().out, Path(__file__).parents[2] / "docs"
    pages = [docs / "howto" / "shop.md", docs / "howto" / "job-file.md", docs / "reference" / "columns.md"]
    assert all(str(page.relative_to(docs.parent)) in out for page in pages)
    shop, job, page = pages
    said = " ".join((shop.read_text(encoding="utf-8") + job.read_text(encoding="utf-8")).split())
    for words in (
        "M00 means that the operator loads the next part",
        "At M01 the simulated operator gauges",
        "[[part.stages]]",
        "a dress program called by M98",
    ):
        assert words in said
    parts, strokes = page.read_text(encoding="utf-8").split("## Blocks")
    named = [re.findall(r"^\| ([^|]+) \|", text, re.MULTILINE) for text in (parts, strokes.split("## Strokes")[1])]
    headings = [heading.replace("\n", " ").partition(" ")[0] for heading, _ in COLUMNS.values()]
    assert not [heading for heading in headings if not any(each.startswith(heading) for each in named[0])]
    split = grind_file(PLATE).parts[0]
    assert {name for name, _ in re.findall(r"([a-z ]+) (-?[\d.]+)(?:, |$)", shares(split).partition(": ")[2])} <= {
        *named[0]
    }
    assert not {*(STROKE_ROW.names or ())} - {name for each in named[1] for name in each.split(", ")}


def test_run_writes_a_plot_and_a_record(tmp_path: Path) -> None:
    plot, record = tmp_path / "plate.png", tmp_path / "plate.csv"
    assert grind("run", PLATE, "--plot", plot, "--record", record) == 0
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert len(record.read_text().splitlines()) == 1 + 29


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["missing.nc"], "missing.nc"),
        ([PLATE, "--job", "missing.toml"], "missing.toml"),
        ([PLATE, "--plot", "no/such/folder/a.png"], "no/such/folder"),
        ([PLATE, "--plot", "a.gif"], ".png, .svg, .pdf"),
        ([PLATE, "--record", "no/such/folder/a.csv"], "no/such/folder"),
        ([PLATE, "--record", "a.xlsx"], ".csv or .parquet"),
    ],
)
def test_bad_input_is_one_line_and_exit_status_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert grind("run", *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("grind: ")
    assert error.count("\n") == 1
    assert words in error


@pytest.mark.nightly
@pytest.mark.parametrize("command", ["run", "check", "trace"])
def test_the_garbage_of_a_command_does_not_grow_with_the_parts(command: str, tmp_path: Path) -> None:

    def left(parts: int) -> int:
        program, job = tmp_path / "parts.nc", Path(PLATE).with_suffix(".toml")
        write_parts(program, parts)
        gc.collect()
        gc.disable()
        try:
            grind(command, program, "--job", job)
            return gc.collect()
        finally:
            gc.enable()

    left(4)  # fills the caches
    assert left(24) < left(4) + 20  # less than an object a part
