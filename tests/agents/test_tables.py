import io
import re
from dataclasses import replace

import numpy as np
import pytest
from pyarrow import parquet
from rich.console import Console

from agents.benchmark.aggregate import aggregates, all_runs, scored_tasks
from agents.benchmark.page import page
from agents.benchmark.plan import BenchmarkCell
from agents.benchmark.readme import BEGIN, CORE_BEGIN, CORE_END, END, PAGE, README, core_tasks, replaced
from agents.benchmark.results import read_results, result_of, write_results
from agents.benchmark.scoring import is_ratio, judged
from agents.benchmark.summary import ON_SCREEN, summaries, table_of_task
from agents.evaluation_cache import RESULTS
from agents.provenance import ROOT
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.score_statistics import bootstrap, cost_per_good_part, normalised_score
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.task_version import TASK_VERSION
from tests.agents.asking import evaluation

RNG = np.random.default_rng(1)
N = 40


def row(task, policy, cost, seed=None, sees="measurements", good=None):
    run = evaluation(*cost, good=1.0 if good is None else good, finished=2.0)
    return result_of(BenchmarkCell(find_problem(task), policy, seed), sees, run)


def table_of(task, learned, noise=1.0):
    """Return rows: plans cost about 8 and 6, the planner about 2, and agents about `learned`."""
    shared = noise * RNG.exponential(1.0, N)
    rows = [
        row(task, "constant", 8.0 + shared),
        row(task, "interval", 6.0 + shared),
        row(task, "hindsight", 2.0 + 0.5 * shared, sees="future"),
    ]
    rows += [row(task, "ppo", cost + 0.5 * shared, seed=k) for k, cost in enumerate(learned)]
    return rows


def by_policy(results, task):
    return {line.policy: line for line in summaries(results, task)}


def test_one_run_has_the_interval_of_the_episodes():
    good = RNG.uniform(0.5, 1.0, N).astype(np.float32)
    rows = [*table_of("rush", [])[:3], row("rush", "ppo", RNG.exponential(3.0, N), seed=0, good=good)]
    line = by_policy(rows, "rush")["ppo"]
    cost, fixed, planner = (np.asarray(rows[k].cost, float) for k in (3, 1, 2))
    assert line.cost == pytest.approx(bootstrap(cost_per_good_part, cost, np.asarray(good, float)), rel=1e-9)
    assert line.score == pytest.approx(bootstrap(normalised_score, cost, fixed, planner), rel=1e-9)
    assert line.ratio.value == pytest.approx(cost.mean() / fixed.mean())
    assert line.runs == 1


def test_runs_of_a_policy_are_averaged_and_widen_its_interval():
    rows = table_of("rush", [2.0, 4.0, 6.0], noise=0.0)
    line = by_policy(rows, "rush")["ppo"]
    assert line.runs == 3
    assert line.score.value == pytest.approx(50.0)
    # no noise between episodes: the mean of three draws from 0, 50, 100 is 0 or 100 once in 27 times each
    assert (line.score.low, line.score.high) == pytest.approx((0.0, 100.0))
    assert line.cost.value == pytest.approx(4.0)
    assert by_policy(rows, "rush")["constant"].score == pytest.approx((-50.0, -50.0, -50.0))


def test_a_table_lists_the_policies_with_least_information_first():
    rows = judged([*table_of("rush", [3.0]), row("rush", "mpc", np.full(N, 2.2), sees="state")])
    assert [line.policy for line in summaries(rows, "rush")] == ["constant", "interval", "ppo", "mpc", "hindsight"]
    console = Console(width=160, record=True, file=io.StringIO())
    table_of_task(rows, "rush", "a title", ON_SCREEN).print(console)
    text = console.export_text()
    assert "a title" in text
    headings = table_of_task(rows, "rush").headings
    assert [heading in text for heading in headings] == [k < ON_SCREEN for k in range(len(headings))]


def test_a_task_with_nearly_equal_anchors_reports_the_ratio():
    assert is_ratio("slot")
    assert not is_ratio("rush")
    rows = table_of("slot", [7.2], noise=0.0)
    (text,) = [row[1].text for row in table_of_task(rows, "slot").rows if row[0].text == "ppo"]
    assert text == "1.200x (1.200 to 1.200)"
    assert list(scored_tasks([*rows, *table_of("rush", [])])) == ["rush"]
    assert "1.200x (1.200 to 1.200)" in page(rows)


def test_aggregates_are_over_tasks_and_runs():
    rows = [*table_of("rush", [2.0, 4.0], noise=0.0), *table_of("blades", [3.0, 5.0, 100.0], noise=0.0)]
    runs = all_runs(rows)
    # the first two runs of each task, blades first
    assert runs["ppo"].scores == pytest.approx(np.array([[75.0, 100.0], [25.0, 50.0]]))
    found = aggregates(runs)
    assert list(found) == ["hindsight", "ppo", "interval", "constant"]
    assert found["ppo"]["mean"].value == pytest.approx(62.5)
    assert found["ppo"]["IQM"].value == pytest.approx(62.5)
    assert found["ppo"]["mean"].low < 62.5 < found["ppo"]["mean"].high


def test_scores_are_clipped_in_aggregates_only():
    rows = table_of("rush", [100.0], noise=0.0)
    assert by_policy(rows, "rush")["ppo"].score.value < -2000.0
    assert aggregates(all_runs(rows))["ppo"]["mean"] == (-100.0, -100.0, -100.0)


def test_aggregates_leave_out_a_policy_missing_in_a_task():
    rows = [*table_of("rush", [3.0]), *table_of("blades", [])]
    assert "ppo" not in all_runs(rows)
    # a task of one kind of block has no constant per kind; the constant takes its place
    rows = [*table_of("power_limited", []), *table_of("rush", []), row("rush", "constant_per_kind", np.full(N, 5.0))]
    runs = all_runs(rows)
    assert runs["constant_per_kind"].scores[0, 0] == runs["constant"].scores[0, 0]
    assert runs["constant_per_kind"].scores[0, 1] != runs["constant"].scores[0, 1]


def test_the_section_of_a_page_is_replaced_between_its_markers():
    rows = judged([*table_of("power_limited", [3.0, 3.5]), *table_of("slot", [5.0])])
    core = f"{CORE_BEGIN}\n\n{core_tasks(rows)}\n\n{CORE_END}"
    assert "| [PowerLimited][r] | wide plates at the power limit | lot's dulling rate | " in core
    assert "| [Rush][r] | orders with due dates | lot's dulling rate | – |" in core
    written = replaced(f"above\n{BEGIN}\nold\n{END}\nbelow\n{core}", rows)
    assert written.startswith(f"above\n{BEGIN}\n\n")
    assert written.endswith(f"\n\n{END}\nbelow\n{core}")
    assert "old" not in written
    assert replaced(written, rows) == written
    (line,) = re.findall(r"^\| hindsight \| .*$", written, re.MULTILINE)
    score = by_policy(rows, "power_limited")["hindsight"].score
    assert f"{score.value:.1f} ({score.low:.1f} to {score.high:.1f})" in line
    with pytest.raises(ConfigError, match="no lines"):
        replaced("a page without markers", rows)


def test_the_page_states_version_seeds_and_commit_of_its_results():
    bare, *others = table_of("slot", [5.0])
    agent = replace(bare, policy="ppo", seed=1, trained_on="inner", interpolation_seeds="3000000..3000063")
    said = f"Made with: task version {TASK_VERSION}; evaluation seeds {bare.seeds}; interpolation seeds"
    assert f"{said} 3000000..3000063; training split inner; commit {bare.commit}." in page(
        judged([agent, bare, *others])
    )


def test_rows_of_another_task_version_are_not_read(tmp_path):
    rows = table_of("rush", [3.0])
    assert {each.task_version for each in rows} == {TASK_VERSION}
    write_results([*rows[1:], replace(rows[0], task_version=TASK_VERSION - 1)], tmp_path)
    assert [each.key for each in read_results(tmp_path)] == [each.key for each in rows[1:]]


@pytest.fixture(scope="module")
def checked_in():
    """Return the published results; two tests share their resamples."""
    return read_results(RESULTS)


def test_readme_and_page_match_the_checked_in_results(checked_in):
    text, published = (path.read_text(encoding="utf-8") for path in (README, ROOT / PAGE))
    if not checked_in:  # no results of this version yet: both pages name the version before
        assert f"Task version {TASK_VERSION - 1}" in text and f"**Task version {TASK_VERSION - 1}" in published
    else:
        assert replaced(text, checked_in) == text and published == page(checked_in)


def test_judging_the_checked_in_results_gives_their_scores(checked_in):
    results = checked_in
    for old, new in zip(results, judged(results), strict=True):
        assert (old.task, old.policy) == (new.task, new.policy)
        assert (old.score, old.score_low, old.score_high) == pytest.approx((new.score, new.score_low, new.score_high))
        assert old.cost_per_good_part == pytest.approx(new.cost_per_good_part)


def test_checked_in_results_use_evaluation_seeds_only(checked_in):
    for each in checked_in:
        first, last = map(int, each.seeds.split(".."))
        assert 2_000_000 <= first <= last < 2_500_000
        assert last - first + 1 == each.episodes == len(each.cost)
        if each.interpolation_seeds is not None:
            first, last = map(int, each.interpolation_seeds.split(".."))
            assert first == 2_000_000
            assert last - first + 1 == each.interpolation_episodes == len(each.interpolation_cost)
        assert (each.trained_on is not None) == (each.kind == "learned")


@pytest.mark.parametrize("column", ["score", "cost"])
def test_a_table_without_a_column_is_damaged(column, tmp_path):
    write_results(table_of("rush", []), tmp_path)
    path = tmp_path / "benchmark.parquet"
    parquet.write_table(parquet.read_table(path).drop_columns(column), path)
    with pytest.raises(ConfigError, match=f"benchmark.parquet is damaged .it has no column '{column}'.: delete it"):
        read_results(tmp_path)


def test_judging_updates_only_the_score_of_a_changed_row():
    rows = judged(table_of("rush", [3.0]))
    worse = judged([replace(each, cost=each.cost * 2.0) if each.policy == "ppo" else each for each in rows])
    assert worse[-1].score < rows[-1].score
    assert [each.score for each in worse[:-1]] == [each.score for each in rows[:-1]]
