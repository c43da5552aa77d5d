import re
from dataclasses import replace

import pytest

from agents.commands.studies import DRESSES
from agents.dressing.findings import DressFinding, csv_text
from agents.dressing.table import COLUMNS, DressStudy, read_studies, read_study
from agents.provenance import ROOT
from grind_env.data_table import table_of
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.task_version import TASK_VERSION

PAGE = ROOT / "docs" / "benchmark" / "dress-study.md"

PLAN = DressFinding(
    task="rush",
    question="plan",
    policy="interval",
    sees="measurements",
    every=4,
    lead=0.1,
    depth=0.02,
    passes=2,
    overlap=2.8,
    E=9.0,
    D=0.25,
    cost=6.0,
    cost_low=5.5,
    cost_high=6.5,
    scrap=0.01,
)


def decider(policy, cost):
    return replace(PLAN, question="decision", policy=policy, every=0, cost=cost)


FOUND = [
    replace(PLAN, question="interval", every=2, cost=5.9),
    PLAN,
    replace(PLAN, question="dresser", lead=0.14, depth=0.01, overlap=1.4, cost=3.0, every=8),
    replace(PLAN, question="passes", passes=2, cost=5.9),
    replace(PLAN, question="passes", passes=3, cost=5.0),
    decider("power_threshold", 4.4),
    decider("hindsight", 4.0),
]


def line(study):
    shown = table_of(COLUMNS, [study])
    return dict(zip(shown.headings, (cell.text for cell in shown.rows[0]), strict=True))


def test_a_study_of_another_task_version_is_not_in_the_table(tmp_path):
    text, number = csv_text(FOUND, range(2_000_000, 2_000_064)), TASK_VERSION
    for name, version in (("new", number), ("old", number - 1)):
        lines = text.replace(f",{number},2000000..", f",{version},2000000..").replace("rush", name)
        (tmp_path / f"{name}.csv").write_text(lines, encoding="utf-8")
    unnumbered = [line.replace(f",{number},2000000..", ",2000000..") for line in text.splitlines()]
    unnumbered[0] = unnumbered[0].replace("task_version,", "")
    (tmp_path / "older.csv").write_text("\n".join(unnumbered), encoding="utf-8")
    assert [read_study(tmp_path / f"{name}.csv").task_version for name in ("new", "old", "older")] == [
        number,
        number - 1,
        1,
    ]
    assert [line(study)["task"] for study in read_studies(tmp_path)] == ["new"]


def test_a_table_line_by_hand():
    assert line(DressStudy([*FOUND, decider("plain_gru", 4.2)], 64)) == {
        "task": "rush",
        "episodes": "64",
        "best N": "4",
        "fixed plan, $": "6.00 (+50 %)",
        "power threshold, $": "4.40 (+10 %)",
        "plain_gru, $": "4.20 (+5 %)",
        "hindsight, $": "4.00",
        "best lead, mm": "0.14",
        "depth, mm": "0.01",
        "overlap": "1.4",
        "N": "8",
        "fixed plan with it, $": "3.00 (-25 %)",
        "best passes": "3 5.00 (+25 %)",
    }
    assert line(DressStudy(FOUND, 64))["plain_gru, $"] == "–"


def test_a_study_without_dresser_questions_leaves_their_cells_empty():
    cells = line(DressStudy([each for each in FOUND if each.question not in ("dresser", "passes")], 64))
    told = [*line(DressStudy(FOUND, 64)).items()][:7]
    assert [*cells.items()][:7] == told
    assert {cells[name] for name in cells.keys() - dict(told).keys()} == {"–"}


def test_a_table_is_read_as_written(tmp_path):
    path = tmp_path / "rush.csv"
    path.write_text(csv_text(FOUND, range(2_000_000, 2_000_064)), encoding="utf-8")
    assert read_study(path) == DressStudy(FOUND, 64)


WITHOUT_PLAN = csv_text([each for each in FOUND if each.question != "plan"], range(2))


@pytest.mark.parametrize(
    ("text", "why"),
    [("", ""), ("task\nrush\n", ""), ("task,every\nrush,often\n", ""), (WITHOUT_PLAN, ".it does not answer 'plan'.:")],
)
def test_a_damaged_table_is_an_error(text, why, tmp_path):
    path = tmp_path / "rush.csv"
    path.write_text(text, encoding="utf-8")
    remedy = "run `python -m agents dress-study --task rush`"
    with pytest.raises(ConfigError, match=rf"rush\.csv is damaged .*{why}.* {remedy}"):
        read_study(path)


def test_costs_on_the_page_come_from_the_checked_in_studies():
    text = PAGE.read_text(encoding="utf-8")
    studies = read_studies(DRESSES)
    if not studies:  # no study of this version yet: the page names the version before
        assert f"task version {TASK_VERSION - 1}**" in text
        return
    assert len(studies) == 8
    told = set(re.findall(r"\d+\.\d\d\b", text))
    assert told
    assert told <= {f"{each.cost:.2f}" for study in studies for each in study.found}
