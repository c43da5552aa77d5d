import dataclasses

import numpy as np
import optuna
import pytest
import typer
from typer.testing import CliRunner

from agents.commands import tune as command
from agents.learning.checkpoint import CheckpointError
from agents.learning.settings import DEFAULTS, settings_for
from agents.tuning import learners as hyperparameters
from agents.tuning import rules as tune
from agents.tuning.coefficients import RULES, entry_names
from agents.tuning.learners import Search, tune_learner, write_settings
from agents.tuning.search import evolve, grid_search
from agents.tuning.studies import KeptCosts, open_study, sqlite_url
from grind_env.errors import GrindError
from grind_env.policies.problem import find_problem
from grind_env.policies.tuned import HEADING, ConfigError, read_tuned, write_tuned

PLATES, ORACLE = find_problem("power_limited"), find_problem("oracle6")


class Killed(Exception):
    """Stands for a kill between two evaluations."""


class Limited:
    """A cost function that is killed after some evaluations."""

    def __init__(self, left):
        self.left, self.asked = left, 0

    def __call__(self, points):
        return [self.of(point) for point in points]

    def of(self, point):
        if self.asked == self.left:
            raise Killed
        self.asked += 1
        return float(((np.asarray(point) - [1.0, -2.0, 0.5]) ** 2 * [1.0, 10.0, 100.0]).sum())


def search(url, costs, evaluations=60):
    return evolve(KeptCosts(open_study(url, "s"), "xyz", costs), np.zeros(3), evaluations, seed=3)


def kept_costs(url):
    """All costs that a study holds."""
    return [cost for trial in open_study(url, "s").get_trials() for cost in trial.user_attrs["costs"]]


@pytest.mark.parametrize("killed", [5, 7, 33])
def test_a_search_that_was_killed_goes_on_and_ends_as_if_nothing_had_happened(tmp_path, killed):
    whole = evolve(Limited(1000), np.zeros(3), 60, seed=3)
    url = sqlite_url(tmp_path / "trials" / "tune.db")
    with pytest.raises(Killed):
        search(url, Limited(killed))
    rest = Limited(1000)
    found = search(url, rest)
    assert np.array_equal(found.point, whole.point)
    assert found.cost == whole.cost
    # a generation in three dimensions has seven points, and is kept whole
    assert rest.asked == whole.evaluations - killed // 7 * 7
    trials = open_study(url, "s").get_trials()
    assert {trial.state for trial in trials} == {optuna.trial.TrialState.COMPLETE}
    assert min(trial.value for trial in trials) == min(kept_costs(url)) == whole.cost
    assert len(kept_costs(url)) == whole.evaluations


def test_a_finished_search_takes_a_larger_budget_up(tmp_path):
    url = sqlite_url(tmp_path / "tune.db")
    first = search(url, Limited(1000), 30)
    more = Limited(1000)
    assert search(url, more, 60).cost < first.cost
    assert more.asked == len(kept_costs(url)) - first.evaluations


def test_the_trials_of_another_search_are_refused_and_can_be_thrown_away(tmp_path):
    url = sqlite_url(tmp_path / "tune.db")
    search(url, Limited(1000))
    other = KeptCosts(open_study(url, "s"), "xyz", Limited(1000))
    with pytest.raises(ConfigError, match="the study s is of another search: tune again with --fresh"):
        grid_search(other, iter([(9.0, 9.0, 9.0)]))
    fresh = KeptCosts(open_study(url, "s", fresh=True), "xyz", Limited(1000))
    assert grid_search(fresh, iter([(9.0, 9.0, 9.0)])).evaluations == 1


@pytest.mark.parametrize("url", ["nonsense", "sqlite:////no/such/folder/tune.db", "other://host/db"])
def test_a_storage_that_cannot_be_opened_is_one_sentence(url):
    with pytest.raises(ConfigError, match="cannot be opened") as error:
        open_study(url, "s")
    assert "\n" not in str(error.value)


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be made"):
        sqlite_url(tmp_path / "file" / "runs" / "tune.db")


def test_a_tuning_that_was_killed_goes_on_and_ends_in_the_same_file(tmp_path, monkeypatch):
    names = ["constant", "constant_per_kind"]
    settings = {"evaluations": 10, "starts": 2, "episodes": 1}
    tune.tune(ORACLE, names, folder=tmp_path / "a", runs=tmp_path / "a", **settings)
    asked = []
    costs = tune.Tuner.costs

    def killed_once(self, policies):
        # all plans are one batch, then every generation
        if len(asked) == 3:
            asked.append(0)
            raise Killed
        asked.append(len(policies))
        return costs(self, policies)

    monkeypatch.setattr(tune.Tuner, "costs", killed_once)
    again = {"folder": tmp_path / "b", "runs": tmp_path / "b", **settings}
    with pytest.raises(Killed):
        tune.tune(ORACLE, names, **again)
    assert list(read_tuned("oracle6", tmp_path / "b")) == ["constant"]
    tune.tune(ORACLE, names, **again)
    files = [(tmp_path / each / "oracle6.toml").read_text(encoding="utf-8") for each in "ab"]
    assert files[0] == files[1]
    # nothing that was kept is evaluated again
    assert sum(asked) == sum(entry.evaluations for entry in read_tuned("oracle6", tmp_path / "b").values())


def test_candidates_side_by_side_cost_what_they_cost_alone(tmp_path):
    tuner = tune.Tuner(PLATES.simulation(), sqlite_url(tmp_path / "tune.db"), episodes=3)
    rng = np.random.default_rng(0)
    for name, rule in RULES.items():
        if name in ("constant_per_kind", "look_ahead"):
            continue
        entries = len(entry_names(rule, PLATES.simulation().task))
        candidates = [tuner._made(name, rng.standard_normal(entries)) for _ in range(3)]
        costs = tuner.costs(candidates)
        assert costs == [tuner.cost(policy) for policy in candidates], name
        assert len(set(costs)) > 1, name


def test_what_is_found_does_not_depend_on_the_number_of_processes(tmp_path, monkeypatch):
    names = ["power_threshold", "adaptive_dress"]
    settings = {"evaluations": 12, "starts": 2, "episodes": 1}
    places = {"folder": tmp_path / "b", "runs": tmp_path / "b"}
    alone = tune.tune(ORACLE, names, folder=tmp_path / "a", runs=tmp_path / "a", **settings)
    # what is thrown away is of other episodes
    assert tune.tune(ORACLE, names, **places, **{**settings, "episodes": 2}) != alone
    # all evaluations of the run are done by others
    monkeypatch.setattr(tune.Tuner, "costs", None)
    assert tune.tune(ORACLE, names, **places, **settings, fresh=True, jobs=2) == alone


def test_validation_decides_between_starts(tmp_path, monkeypatch):
    asked = []
    cost = tune.Tuner.cost

    def spied(self, policy, seeds="training"):
        asked.append((repr(policy), seeds))
        return cost(self, policy, seeds)

    monkeypatch.setattr(tune.Tuner, "cost", spied)
    settings = {"evaluations": 10, "starts": 3, "episodes": 1}
    found = tune.tune(ORACLE, ["power_threshold"], folder=tmp_path, runs=tmp_path, **settings)
    # one candidate a start, and the chosen one again for the file
    assert [seeds for _, seeds in asked].count("validation") == 4
    candidates = [policy for policy, seeds in asked if seeds == "validation"]
    assert candidates[3] in candidates[:3]
    assert found["power_threshold"].training_seeds == [0, 1]
    assert found["power_threshold"].validation_seeds == [500000, 1]


def stand_in(costs, killed=None):
    """In place of a training: the cost falls with the learning rate; `costs` collects the settings."""

    def cost(problem, kind, settings, search):
        if len(costs) == killed:
            raise Killed
        costs.append(settings)
        return 100.0 + 1000.0 * abs(settings.hyper["learning_rate"] - 4e-4)

    return cost


def test_settings_of_a_learner_are_tuned_kept_and_read(tmp_path, monkeypatch):
    tried = []
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(tried))
    search = Search(trials=8, steps=1000, configs=tmp_path, runs=tmp_path)
    settings, cost = tune_learner(PLATES, "ppo", search)
    assert len(tried) == 8
    # the defaults come first, but for the length of the training
    assert (tried[0].hyper, tried[0].hidden, tried[0].steps) == (DEFAULTS["ppo"].hyper, DEFAULTS["ppo"].hidden, 1000)
    assert cost == min(100.0 + 1000.0 * abs(each.hyper["learning_rate"] - 4e-4) for each in tried) < 100.6
    found = settings_for("ppo", PLATES.name, tmp_path)
    assert (found.hyper, found.hidden) == (settings.hyper, settings.hidden)
    assert found.steps == DEFAULTS["ppo"].steps
    assert settings_for("sac", PLATES.name, tmp_path) == DEFAULTS["sac"]
    tune_learner(PLATES, "ppo", search)
    assert len(tried) == 8


def test_a_trial_that_was_killed_is_run_again(tmp_path, monkeypatch):
    whole, tried, rest = [], [], []
    search = Search(trials=6, steps=1000, configs=tmp_path, runs=tmp_path / "a")
    other = Search(trials=6, steps=1000, configs=tmp_path, runs=tmp_path / "b")
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(whole))
    tune_learner(PLATES, "sac", other)
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(tried, killed=3))
    with pytest.raises(Killed):
        tune_learner(PLATES, "sac", search)
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(rest))
    tune_learner(PLATES, "sac", search)
    assert len(tried) + len(rest) == 6
    # the trial in work has the settings that it had before it was killed
    assert rest[0] == whole[3]


def diverging(costs, numbers, failure):
    """As `stand_in`, but the trainings of these numbers fail."""
    cost = stand_in(costs)

    def failing(problem, kind, settings, search):
        found = cost(problem, kind, settings, search)
        if len(costs) - 1 in numbers:
            raise failure
        return found

    return failing


NAN = ValueError("Expected parameter logits to satisfy the constraint\nbut found invalid values: nan")


@pytest.mark.parametrize("failure", [NAN, RuntimeError("svd"), FloatingPointError(), GrindError("no finite number")])
def test_a_training_that_diverges_is_one_trial_less(failure, tmp_path, monkeypatch):
    tried, told = [], []
    search = Search(trials=6, steps=1000, configs=tmp_path, runs=tmp_path)
    monkeypatch.setattr(hyperparameters, "validation_cost", diverging(tried, {0, 2, 5}, failure))
    settings, cost = tune_learner(PLATES, "ppo", search, lambda done, cost: told.append(cost))
    # each was tried once, none of the failed ones again
    assert len(tried) == len({repr(each) for each in tried}) == 6
    assert [np.isinf(each) for each in told] == [True, False, True, False, False, True]
    assert cost == min(told)
    assert settings == tried[told.index(cost)]
    tune_learner(PLATES, "ppo", search)
    assert len(tried) == 6


def test_when_every_training_diverges_it_is_said(tmp_path, monkeypatch):
    tried = []
    search = Search(trials=3, steps=1000, configs=tmp_path, runs=tmp_path)
    monkeypatch.setattr(hyperparameters, "validation_cost", diverging(tried, range(9), NAN))
    for _ in range(2):
        with pytest.raises(
            ConfigError, match=r"all 3 trainings of ppo on power_limited failed \(ValueError: "
        ) as caught:
            tune_learner(PLATES, "ppo", search)
        assert "\n" not in str(caught.value)
    assert len(tried) == 3
    assert not (tmp_path / "power_limited.toml").exists()


@pytest.mark.parametrize("failure", [CheckpointError("no room"), OSError("no room"), KeyboardInterrupt()])
def test_what_is_no_fault_of_the_settings_stops_the_tuning_and_is_tried_again(failure, tmp_path, monkeypatch):
    tried, again = [], []
    search = Search(trials=3, steps=1000, configs=tmp_path, runs=tmp_path)
    monkeypatch.setattr(hyperparameters, "validation_cost", diverging(tried, {1}, failure))
    with pytest.raises(type(failure)):
        tune_learner(PLATES, "ppo", search)
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(again))
    tune_learner(PLATES, "ppo", search)
    assert again[0] == tried[1]
    assert len(again) == 2


def test_a_clone_is_tuned_as_one_whose_every_step_is_labelled(tmp_path, monkeypatch):
    path = tmp_path / "power_limited.toml"
    path.write_text("[bc]\nsteps = 60000\n[bc.hyper]\nlabels = 60000\n", encoding="utf-8")
    for kind, labels in (("bc", 1000), ("bc_ppo", DEFAULTS["bc_ppo"].hyper["labels"])):
        tried = []
        monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(tried))
        tune_learner(PLATES, kind, Search(trials=3, steps=1000, configs=tmp_path, runs=tmp_path))
        assert {(each.steps, each.hyper["labels"]) for each in tried} == {(1000, labels)}
    # those of a whole training stay
    found = settings_for("bc", PLATES.name, tmp_path)
    assert (found.steps, found.hyper["labels"]) == (60000, 60000)
    assert settings_for("bc_ppo", PLATES.name, tmp_path).hyper["labels"] == DEFAULTS["bc_ppo"].hyper["labels"]


def test_what_was_set_by_hand_stays_and_what_was_tuned_before_goes(tmp_path):
    path, default = tmp_path / "power_limited.toml", DEFAULTS["bc"]
    path.write_text("[bc.hyper]\nlabels = 60000\nhorizon = 5\ngamma = 0.5\nn_epochs = 2\n", encoding="utf-8")
    write_settings(path, "bc", dataclasses.replace(default, hyper={**default.hyper, "n_epochs": 9}), default)
    hyper = settings_for("bc", PLATES.name, tmp_path).hyper
    assert hyper == {**default.hyper, "labels": 60000, "horizon": 5, "n_epochs": 9}


def test_the_best_settings_may_be_the_defaults(tmp_path, monkeypatch):
    monkeypatch.setattr(hyperparameters, "validation_cost", lambda problem, kind, settings, search: 1.0)
    tune_learner(PLATES, "dqn", Search(trials=3, steps=10, configs=tmp_path, runs=tmp_path))
    assert settings_for("dqn", PLATES.name, tmp_path) == DEFAULTS["dqn"]


def test_what_a_settings_file_says_of_other_kinds_stays(tmp_path):
    path = tmp_path / "power_limited.toml"
    path.write_text("[ppo]\nsteps = 5\nhidden = [8]\n[sac]\nenvs = 3\n[sac.hyper]\ngamma = 0.5\n", encoding="utf-8")
    default = DEFAULTS["ppo"]
    write_settings(path, "ppo", dataclasses.replace(default, hyper={**default.hyper, "gamma": 0.9}), default)
    ppo, sac = (settings_for(kind, PLATES.name, tmp_path) for kind in ("ppo", "sac"))
    assert (ppo.steps, ppo.hidden, ppo.hyper["gamma"]) == (5, default.hidden, 0.9)
    assert (sac.envs, sac.hyper["gamma"]) == (3, 0.5)


@pytest.mark.parametrize("text", [b"[ppo", b"# 5 \xb5m"])
def test_a_damaged_settings_file_is_an_error_before_any_training(text, tmp_path, monkeypatch):
    tried, path = [], tmp_path / "power_limited.toml"
    path.write_bytes(text)
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in(tried))
    with pytest.raises(ConfigError, match=r"power_limited\.toml is damaged .*: mend or delete it"):
        tune_learner(PLATES, "ppo", Search(trials=2, steps=10, configs=tmp_path, runs=tmp_path, fresh=True))
    assert tried == []
    assert path.read_bytes() == text


def test_a_kind_that_is_not_there_cannot_be_tuned(tmp_path):
    with pytest.raises(ConfigError, match="no kind of agent 'nonsense'"):
        tune_learner(PLATES, "nonsense", Search(configs=tmp_path, runs=tmp_path))


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


def test_the_command(tmp_path, monkeypatch):
    app = typer.Typer()
    command.register(app)
    places = ["--task", "oracle6", "--configs", str(tmp_path), "--runs", str(tmp_path)]
    result = CliRunner().invoke(
        app, [*places, "--policies", "power_threshold", "--evaluations", "4", "--starts", "1", "--episodes", "1"]
    )
    assert result.exit_code == 0, result.output
    assert "power_threshold: " in result.output
    assert list(read_tuned("oracle6", tmp_path)) == ["power_threshold"]
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in([]))
    result = CliRunner().invoke(app, [*places, "--kind", "ppo", "--trials", "2"])
    assert result.exit_code == 0, result.output
    assert "in validation with" in result.output
    assert (tmp_path / "learning" / "oracle6.toml").exists()


def test_parameters_of_another_task_are_tuned_anew(tmp_path, monkeypatch):
    places = {"folder": tmp_path, "runs": tmp_path / "runs", "episodes": 4, "evaluations": 8, "starts": 1}
    first = tune.tune(ORACLE, ["constant", "interval"], **places)
    stale = dataclasses.replace(first["constant"], training_cost=first["constant"].training_cost + 0.5)
    write_tuned("oracle6", {"constant": stale, "interval": first["interval"]}, tmp_path)
    tuned, plain = [], tune.tune_policy
    monkeypatch.setattr(tune, "tune_policy", lambda name, *rest: (tuned.append(name), plain(name, *rest))[1])
    assert tune.tune(ORACLE, ["constant", "interval"], **places) == first
    assert tuned == ["constant"]
