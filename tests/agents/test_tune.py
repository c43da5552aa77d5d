import dataclasses

import numpy as np
import optuna
import pytest
import typer
from typer.testing import CliRunner

from agents import hyperparameters, tune
from agents.commands import tune as command
from agents.hyperparameters import Search, tune_learner, write_settings
from agents.learning.settings import DEFAULTS, settings_for
from agents.search import evolve, grid_search
from agents.studies import KeptCosts, open_study, sqlite_url
from agents.tuned import ConfigError, read_tuned
from grind_env.envs.tasks import load_task

PLATES, ORACLE = load_task("power_limited"), load_task("oracle6")


class Killed(Exception):
    """Stands for a kill between two evaluations."""


class Limited:
    """A cost function that is killed after some evaluations."""

    def __init__(self, left):
        self.left, self.asked = left, 0

    def __call__(self, point):
        if self.asked == self.left:
            raise Killed
        self.asked += 1
        return float(((np.asarray(point) - [1.0, -2.0, 0.5]) ** 2 * [1.0, 10.0, 100.0]).sum())


def search(url, cost, evaluations=60):
    return evolve(KeptCosts(open_study(url, "s"), "xyz", cost), np.zeros(3), evaluations, seed=3)


@pytest.mark.parametrize("killed", [7, 33])
def test_a_search_that_was_killed_goes_on_and_ends_as_if_nothing_had_happened(tmp_path, killed):
    whole = evolve(Limited(1000), np.zeros(3), 60, seed=3)
    url = sqlite_url(tmp_path / "trials" / "tune.db")
    with pytest.raises(Killed):
        search(url, Limited(killed))
    rest = Limited(1000)
    found = search(url, rest)
    assert np.array_equal(found.point, whole.point)
    assert found.cost == whole.cost
    assert rest.asked == whole.evaluations - killed
    trials = open_study(url, "s").get_trials()
    assert [trial.state for trial in trials] == [optuna.trial.TrialState.COMPLETE] * whole.evaluations
    assert min(trial.value for trial in trials) == whole.cost


def test_a_finished_search_takes_a_larger_budget_up(tmp_path):
    url = sqlite_url(tmp_path / "tune.db")
    first = search(url, Limited(1000), 30)
    more = Limited(1000)
    assert search(url, more, 60).cost < first.cost
    assert more.asked == len(open_study(url, "s").trials) - first.evaluations


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
    names = ["constant", "size_threshold"]
    settings = {"evaluations": 10, "starts": 2, "episodes": 1}
    tune.tune("oracle6", names, folder=tmp_path / "a", runs=tmp_path / "a", **settings)
    count = {"roll_out": 0}
    roll_out = tune.roll_out

    def killed_once(*arguments):
        count["roll_out"] += 1
        if count["roll_out"] == 23:
            raise Killed
        return roll_out(*arguments)

    monkeypatch.setattr(tune, "roll_out", killed_once)
    again = {"folder": tmp_path / "b", "runs": tmp_path / "b", **settings}
    with pytest.raises(Killed):
        tune.tune("oracle6", names, **again)
    assert list(read_tuned("oracle6", tmp_path / "b")) == ["constant"]
    done = count["roll_out"] - 1
    tune.tune("oracle6", names, **again)
    files = [(tmp_path / each / "oracle6.toml").read_text(encoding="utf-8") for each in "ab"]
    assert files[0] == files[1]
    # nothing that was kept is evaluated again
    trials = sum(entry.evaluations for entry in read_tuned("oracle6", tmp_path / "b").values())
    beside = 2 * len(names) + settings["starts"]
    assert count["roll_out"] - 1 == trials + beside
    assert done < trials


def test_validation_decides_between_starts(tmp_path, monkeypatch):
    asked = []
    cost = tune.Tuner.cost

    def spied(self, policy, split="training"):
        asked.append((repr(policy), split))
        return cost(self, policy, split)

    monkeypatch.setattr(tune.Tuner, "cost", spied)
    settings = {"evaluations": 10, "starts": 3, "episodes": 1}
    found = tune.tune("oracle6", ["power_threshold"], folder=tmp_path, runs=tmp_path, **settings)
    # one candidate a start, and the chosen one again for the file
    assert [split for _, split in asked].count("validation") == 4
    candidates = [policy for policy, split in asked if split == "validation"]
    assert candidates[3] in candidates[:3]
    assert found["power_threshold"].training_seeds == [0, 1]
    assert found["power_threshold"].validation_seeds == [500000, 1]


def stand_in(costs, killed=None):
    """In place of a training: the cost falls with the learning rate; `costs` collects the settings."""

    def cost(task, kind, settings, search):
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
    found = settings_for("ppo", PLATES, tmp_path)
    assert (found.hyper, found.hidden) == (settings.hyper, settings.hidden)
    assert found.steps == DEFAULTS["ppo"].steps
    assert settings_for("sac", PLATES, tmp_path) == DEFAULTS["sac"]
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


def test_the_best_settings_may_be_the_defaults(tmp_path, monkeypatch):
    monkeypatch.setattr(hyperparameters, "validation_cost", lambda task, kind, settings, search: 1.0)
    tune_learner(PLATES, "dqn", Search(trials=3, steps=10, configs=tmp_path, runs=tmp_path))
    assert settings_for("dqn", PLATES, tmp_path) == DEFAULTS["dqn"]


def test_what_a_settings_file_says_of_other_kinds_stays(tmp_path):
    path = tmp_path / "power_limited.toml"
    path.write_text("[ppo]\nsteps = 5\nhidden = [8]\n[sac]\nenvs = 3\n[sac.hyper]\ngamma = 0.5\n", encoding="utf-8")
    default = DEFAULTS["ppo"]
    write_settings(path, "ppo", dataclasses.replace(default, hyper={**default.hyper, "gamma": 0.9}), default)
    ppo, sac = (settings_for(kind, PLATES, tmp_path) for kind in ("ppo", "sac"))
    assert (ppo.steps, ppo.hidden, ppo.hyper["gamma"]) == (5, default.hidden, 0.9)
    assert (sac.envs, sac.hyper["gamma"]) == (3, 0.5)
    path.write_text("[ppo", encoding="utf-8")
    with pytest.raises(ConfigError, match="is damaged"):
        write_settings(path, "ppo", default, default)


def test_a_kind_that_is_not_there_cannot_be_tuned(tmp_path):
    with pytest.raises(ConfigError, match="no kind of agent 'nonsense'"):
        tune_learner(PLATES, "nonsense", Search(configs=tmp_path, runs=tmp_path))


def test_the_command(tmp_path, monkeypatch):
    app = typer.Typer()
    command.register(app)
    places = ["--task", "oracle6", "--configs", str(tmp_path), "--runs", str(tmp_path)]
    result = CliRunner().invoke(
        app, [*places, "--policies", "burn_line", "--evaluations", "4", "--starts", "1", "--episodes", "1"]
    )
    assert result.exit_code == 0, result.output
    assert "burn_line: " in result.output
    assert list(read_tuned("oracle6", tmp_path)) == ["burn_line"]
    monkeypatch.setattr(hyperparameters, "validation_cost", stand_in([]))
    result = CliRunner().invoke(app, [*places, "--kind", "ppo", "--trials", "2"])
    assert result.exit_code == 0, result.output
    assert "in validation with" in result.output
    assert (tmp_path / "learning" / "oracle6.toml").exists()
