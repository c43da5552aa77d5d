"""Reports of `grind optimise` and `grind calibrate` show the results, even with hostile file names."""

import json
import re
import shutil
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grind_env.control import read_file
from grind_env.machine.job.job_file import load_job
from grind_env.shop.calibrate.calibration_output import error_sentences
from grind_env.shop.calibrate.figure import comparable, residuals
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.result import Calibration, catalogue_text
from grind_env.shop.calibrate.table_calibration import calibrate_table
from grind_env.shop.calibrate.verdict import FitJudgement
from tests.command import status
from tests.examples import few
from tests.shop.blemished import Style, write_log
from tests.shop.programs import EXAMPLES
from tests.shop.test_document import Parsed, loads_nothing
from tests.shop.test_report import cells, section

pytest.importorskip("matplotlib")

pytestmark = pytest.mark.usefixtures("few_lots")

HOSTILE = "<img src=x onerror=alert`1`>"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def numbers(text: str) -> list[float]:
    return [float(each) for each in NUMBER.findall(text)]


def pictures(html: str) -> list[str]:
    """Return the figures of a page without scripts."""
    return re.findall(r"<svg.*?</svg>", html, re.DOTALL)


def assert_marks_at(svg: str, color: str, x: Any, y: Any) -> None:
    """Assert that the marks of a colour lie at the values on linear scales; the last mark is the legend's."""
    marks = re.findall(r'<use [^>]*x="([^"]*)" y="([^"]*)" style="([^"]*)"', svg)
    drawn = np.array([(float(left), float(down)) for left, down, style in marks if f"var(--{color})" in style][:-1])
    assert len(drawn) == len(x)
    for pixels, those in zip(drawn.T, (x, y), strict=True):
        if np.ptp(those) > 0.0:
            scale = np.polyfit(those, pixels, 1)
            np.testing.assert_allclose(pixels, np.polyval(scale, those), atol=0.03)


def code_lines(html: str) -> list[str]:
    return [unescape(line) for line in re.findall(r"<code>(.*?)</code>", html, re.DOTALL)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the plate and its job under a name that is markup."""
    folder = tmp_path_factory.mktemp("reports")
    text = (EXAMPLES / "plate_g82.nc").read_text("utf-8")
    (folder / f"{HOSTILE}.nc").write_text(text.replace("(", f"({HOSTILE} ", 1), encoding="utf-8")
    shutil.copy(EXAMPLES / "plate_g82.toml", folder / f"{HOSTILE}.toml")
    return folder


@pytest.mark.usefixtures("coarse_speeds")
@pytest.mark.parametrize(
    ("options", "expected"),
    few([([], 0), (["--vary", "E", "--bounds", "E=8000..9000"], 3), (["--vary", "E", "--margin", "Ra=.2"], 4)]),
)
def test_an_optimisation_report_shows_the_result_of_every_verdict(
    options: list[str], expected: int, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, output, written = folder / f"{HOSTILE}.nc", tmp_path / "out.nc", tmp_path / "r.html"
    files = ["-o", output, "--report", written]
    words = ("optimise", program, "--parts", "3", "--budget", "1000s")
    assert status(*words, *options, *files, "--json") == expected
    found, html = json.loads(capsys.readouterr().out), written.read_text("utf-8")

    quantities = cells(section(html, "Before and after"))
    of_a_part = [each for each in found["quantities"] if each["name"] != "highest_rise"]  # the job has no stages
    for row, each in zip(quantities, of_a_part, strict=True):
        for text, name in zip(row[1:4], ("before", "after", "difference"), strict=True):
            decimals = len(text.split(" ")[0].partition(".")[2])
            asked = [each[name][end] for end in ("value", "low", "high")]
            assert numbers(text) == pytest.approx(asked, abs=0.51 * 10.0**-decimals)

    for row, each in zip(cells(section(html, "Words")), found["words"], strict=True):
        assert row[:3] == [each[name] for name in ("place", "name", "before")]
        assert row[3] == (each["after"] if each["changed"] else "as it is")

    limits = [each for each in found["limits"] if each["limit"] > 0.0]
    rows = cells(section(html, "Limits"))
    assert [row[0] for row in rows] == [each["name"] for each in limits]
    for row, each in zip(rows, limits, strict=True):
        shares = [100.0 * each[name] for name in ("margin", "before", "after")]
        assert [float(text) for text in row[2:5]] == pytest.approx(shares, abs=0.51)
        if each["price"]:
            assert numbers(row[5])[0] == pytest.approx(-each["price"]["value"], abs=5.1e-4)
        assert row[5].endswith("binds") == each["binds"]
    drawn = {name: [100.0 * each[name] for each in limits] for name in ("before", "after")}
    rows = np.arange(len(limits))
    (svg,) = pictures(section(html, "Limits"))
    assert_marks_at(svg, "grey", drawn["before"], rows)
    assert_marks_at(svg, "blue", drawn["after"], rows)

    assert code_lines(section(html, "Program")) == [line.rstrip() for line in found["text"].splitlines()]
    changed = set(found["text"].splitlines()) - set(program.read_text("utf-8").splitlines())
    assert section(html, "Program").count('<div class="note') == len(changed)
    headline = unescape(section(html, "Verdict"))
    if expected:
        assert found["reason"] in headline and not output.exists()
        assert "stays as it is" in section(html, "Program")
    else:
        gain = found["quantities"][[each["name"] for each in found["quantities"]].index("cost")]["difference"]
        assert f"costs {-gain['value']:.3f} ({-gain['high']:.3f} to {-gain['low']:.3f}) $ less" in headline
        assert output.read_text("utf-8").splitlines() == found["text"].splitlines()
    assert HOSTILE in "".join(Parsed(html).texts) and loads_nothing(Parsed(html))


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    """Return a log of three plates; the last one is held out."""
    path = folder / f"{HOSTILE}.csv"
    job = load_job(EXAMPLES / "plate_g82.toml")
    write_log(path, read_file(EXAMPLES / "plate_g82.nc"), job, 3, Style(scale=0.0), np.random.default_rng(5))
    return path


@pytest.fixture(scope="module")
def found(folder: Path, log: Path) -> Calibration:
    return calibrate(log, folder / f"{HOSTILE}.nc", folder / f"{HOSTILE}.toml")


def assert_page_agrees(html: str, found: Calibration) -> None:
    """Assert that the page shows the result of the calibration."""
    told = [each for each in found.estimates if each.determined]
    assert f"tell {len(told)} of {len(found.estimates)} constants" in section(html, "Verdict")
    rows = cells(section(html, "Constants"))
    for row, each in zip(rows, found.estimates, strict=True):
        assert row[0] == f"{each.parameter.entry} {each.parameter.key}"
        assert float(row[1]) == pytest.approx(each.parameter.prior, rel=1e-3)
        assert float(row[2]) == pytest.approx(each.value, rel=1e-3)
        assert [float(text) for text in row[3].split(" to ")] == pytest.approx([each.low, each.high], rel=1e-2)
        assert row[6] == ("told" if each.determined else "kept")

    shown = section(html, "Measured and modelled")
    drawn = iter(pictures(shown))
    for kind in found.data.kinds:
        mine = found.data.kind == kind
        used = mine & found.fit.used
        measured, modelled = found.data.value, found.fit.predicted
        compared, left = next(drawn), next(drawn)
        assert_marks_at(compared, "grey", found.fit.nominal[mine], measured[mine])
        assert_marks_at(compared, "blue", modelled[used], measured[used])
        odd = used & (found.data.part % 2 == 1)
        residual = measured - modelled if kind == "power" else measured / modelled - 1.0
        for color, which in (("blue", odd), ("orange", used & ~odd)):
            assert_marks_at(left, color, np.zeros(which.sum()), residual[which])
    assert next(drawn, None) is None
    assert [line.rstrip() for line in catalogue_text(found).splitlines()] == code_lines(section(html, "Catalogue file"))
    assert loads_nothing(Parsed(html))


def test_a_calibration_report_shows_the_result(
    folder: Path, log: Path, found: Calibration, capsys: pytest.CaptureFixture[str]
) -> None:
    program, job, written = folder / f"{HOSTILE}.nc", folder / f"{HOSTILE}.toml", folder / "cal.html"
    assert status("calibrate", log, "--program", program, "--job", job, "--report", written, "--json") == 0
    data, html = json.loads(capsys.readouterr().out), written.read_text("utf-8")
    assert [each["value"] for each in data["constants"]] == [each.value for each in found.estimates]
    assert_page_agrees(html, found)
    assert "These values differ from the built-in catalogue" in section(html, "What the numbers rest on")
    reading = unescape(section(html, "Reading of the measurements"))
    assert f"correlation of {found.quality:.3f}" in reading
    assert found.idle is not None and f"Idle power {found.idle.mean:.0f} W" in reading
    assert "power_limit is written as" in reading
    assert all(remark in reading for remark in found.remarks)
    verdict = unescape(section(html, "Verdict"))
    assert verdict.strip().count(found.verdict.headline) == 1
    assert data["verdict"]["headline"] == found.verdict.headline
    assert found.judged.held_out is not None
    assert f"{100.0 * found.judged.held_out['power'][2]:.1f} % on left-out parts" in verdict


def test_an_insignificantly_larger_error_of_the_fit_is_said_to_be_so(found: Calibration) -> None:
    errors = {"size": (1, 2.12, 2.79), "Ra": (2, 0.5, 0.1)}
    for worse, end in ((), "2.12 um, a difference within the scatter."), (("size",), "2.12 um."):
        size, Ra = error_sentences(replace(found, judged=FitJudgement(errors, errors, worse)))
        assert size.endswith(f"with the catalogue {end}") and Ra.endswith("with the catalogue 50.0 %.")


def test_residuals_of_each_part_are_drawn_in_order_of_time(found: Calibration) -> None:
    drawn = residuals(found, found.data.kinds[0]).series
    chosen, odd, used = comparable(found, found.data.kinds[0]), found.data.part % 2 == 1, found.fit.used
    places = np.full(found.data.part.size, np.nan)
    for each, which in zip(drawn, (used & odd, used & ~odd, ~used), strict=True):
        places[chosen & which] = each.x
    for part in set(found.data.part.tolist()):
        mine = np.flatnonzero(chosen & (found.data.part == part))
        assert np.all(np.diff(places[mine[np.argsort(found.time[mine])]]) > 0.0)


def test_a_calibration_without_a_result_gets_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Roughness does not determine the stiffness, and no catalogue file is written."""
    table = tmp_path / "table.csv"
    table.write_text("table_speed [m/min];downfeed [um];volume;Ra\n8;5;40;0.5\n14;5;40;0.9\n20;15;40;0.4\n", "utf-8")
    job, written, output = EXAMPLES / "plate_g82.toml", tmp_path / "cal.html", tmp_path / "shop.toml"
    options = ["--job", job, "--fit", "stiffness", "--report", written, "-o", output]
    assert status("calibrate", table, *options) == 2
    assert "determines no constant" in capsys.readouterr().err
    html = written.read_text("utf-8")
    assert calibrate_table(table, job, names=["stiffness"]).tells_nothing and not output.exists()
    assert "tell 0 of 1 constants" in section(html, "Verdict")
    assert "None:" in section(html, "Catalogue file")
