"""The page of fields against the dataclasses, and the figure of published series against its data."""

import re
from dataclasses import fields

import numpy as np
import pytest

from grind_env.envs.tasks.reading import TABLES
from grind_env.envs.tasks.tables import Kind
from grind_env.machine.job import Diamond, Lots, Part, Setup, Stage, Times, WheelStart
from grind_env.machine.job.drawn_machines import USUAL_SPREADS
from grind_env.pages.file_keys import fields_page
from grind_env.pages.validation_figure import MACHINES, PublishedSeries, by_machine, plot_series
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.entries import Quantity, quantities
from grind_env.validation import measured_data

PAGE = fields_page()
JOB, CATALOGUE, TASK = (re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:])[:3]


def rows(text: str, heading: str) -> dict[str, list[str]]:
    """Return the cells of the first table under a heading, by key."""
    part = text.partition(f"### {heading}\n")[2].partition("\n### ")[0]
    lines = [line for line in part.splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return {row[0].strip("`"): row[1:] for row in cells}


@pytest.mark.parametrize(
    ("heading", "table"),
    [
        ("[part]", Part),
        ("[[part.stages]]", Stage),
        ("[setup]", Setup),
        ("[times]", Times),
        ("[wheel]", WheelStart),
        ("[diamond]", Diamond),
        ("[lots]", Lots),
    ],
)
def test_every_field_of_a_job_has_unit_range_and_meaning(heading: str, table: type) -> None:
    found = rows(JOB, heading)
    for field in fields(table):
        if field.name == "stages":  # a table of its own
            continue
        unit, holds, default, meaning = found[field.name]
        quantity = next((each for each in getattr(field.type, "__metadata__", ()) if isinstance(each, Quantity)), None)
        assert default and meaning
        if quantity is not None:
            assert unit == (quantity.unit or "–") and str(quantity) in holds


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_of_a_catalogue_entry_has_symbol_unit_and_range(kind: str) -> None:
    found = rows(CATALOGUE, f"[{kind}.NAME]")
    for key, legal in quantities(KINDS[kind]).items():
        cells = found[key]
        if isinstance(legal, Quantity):
            assert cells[:3] == [legal.symbol, legal.unit or "–", f"{legal.low:g} to {legal.high:g}"]
    for name, entry in getattr(load_catalogue(), f"{kind}s").items():
        assert entry.name == name and name in found


def test_every_field_of_a_task_is_on_the_page() -> None:
    for name, table in {**TABLES, "kind": Kind}.items():
        found = rows(TASK, f"[[{name}]]" if name == "kind" else f"[{name}]")
        assert {field.name for field in fields(table)} <= set(found)


def test_the_machines_of_a_band_differ_by_the_usual_spreads():
    stiffness = by_machine([lambda rig: rig.catalogue.machine("default").stiffness])[:, 0]
    assert stiffness[0] == load_catalogue().machine("default").stiffness
    assert len(stiffness) == 1 + MACHINES
    # the standard error of a standard deviation of 40 draws is 11 %
    assert np.std(np.log(stiffness[1:])) == pytest.approx(USUAL_SPREADS["machine.stiffness"], rel=0.25)
    assert np.ptp(by_machine([lambda rig: rig.catalogue.wheel("b126").g_ratio], wheel="a60j")) == 0.0


def test_the_label_of_a_series_gives_its_level_and_trend():
    x = np.array([1.0, 2.0, 4.0])
    assert PublishedSeries("half", x, 3.0 * x[np.newaxis] ** 0.6).with_errors().name == "half: × 2.3, 23 % (57 %)"
    assert PublishedSeries("flat", x, np.ones((1, 3))).over_mean().with_errors().name == "flat: 57 % (57 %), against"


def test_the_picture_is_drawn_and_its_caption_names_bundled_data(tmp_path):
    caption = plot_series(tmp_path / "series.png")
    assert (tmp_path / "series.png").read_bytes().startswith(b"\x89PNG")
    assert all((measured_data.DATA / name).exists() for name in re.findall(r"`(\w+\.csv)`", caption))
    Ra = [float(run["Ra_um"]) for run in measured_data.rows("flat_grinding_L8_dressing")]
    assert f"Ra: 11 % ({100 * np.std(np.log(Ra)):.0f} %)." in caption
    assert "force, power: NOT measured" in caption
    assert caption.count("against") == 6  # five series, and the note


def test_chip_thickness_of_the_bearing_steel_follows_from_speeds_and_depth():
    for row in measured_data.rows("aisi52100_cbn_conditions"):
        depth, table, wheel = (float(row[name]) for name in ("downfeed", "table_speed", "wheel_speed"))
        assert depth * table / wheel == pytest.approx(float(row["heq_um"]), rel=1e-3)
