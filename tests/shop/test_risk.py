"""Permitted risk: one rule for the search and the sweep."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read_file
from grind_env.machine.grind import grind_file
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.uncertainty import CERTAIN
from grind_env.plants import find_plant
from grind_env.policies.score_statistics import Interval
from grind_env.shop import trials as rule
from grind_env.shop.commands.optimise import optimise as optimise_command
from grind_env.shop.commands.sweep import sweep as sweep_command
from grind_env.shop.optimise import optimisation
from grind_env.shop.optimise.candidate_ranking import front
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.result import Trade
from grind_env.shop.optimise.search_problem import LOTS, one_run
from grind_env.shop.search_options import options_of
from grind_env.shop.sweep.study import LOTS as SWEPT
from grind_env.shop.sweep.study import Sweep, SweepPoint, SweepRanges, sweep
from grind_env.shop.sweep.table import as_data, sentences, tables_of
from grind_env.shop.trials import LotUse, Measures, Trials, lots_of, most_risk, risk
from tests.shop.programs import EXAMPLES, known_job, varied

PATH = EXAMPLES / "plate_g82.nc"


def test_the_risk_is_the_cost_ratio_not_exceeded_on_95_of_100_machines() -> None:
    """Use two lots on each of 101 machines; the new program costs k % more on machine k in the mean."""
    trials = cast(
        Trials, SimpleNamespace(confidence=0.95, by_machine=lambda values: values.reshape(-1, 2, 101).mean(axis=1))
    )
    before = np.tile(np.linspace(2.0, 4.0, 101), 2)
    after = before * np.tile(1.0 + 0.01 * np.arange(101.0), 2) + np.repeat([-0.5, 0.5], 101)
    old, found = (cast(Measures, SimpleNamespace(cost=values[None])) for values in (before, after))
    assert risk(trials, found, old)[0] == pytest.approx(1.95)


@pytest.mark.parametrize(("uncertainty", "most"), [(None, 1.2), (CERTAIN, 1.05)])
def test_the_permitted_risk_is_higher_without_a_calibration(uncertainty: object, most: float) -> None:
    job = replace(load_job(PATH.with_suffix(".toml")), uncertainty=uncertainty)
    assert most_risk(cast(Job, job)) == most


def test_a_sweep_point_and_the_same_settings_in_a_search_have_the_same_risk() -> None:
    found = sweep(PATH, None, SweepRanges(E=(22500.0, 22500.0), every=(3, 3)), parts=6)
    variation = varied(PATH, options_of(["E", "interval"], {"interval": (3, 3)}), 6)
    assert variation.fleet is not None
    trials = variation.fleet.trials_for(variation.base, LotUse.SWEEP, lots_of(1, LotUse.SWEEP, SWEPT))
    levels = [each.nearest(each.own * 3 / 2) for each in variation.choices.variables]
    old, measured = trials.measure(trials.own[None]), variation.measure(trials, [(*levels, variation.start[-1])])
    assert found.speeds[0].risk == pytest.approx(
        variation.risk(trials, measured, old)[0] / most_risk(variation.job), rel=1e-3
    )
    assert found.own.risk == pytest.approx(1.0 / found.most_risk, rel=0.2)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Use few lots and skip the searches without limits."""
    monkeypatch.setitem(LOTS, LotUse.JUDGEMENT, 8)
    monkeypatch.setitem(LOTS, LotUse.COMPARISON, 4)
    monkeypatch.setattr(optimisation, "costs_of_limits", lambda *arguments: {})


@pytest.mark.usefixtures("quick", "coarse_speeds")
def test_a_job_in_memory_gives_the_same_result_as_its_file(tmp_path: Path) -> None:
    words, path = options_of(["E"], {"E": (9000, 18000)}), known_job(tmp_path, "plate_g82")
    one, other = (find_words(PATH, job, words, parts=2, seconds=1000.0) for job in (path, load_job(path)))
    assert other.job == "" and replace(other, job=one.job) == one


def test_a_job_with_a_plant_is_tried_on_the_plant() -> None:
    job = load_job(PATH.with_suffix(".toml"), plant=find_plant("foreign:1"))
    once = one_run(read_file(PATH), job)
    power, other = (grind_file(PATH, each).parts["peak_power"][0] for each in (job, PATH.with_suffix(".toml")))
    assert once.measure(once.own[None]).power[0].mean() == pytest.approx(power / 1000.0, rel=0.02)
    assert abs(other / power - 1.0) > 0.1


def point(cost: float, share: float) -> SweepPoint:
    one = Interval(cost, cost, cost)
    return SweepPoint(
        E=15000.0,
        every=0,
        lead=0.1,
        depth=0.02,
        cost=one,
        seconds=60.0,
        Ra=0.3,
        power=2.0,
        rise=100.0,
        highest_rise=100.0,
        size_error=1.0,
        scrap=0.0,
        shares=(0.5, 0.5, 0.5, 0.5),
        risk=share,
    )


def test_a_sweep_recommends_only_points_within_the_permitted_risk() -> None:
    speeds = replace(point(1.5, 1.1), every=4), replace(point(1.8, 0.9), every=2)
    found = Sweep(
        program="part.nc",
        parts=50,
        lots=128,
        counted="part",
        own=point(2.5, 0.83),
        most_risk=1.2,
        speeds=speeds,
        dresses=(),
    )
    assert found.best == speeds[1] and found.refused == {"risk": speeds[0]}
    assert tables_of(found)[1].rows[1][-1].text == "risk 110 %"
    said = " ".join(sentences(found))
    assert "would cost 1.500 $, but on 5 of 100 machines at least 32 % more than the program as it is" in said
    assert "20 % is accepted" in said
    data = as_data(found)
    assert data["most_risk"] == 1.2 and not data["speeds"][0]["keeps_limits"]


@pytest.mark.parametrize("command", [optimise_command, sweep_command])
def test_the_docs_state_the_permitted_risk_in_numbers(command: object) -> None:
    page = "docs/howto/improve.md"
    assert page in str(command.__doc__)
    assert (
        f"on 95 of 100 machines a part costs at most {rule.CALIBRATED:g} times as much as with the program as it is "
        f"({rule.UNCALIBRATED:g} times without a calibration)"
    ) in " ".join((Path(__file__).parents[2] / page).read_text(encoding="utf-8").split())


trades = st.builds(Trade, st.floats(1.0, 9.0), st.just(60.0), st.floats(0.2, 2.0))


@given(
    st.dictionaries(st.tuples(st.integers(0, 50)), trades, min_size=1, max_size=30), st.sampled_from([(), (1.1, 1.3)])
)
def test_the_front_contains_no_dominated_program(
    tried: dict[tuple[int, ...], Trade], beyond: tuple[float, ...]
) -> None:
    found = [tried[each] for each in front(tried, "cost", beyond)]
    assert not any(other.cost < one.cost and other.share <= one.share for one in found for other in tried.values())
    assert min(each.share for each in found) == min(each.share for each in tried.values()) or beyond
    keeping = [each for each in tried.values() if each.keeps]
    if keeping:
        assert found[0].cost == min(each.cost for each in keeping)
