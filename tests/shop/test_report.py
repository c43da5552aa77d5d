"""`grind report` writes one file with the numbers of the record, even for hostile program names."""

import re
import shutil
import subprocess
from functools import cache
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read, read_file
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.render.curve_data import GREY, MOST_STROKES, ORANGE, RED, picture
from grind_env.shop.python_api import report
from grind_env.shop.report.provenance import changes
from grind_env.shop.report.run_report import run_report
from tests.command import status as command
from tests.machine.harness import DRESS
from tests.patience import PATIENCE

pytest.importorskip("matplotlib")

NAMES = ("plate_g82", "rail_g83", "keyway_g81")
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
SECTIONS = [
    "Verdict",
    "Margin to the limits",
    "Blocks",
    "Comparison",
    "Run",
    "Parts",
    "Dresses and wheel",
    "Cost",
    "Warnings",
    "Program",
    "Assumptions and calibration",
]
PART = "N{} G00 Y2.\nG00 X-30.\nG01 Y0 F500.\nN50 G82 X230. I-30. Y-.2 J-.02 L1 F60. E12000. P9100 D{}\nG80\nG00 Y20.\n"


@cache
def page_of(name: str) -> str:
    job = load_job(EXAMPLES / f"{name}.toml")
    programs = read_file(EXAMPLES / f"{name}.nc")
    files = EXAMPLES / f"{name}.nc", EXAMPLES / f"{name}.toml"
    return run_report(grind(programs, job), files)


def section(page: str, title: str) -> str:
    return page.partition(f"<h2>{title}</h2>")[2].partition("</section>")[0]


def cells(html: str) -> list[list[str]]:
    rows = re.findall(r"<tr>(.*?)</tr>", html, re.DOTALL)
    return [[unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row, re.DOTALL)] for row in rows[1:]]


@pytest.mark.parametrize("name", NAMES)
def test_a_report_has_every_section_and_the_numbers_of_the_record(name: str) -> None:
    page = page_of(name)
    job = load_job(EXAMPLES / f"{name}.toml")
    record = grind(read_file(EXAMPLES / f"{name}.nc"), job)
    assert re.findall(r"<h2>(.*?)</h2>", page) == SECTIONS
    strokes, part = record.strokes, record.parts[0]
    blocks = cells(section(page, "Blocks"))
    assert sum(int(row[3]) for row in blocks) == strokes.size
    assert sum(int(row[14]) for row in blocks) == record.dresses.size
    assert max(float(row[8]) for row in blocks) == pytest.approx(0.001 * part["peak_power"], abs=0.005)
    assert sum(float(row[5]) for row in blocks) == pytest.approx(strokes["seconds"].sum(), abs=0.1)
    compared = cells(section(page, "Comparison"))
    assert max(float(row[1]) for row in compared) == pytest.approx(strokes["Q"].max(), abs=0.005)
    assert [row[5] for row in compared] == [f"{each:.1f}" for each in record.executions["u_s"]]
    overlaps = [float(row[8]) for row in cells(section(page, "Dresses and wheel"))]
    assert set(overlaps) == {round(each, 2) for each in record.dresses["overlap"].tolist()}
    margins = {row[0].split(",")[0]: row for row in cells(section(page, "Margin to the limits"))}
    left = 100.0 * (1.0 - part["Ra"] / job.limits.roughness)
    assert float(margins["roughness Ra"][3]) == pytest.approx(left, abs=0.5)
    cost = {row[0]: float(row[1]) for row in cells(section(page, "Cost"))}
    assert cost["all"] == pytest.approx(part["total_cost"], abs=0.005)
    shares = sum(value for key, value in cost.items() if key != "all")
    assert shares == pytest.approx(cost["all"], abs=0.025)


def test_remaining_dresses_follow_from_the_smallest_wheel_diameter() -> None:
    job = load_job(EXAMPLES / "plate_g82.toml")
    text = unescape(section(page_of("plate_g82"), "Dresses and wheel"))
    found = re.search(r"ends with ([\d.]+) mm .* takes ([\d.]+) mm of it: (\d+) dresses", text)
    assert found
    last, each, left = map(float, found.groups())
    assert each == pytest.approx(2 * 2 * 0.020, abs=1e-3)  # two passes of 0.020 mm off the radius
    assert left == pytest.approx((last - job.setup.wheel.minimum_diameter) / each, rel=0.01)


def test_texts_and_names_of_programs_are_escaped(tmp_path: Path) -> None:
    hostile = "<script>alert`1`</script>"
    text = (EXAMPLES / "keyway_g81.nc").read_text().replace("(TABLE ON", f"({hostile}")
    program = tmp_path / "<img src=x onerror=alert(1)>.nc"
    program.write_text(text)
    shutil.copy(EXAMPLES / "keyway_g81.toml", program.with_suffix(".toml"))
    assert command("report", program, "-o", tmp_path / "out.html") == 0
    page = (tmp_path / "out.html").read_text("utf-8")
    assert hostile not in page and "<img" not in page
    assert "&lt;script&gt;alert`1`&lt;/script&gt;" in page


def test_warnings_show_the_text_of_their_block(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text((EXAMPLES / "plate_g82.nc").read_text().replace("E15000.", "E45000."))
    shutil.copy(EXAMPLES / "plate_g82.toml", tmp_path / "part.toml")
    assert command("report", program) == 0
    page = program.with_suffix(".html").read_text("utf-8")
    rows = cells(section(page, "Warnings"))
    assert any("E45000." in row[1] and "lower E" in row[2] for row in rows)
    assert '<div class="note poor">' in section(page, "Program")


def test_changes_list_the_overrides_of_the_job(tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    text = (EXAMPLES / "plate_g82.toml").read_text()
    path.write_text(f"{text}\n[setup.machine_overrides]\npower_limit = 4321\n[catalogue]\nfiles = ['own.toml']\n")
    (tmp_path / "own.toml").write_text("[wheel.a60j]\nbase = 'a60j'\nfriction = 0.45\n")
    told = {(entry, key, here, known) for entry, key, _, here, known in changes(load_job(path))}
    assert told == {("machine default", "power_limit", "4321", "7500"), ("wheel a60j", "friction", "0.45", "0.4")}
    assert changes(load_job(EXAMPLES / "plate_g82.toml")) == []


def test_a_report_names_an_out_of_model_machine(tmp_path: Path) -> None:
    assert "out-of-model machine" not in page_of("plate_g82")
    program, job = tmp_path / "plate.nc", tmp_path / "plate.toml"
    program.write_text((EXAMPLES / "plate_g82.nc").read_text())
    job.write_text('plant = "meter:7"\n' + (EXAMPLES / "plate_g82.toml").read_text())
    assert "Simulated on meter:7, an out-of-model machine." in report(program).read_text("utf-8")
    assert "Simulated on meter:8, " in report(program, plant="meter:8").read_text("utf-8")


def test_a_missing_job_is_refused_with_a_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "part.nc"
    shutil.copy(EXAMPLES / "plate_g82.nc", program)
    assert command("report", program) == 2
    assert "name one with --job" in capsys.readouterr().err
    assert not program.with_suffix(".html").exists()


def test_reports_of_many_parts_stay_small() -> None:
    """Cover few strokes, the most strokes drawn one by one, bands, and very many parts."""
    job = load_job(EXAMPLES / "plate_g82.toml")
    for count in (3, 50, 51, 300):
        body = "M00\n".join(PART.format(k + 1, int(k % 4 == 0)) for k in range(count))
        programs = read(f"G71 G94 G90 G19 S1910 M03\nG00 Y2. Z-2.5 M08\n{body}M30\n{DRESS}", "many.nc")
        record = grind(programs, job)
        assert (record.strokes.size <= MOST_STROKES) == (count <= 50)
        page = run_report(record)
        assert len(page) < 400_000 and page.count("<tr") < 700 and len(cells(section(page, "Blocks"))) == 2


def test_a_report_replaces_the_one_before(tmp_path: Path) -> None:
    page = tmp_path / "plate_g82.html"
    for suffix in (".nc", ".toml"):
        shutil.copy(EXAMPLES / f"plate_g82{suffix}", tmp_path)
    assert command("report", page.with_suffix(".nc")) == 0
    before = page.read_bytes()
    page.write_bytes(before[:-100])
    assert command("report", page.with_suffix(".nc")) == 0
    assert page.read_bytes() == before


def test_the_picture_of_a_run_has_a_mark_for_every_value() -> None:
    job = load_job(EXAMPLES / "plate_g82.toml")
    record = grind(read_file(EXAMPLES / "plate_g82.nc"), job)
    marks = re.findall(r'<use [^>]*x="([^"]*)" y="([^"]*)" style="fill: var\(--(\w+)\)"', page_of("plate_g82"))
    curves = [curve for curve in picture(record).curves if not curve.downwards]
    for color, name in ((RED, "red"), (ORANGE, "orange"), (GREY, "grey")):
        drawn = np.array([(float(x), float(y)) for x, y, found in marks if found == name])
        (curve,) = [each for each in curves if each.color == color]
        known = np.flatnonzero(np.isfinite(curve.mean))
        assert len(drawn) == len(known)
        for pixels, those in zip(drawn.T, (known, curve.mean[known]), strict=True):
            np.testing.assert_allclose(pixels, np.polyval(np.polyfit(those, pixels, 1), those), atol=0.03)


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine to open the report in")
@pytest.mark.parametrize("name", NAMES)
def test_tables_fit_into_a_window_of_1100_pixels(name: str, tmp_path: Path) -> None:
    assert CHROMIUM is not None
    script = "document.title = [...document.querySelectorAll('.wide')].map(e => e.scrollWidth - e.clientWidth)"
    page = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page_of(name))
    path = tmp_path / "part.html"
    path.write_text(page.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1100,900", "--dump-dom"]
    command = [CHROMIUM, *options, f"--user-data-dir={tmp_path / 'profile'}", path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    (beyond,) = re.findall(r"<title>([\d,]+)</title>", done.stdout)
    assert set(beyond.split(",")) == {"0"} and len(beyond.split(",")) > 5
