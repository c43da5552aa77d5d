import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import optuna
import pytest
from sqlalchemy import event
from sqlalchemy.pool import Pool

from agents.tuning.search import evolve
from agents.tuning.studies import KeptCosts, open_study, sqlite_url
from tests.agents.killing import kill_until_done

ROOT = Path(__file__).parents[2]


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
    return [(trial.params, trial.values, trial.user_attrs) for trial in study.get_trials()]


def watch(count):
    """Call a function before every statement that a database runs."""
    event.listen(Pool, "connect", lambda connection, _: connection.set_trace_callback(count))


TRIALS = {opened: 0, searched: 3}
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
    return kills


@pytest.mark.nightly
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
