import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import optuna
import pytest
from sqlalchemy import event
from sqlalchemy.pool import Pool

from agents.tuning import learners as hyperparameters
from agents.tuning.learners import Search, ended, tune_learner
from agents.tuning.search import evolve
from agents.tuning.studies import KeptCosts, open_study, sqlite_url
from grind_env.policies.problem import find_problem
from tests.agents.killing import kill_until_done

ROOT = Path(__file__).parents[2]


def cheap(problem, kind, settings, search):
    """In place of a training; some settings diverge."""
    if settings.hyper["n_epochs"] in (5, 9):
        raise ValueError("no finite number")
    return 100.0 + 1000.0 * abs(settings.hyper["learning_rate"] - 4e-4) + settings.hyper["gae_lambda"]


def tuned(folder):
    """A tuning of a learner by trainings that are stood in for."""
    hyperparameters.validation_cost = cheap
    tune_learner(find_problem("oracle6"), "ppo", Search(trials=7, steps=1000, configs=folder, runs=folder))


def opened(folder):
    """A study without trials."""
    open_study(sqlite_url(folder / "oracle6" / "tune.db"), "s")


def searched(folder):
    """A search as those for scripted policies are."""
    study = open_study(sqlite_url(folder / "oracle6" / "tune.db"), "s")
    evolve(KeptCosts(study, "xyz", lambda points: np.linalg.norm(points, axis=1)), np.zeros(3), 20, seed=3)


def trials(folder):
    """Parameters, values and what else is said of the trials in the only study of a folder."""
    study = optuna.load_study(study_name=None, storage=f"sqlite:///{folder}/oracle6/tune.db")
    return [(trial.params, trial.values, trial.user_attrs) for trial in ended(study)]


def watch(count):
    """Call a function before every statement that a database runs."""
    event.listen(Pool, "connect", lambda connection, _: connection.set_trace_callback(count))


TRIALS = {opened: 0, tuned: 7, searched: 3}
"""Work with a study, and how many trials it leaves there."""


def killed(folder, growth):
    """Kill each work at ever later statements; it ends as one that was not killed. How often each was killed."""
    kills = []
    for work, count in TRIALS.items():
        whole, broken = folder / work.__name__ / "whole", folder / work.__name__ / "killed"
        work(whole)
        kills.append(kill_until_done(partial(work, broken), watch, growth))
        assert len(trials(whole)) == count
        assert trials(broken) == trials(whole)
        files = [path.name for path in whole.rglob("*") if path.is_file()]
        assert [path.name for path in broken.rglob("*") if path.is_file()] == files
        for name in {"oracle6.toml"} & set(files):
            assert (broken / name).read_text() == (whole / name).read_text()
    return kills


def test_a_tuning_killed_at_some_steps_ends_as_one_that_was_not(tmp_path):
    # at many more of them: tests/soak/kills.py
    script = (
        "import sys; from pathlib import Path\n"
        "from tests.agents.test_tune_killed import killed\n"
        "print(*killed(Path(sys.argv[1]), 1.0))\n"
    )
    command = [sys.executable, "-c", script, tmp_path]
    run = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    assert min(map(int, run.stdout.split())) > 4


class Killed(BaseException):
    """Stands for a kill in the middle of a training."""


def test_a_tuning_killed_in_every_training_tries_what_it_would_have_tried(tmp_path, monkeypatch):
    tried = {"whole": [], "killed": []}

    def tune(name, killed):
        def cost(problem, kind, settings, search):
            if killed and (not tried[name] or settings != tried[name][-1]):
                tried[name].append(settings)
                raise Killed
            tried[name].append(settings)
            return cheap(problem, kind, settings, search)

        monkeypatch.setattr(hyperparameters, "validation_cost", cost)
        folder = tmp_path / name
        return tune_learner(find_problem("oracle6"), "ppo", Search(trials=7, steps=1000, configs=folder, runs=folder))

    whole = tune("whole", killed=False)
    for _ in range(7):
        with pytest.raises(Killed):
            tune("killed", killed=True)
    assert tune("killed", killed=True) == whole
    # each was killed once and run again
    assert tried["killed"] == [settings for settings in tried["whole"] for _ in range(2)]
