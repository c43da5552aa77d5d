import dataclasses
import itertools

import numpy as np
import pytest

from agents.parallel_trials import run_all
from agents.tuning import rule_tuning as tune
from agents.tuning.minimisers import BestPoint, CachedCosts, evolve, grid_search, refine
from agents.tuning.tunable_parameters import RULES, vector_size
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.tuned_parameters import HEADING, ConfigError, read_tuned, write_tuned
from tests.agents.asking import run_here
from tests.examples import few

PLATES, ORACLE = find_problem("power_limited"), find_problem("oracle6")


class Killed(Exception):
    """Exception in place of a kill between two evaluations."""


class Limited:
    """Cost function that is killed after some evaluations."""

    def __init__(self, left):
        self.left, self.asked = left, 0

    def __call__(self, points):
        return [self.of(point) for point in points]

    def of(self, point):
        if self.asked == self.left:
            raise Killed
        self.asked += 1
        return float(((np.asarray(point) - [1.0, -2.0, 0.5]) ** 2 * [1.0, 10.0, 100.0]).sum())


def search(path, costs, evaluations=60):
    return evolve(CachedCosts(costs, path), np.zeros(3), evaluations, seed=3)


@pytest.mark.parametrize("killed", [5, 7, 33])
def test_a_killed_search_resumes_to_the_same_result(tmp_path, killed):
    whole = evolve(Limited(1000), np.zeros(3), 60, seed=3)
    path = tmp_path / "trials" / "s.jsonl"
    with pytest.raises(Killed):
        search(path, Limited(killed))
    rest = Limited(1000)
    found = search(path, rest)
    assert np.array_equal(found.point, whole.point)
    assert found.cost == whole.cost
    # a generation in three dimensions has seven points, and is cached whole
    assert rest.asked == whole.evaluations - killed // 7 * 7
    costs = CachedCosts(Limited(0), path).known
    assert len(costs) == whole.evaluations and min(costs.values()) == whole.cost


@pytest.mark.parametrize("step", few([37, 1]))
def test_a_search_killed_during_a_write_resumes_to_the_same_result(tmp_path, step):
    path = tmp_path / "s.jsonl"
    whole = search(path, Limited(1000), 20)
    data = path.read_bytes()
    for size in range(0, len(data), step):
        path.write_bytes(data[:size])
        again = search(path, Limited(1000), 20)
        assert np.array_equal(again.point, whole.point) and again.cost == whole.cost
        nothing = Limited(0)
        assert search(path, nothing, 20).cost == whole.cost


def test_a_finished_search_continues_with_a_larger_budget(tmp_path):
    path = tmp_path / "s.jsonl"
    first = search(path, Limited(1000), 30)
    more = Limited(1000)
    assert search(path, more, 60).cost < first.cost
    assert more.asked == len(CachedCosts(Limited(0), path).known) - first.evaluations


def test_a_fresh_run_or_other_settings_start_with_an_empty_cache(tmp_path):
    tuner = tune.Tuner(ORACLE.simulation(), tmp_path, episodes=1)
    tuner.cached_run("power_threshold", 0).add({(1.0,) * 4: 2.0})
    assert tuner.cached_run("power_threshold", 0).known == {(1.0,) * 4: 2.0}
    assert tuner.cached_run("power_threshold", 1).known == {}
    assert tune.Tuner(ORACLE.simulation(), tmp_path, episodes=2).cached_run("power_threshold", 0).known == {}
    assert tune.Tuner(ORACLE.simulation(), tmp_path, 1, fresh=True).cached_run("power_threshold", 0).known == {}


def test_an_impossible_cache_folder_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be made"):
        search(tmp_path / "file" / "runs" / "s.jsonl", Limited(1000))


def test_candidates_cost_the_same_together_and_alone():
    tuner = tune.Tuner(PLATES.simulation(), None, episodes=3)
    rng = np.random.default_rng(0)
    for name, rule in RULES.items():
        if name in ("constant_per_kind", "look_ahead"):
            continue
        entries = vector_size(rule, PLATES.simulation().task)
        candidates = [tuner._made(name, rng.standard_normal(entries)) for _ in range(3)]
        costs = tuner.costs(candidates)
        assert costs == [tuner.cost(policy) for policy in candidates], name
        assert len(set(costs)) > 1, name


@pytest.mark.parametrize(("jobs", "ray", "here"), few([(2, None, True), (2, "local", True), (2, None, False)]))
def test_tuned_parameters_do_not_depend_on_the_workers(jobs, ray, here, tmp_path, monkeypatch):
    names, settings = ["power_threshold"], {"evaluations": 12, "starts": 2, "episodes": 1}
    places = {"folder": tmp_path / "b", "runs": tmp_path / "b"}
    alone = tune.tune(ORACLE, names, folder=tmp_path / "a", runs=tmp_path / "a", **settings)
    # the discarded cache is of other episodes
    assert tune.tune(ORACLE, names, **places, **{**settings, "episodes": 2}) != alone
    costs, others = tune.Tuner.costs, []

    def run_by_others(*given):
        others.append(given)
        monkeypatch.setattr(tune.Tuner, "costs", costs)
        found = run_here(*given) if here else run_all(*given)
        # the workers do all evaluations of the run
        monkeypatch.setattr(tune.Tuner, "costs", None)
        return found

    monkeypatch.setattr(tune, "run_all", run_by_others)
    assert tune.tune(ORACLE, names, **places, **settings, fresh=True, jobs=jobs, ray=ray) == alone
    assert len(others) == 1
    # their costs are in the cache
    assert tune.tune(ORACLE, names, folder=tmp_path / "c", runs=tmp_path / "b", **settings) == alone


def test_the_validation_cost_chooses_between_starts(tmp_path, monkeypatch):
    asked = []
    cost = tune.Tuner.cost

    def spied(self, policy, seeds="training"):
        asked.append((repr(policy), seeds))
        return cost(self, policy, seeds)

    monkeypatch.setattr(tune.Tuner, "cost", spied)
    settings = {"evaluations": 10, "starts": 3, "episodes": 1}
    found = tune.tune(ORACLE, ["power_threshold"], folder=tmp_path, runs=tmp_path, **settings)
    # one candidate for each start, and the chosen one again for the file
    assert [seeds for _, seeds in asked].count("validation") == 4
    candidates = [policy for policy, seeds in asked if seeds == "validation"]
    assert candidates[3] in candidates[:3]
    assert found["power_threshold"].training_seeds == [0, 1]
    assert found["power_threshold"].validation_seeds == [500000, 1]


@pytest.mark.parametrize("text", [b"[constant", b"[constant]\nnonsense = 1\n", b"# 5 \xb5m"])
def test_a_damaged_file_is_replaced_on_request_only(text, tmp_path):
    path, text = tmp_path / "oracle6.toml", HEADING.encode() + b"oracle6\n" + text
    path.write_bytes(text)
    places = {"folder": tmp_path, "runs": tmp_path, "episodes": 1}
    with pytest.raises(ConfigError, match=r"oracle6\.toml is damaged .*: tune again with --fresh"):
        tune.tune(ORACLE, ["constant"], **places)
    assert path.read_bytes() == text
    tuned = tune.tune(ORACLE, ["constant", "interval"], fresh=True, **places)
    assert read_tuned("oracle6", tmp_path) == tuned
    assert list(tuned) == ["constant", "interval"]


def test_parameters_with_another_training_cost_are_tuned_again(tmp_path, monkeypatch):
    places = {"folder": tmp_path, "runs": tmp_path / "runs", "episodes": 4, "evaluations": 8, "starts": 1}
    first = tune.tune(ORACLE, ["constant", "interval"], **places)
    stale = dataclasses.replace(first["constant"], training_cost=first["constant"].training_cost + 0.5)
    write_tuned("oracle6", {"constant": stale, "interval": first["interval"]}, tmp_path)
    tuned, plain = [], tune.tune_policy
    monkeypatch.setattr(tune, "tune_policy", lambda name, *rest: (tuned.append(name), plain(name, *rest))[1])
    assert tune.tune(ORACLE, ["constant", "interval"], **places) == first
    assert tuned == ["constant"]


def test_grid_search_finds_the_minimum_and_counts_evaluations():
    found = grid_search(lambda points: [(x - 2) ** 2 + y for x, y in points], itertools.product(range(20), (3, 1)))
    assert found == ((2, 1), 1, 40)
    # the first of equal points is taken
    assert grid_search(lambda points: [0.0] * len(points), iter(range(40))).point == 0


def test_refine_finds_a_minimum_to_one_percent_and_stays_within_its_bounds():
    for least in (7.3, 12.0, 19.1):
        start = BestPoint(10.0, abs(np.log(10.0 / least)), 0)
        found = refine(lambda x, least=least: abs(np.log(x / least)), start, 1.0, 30.0)
        assert found.point == pytest.approx(least, rel=0.01)
    assert 19.0 < refine(lambda x: -x, BestPoint(10.0, -10.0, 0), 1.0, 20.0).point <= 20.0


def test_evolve_finds_a_minimum_within_its_budget_and_repeats_it():
    target = np.array([1.0, -2.0, 0.5])

    def cost(x):
        return float(((x - target) ** 2 * [1.0, 10.0, 100.0]).sum())

    def costs(points):
        return [cost(point) for point in points]

    np.random.seed(1)
    first = evolve(costs, np.zeros(3), 600, seed=3)
    np.random.seed(2)
    again = evolve(costs, np.zeros(3), 600, seed=3)
    assert first.point == pytest.approx(target, abs=1e-3)
    assert first.evaluations <= 610
    assert np.array_equal(first.point, again.point)
    assert first.cost == cost(first.point)
