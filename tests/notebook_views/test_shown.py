"""Notebook views show the numbers and escaped texts of an object; they load and run nothing."""

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.control import read
from grind_env.envs.tasks import Kind, Task
from grind_env.machine.record import UNITS, GrindingRecord, RecordError
from grind_env.notebook_views.markup import MOST_ITEMS, MOST_ROWS, fragment, items, listing, paragraphs, table
from grind_env.pages import page
from grind_env.policies.score_statistics import Interval
from grind_env.policies.scoring import Judgement
from grind_env.shop.optimise.result import LimitUse, Optimised, PartMean, Requirement, Trade, Verdict, WordChange
from grind_env.shop.sweep.study import Sweep
from tests.examples import examples
from tests.machine.harness import CYCLE, HEAD, job, run

PLATE = grind_env.examples.path("plate_g82.nc")
PLAIN = {"div", "p", "b", "table", "thead", "tbody", "tr", "th", "td", "ul", "li", "pre"}
HOSTILE = '<script>alert("1")</script>&lt;$x$'


class Shown(HTMLParser):
    """Parser of the table rows and the text of a view; it checks that the HTML is well formed and loads nothing."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows: list[list[str]] = []
        self.said = ""
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in PLAIN
        assert {name for name, _ in attrs} <= {"style", "class", "colspan"}
        assert not any("url" in (value or "") for _, value in attrs)
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.said += data
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data

    def column(self, heading: str) -> list[str]:
        """Return the cells below a heading."""
        first = next(k for k, row in enumerate(self.rows) if heading in row)
        rows = [row for row in self.rows[first + 1 :] if len(row) == len(self.rows[first])]
        return [row[self.rows[first].index(heading)] for row in rows]


def shown(thing: Any) -> Shown:
    return Shown(thing._repr_html_())


@pytest.fixture(scope="module")
def record() -> GrindingRecord:
    return run(HEAD + CYCLE.replace("P9100", "P9100 D1") + "M30\n", job(roughness_limit=0.05))


@pytest.fixture(scope="module")
def swept() -> Sweep:
    return grind_env.sweep(PLATE, E=(12_000, 20_000), dress_every=(1, 3), parts=3)


@given(st.text() | st.just(HOSTILE) | st.text("<>&\"'/$\x1b"))
@examples(100)
def test_any_text_is_shown_as_it_is_and_never_read_as_markup(text: str) -> None:
    html = fragment(text, table((text, "b"), [(text, text)]), paragraphs([text]), items([text]), listing([text]))
    found = Shown(html)
    printed = found.rows[1][0]
    assert found.rows == [[printed.replace("\n", " "), "b"], [printed, printed]]
    if text.isprintable():
        assert printed == text


def test_a_long_table_shows_its_first_and_last_rows() -> None:
    found = Shown(table(("n",), [(str(k),) for k in range(200)]))
    assert found.rows[1] == ["0"] and found.rows[-1] == ["199"]
    assert len(found.rows) == 2 + MOST_ROWS
    assert [f"… {200 - MOST_ROWS} more"] in found.rows


def test_a_long_list_shows_its_first_and_last_items() -> None:
    shown = items(f"item {k}." for k in range(300))
    assert shown.count("<li>") == MOST_ITEMS + 1
    assert "item 0." in shown
    assert f"… {300 - MOST_ITEMS} more" in shown
    assert "item 299." in shown
    assert "more" not in items(f"item {k}" for k in range(MOST_ITEMS))


def test_a_record_shows_the_numbers_of_its_parts_and_exceeded_limits(record: GrindingRecord) -> None:
    found, part = shown(record), record.parts[0]
    assert float(found.column("Ra µm")[0]) == pytest.approx(part["Ra"], abs=0.005)
    assert float(found.column("power kW")[0]) == pytest.approx(part["peak_power"] / 1000.0, abs=0.005)
    assert float(found.column("cost $")[0]) == pytest.approx(part["total_cost"], abs=0.005)
    assert "beyond the limit of Ra" in found.said


@pytest.mark.parametrize("name", ["strokes", "executions", "dresses", "parts"])
def test_data_frames_label_every_column_with_name_and_unit(name: Any, record: GrindingRecord) -> None:
    pytest.importorskip("pandas")
    frame, rows = record.to_dataframe(name), getattr(record, name)
    assert len(frame) == len(rows) > 0
    for field, column in zip(rows.dtype.names, frame, strict=True):
        assert column == (f"{field} [{UNITS[field]}]" if field in UNITS else field)
        np.testing.assert_array_equal(frame[column].to_numpy(), rows[field])


def test_fields_without_a_unit_are_names_numbers_and_shares() -> None:
    from grind_env.machine.part.block_totals import EXECUTION_ROW
    from grind_env.machine.part.stroke_record import STROKE_ROW
    from grind_env.machine.record import DRESS_ROW, PART_ROW

    names = {name for dtype in (STROKE_ROW, EXECUTION_ROW, DRESS_ROW, PART_ROW) for name in dtype.names or ()}
    counted = {"part", "line", "number", "groove", "after", "program", "cause", "strokes", "infeeds", "dresses"}
    shares = {"torque", "eps", "G", "A", "lam", "unground", "peak_torque", "burn_ratio", "earlier", "survival"}
    compared = {"first", "speed_ratio", "aggressiveness", "overlap", "severity"}
    assert names - set(UNITS) == counted | shares | compared


def test_an_unknown_table_of_a_record_is_refused(record: GrindingRecord) -> None:
    with pytest.raises(RecordError, match=r"'cost'.*strokes, executions, dresses, parts"):
        record.to_dataframe("cost")


def test_a_program_shows_its_escaped_text_with_line_numbers() -> None:
    said = f"%\n({HOSTILE})\r\nN10 G71\n" + "N20 G04 P1\n" * 100
    found = shown(read(said, HOSTILE))
    assert found.said.startswith(HOSTILE)
    assert f" 2  ({HOSTILE})\n" in found.said
    assert "… 43 more lines" in found.said


def test_a_script_shows_its_blocks() -> None:
    script = grind_env.script_of(
        grind_env.read_program(PLATE), grind_env.load_job(grind_env.examples.path("plate_g82.toml"))
    )
    found = shown(script)
    assert found.column("block") == ["N50", "N70"]
    assert found.column("E, mm/min") == ["15000", "9000"]
    assert found.column("depth at end, mm") == ["0.17", "0.2"]


@given(st.sampled_from(["<script>", "</td>", 'a"b', "a & b", "$x$"]))
@examples(5)
def test_a_task_shows_its_kinds_of_block(name: str) -> None:
    size = {"width": 20.0, "length": 200.0, "height": 20.0}
    kind = Kind(name=name, material="aisi_52100", stock=0.2, pick=0.01, tolerance=9.0, **size)
    task = Task(name=name, title=HOSTILE, blocks=10, reference_cost=2.0, kinds=(kind,), sequence=(name,))
    found = shown(task)
    assert HOSTILE in found.said
    assert found.column("block") == [name]
    assert [float(found.column(heading)[0]) for heading in ("stock, mm", "width, mm", "tolerance, µm")] == [0.2, 20, 9]
    assert found.column("Ra limit, µm") == [""]


def test_a_bundled_task_shows_the_page_of_its_id_and_a_file_its_own_keys(tmp_path: Path) -> None:
    task = grind_env.load_task("slot")
    assert task.page() == page("grind/Slot-v0")
    assert task.page()._repr_markdown_() == task.page()
    file = tmp_path / "mine.toml"
    file.write_text('base = "slot"\nblocks = 6\n', encoding="utf-8")
    assert "\nblocks = 6\n" in grind_env.load_task(str(file)).page()


def test_an_evaluation_shows_cost_score_and_their_intervals() -> None:
    found = grind_env.evaluate("E8000D1", "grind/PowerLimited-v0", episodes=2)
    rows = {row[0]: row[1:] for row in shown(found).rows}
    cost = found.evaluation.cost_per_good_part
    assert rows["cost, $ per good part"] == [f"{cost.value:.3f}", f"{cost.low:.3f} to {cost.high:.3f}"]
    assert float(rows["E, mm/min"][0]) == 8000.0
    assert found.score is not None and rows["score"][0] == f"{found.score.value:.1f}"
    assert {row[0] for row in shown(found.evaluation).rows} == set(rows) - {"score"}
    assert HOSTILE in shown(replace(found, policy=HOSTILE)).said
    assert isinstance(found, Judgement)


def test_a_sweep_shows_the_costs_of_its_points(swept: Sweep) -> None:
    found = shown(swept)
    assert found.column("every, parts")[:3] == ["1", "2", "3"]
    assert found.column("cost, $")[0] == f"{swept.own.cost.value:.3f}"
    assert f"cheapest: {swept.best.cost.value:.3f} $ a part" in found.said


def test_an_optimisation_shows_its_changes_and_writes_only_better_programs(tmp_path: Path) -> None:
    same = Interval(2.0, 1.9, 2.1)
    limit = LimitUse(
        name="Ra", limit=0.5, unit="um", margin=1.0, before=0.6, after=0.7, price=None, without=None, binds=False
    )
    found = Optimised(
        program=HOSTILE,
        job="plate.toml",
        verdict=Verdict.BETTER,
        reason="less beyond chance",
        words=(WordChange(name="E", place="N50", before="15000.", after="17000.", unit="mm/min", at_bound=""),),
        quantities=(
            PartMean(
                name="cost", unit="$", before=same, after=same, difference=Interval(-0.1, -0.2, 0.0), expected=(2, 1.9)
            ),
        ),
        limits=(limit,),
        requirements=(Requirement("seconds", "s", 75.0, 80.0, 70.0),),
        objective="cost",
        cheapest=(Trade(2.0, 70.0, 0.9),),
        chosen=(Trade(2.5, 80.0, 0.8), Trade(2.0, 70.0, 0.9)),
        remarks=(HOSTILE,),
        before="",
        after="",
        data=b"G82\r\n",
        parts=50,
        counted="part",
        lots=256,
        seed=1,
        evaluations=3,
        judged=1,
        ended_early=False,
    )
    assert ["N50", "E", "15000.", "17000.", "mm/min"] in shown(found).rows
    assert ["cost, $", "2.000", "2.000", "-0.100 (-0.200 to +0.000)", "2.000", "1.900"] in shown(found).rows
    found.write(tmp_path / "better.nc")
    assert (tmp_path / "better.nc").read_bytes() == found.data
    with pytest.raises(grind_env.errors.GrindError, match="not written"):
        replace(found, verdict=Verdict.NOT_BETTER).write(tmp_path / "worse.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["better.nc"]


def test_plots_display_in_a_notebook_and_their_axes_have_units(record: GrindingRecord, swept: Sweep) -> None:
    pytest.importorskip("matplotlib")
    for figure in (record.plot(), swept.plot()):
        assert figure._repr_png_().startswith(b"\x89PNG")
        labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
        assert all(", " in label or "$" in label or "%" in label or label == "burn ratio" for label in labels), labels
