"""Trials of a study in a file, for a node that cannot reach the database."""

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import optuna
from optuna.trial import FrozenTrial, create_trial

from agents.tuning.studies import COSTS
from grind_env.policies.tuned import write_whole


def write_trials(path: Path, study: optuna.Study) -> None:
    """Write the trials that `KeptCosts` has put into a study, unless the file has them all."""
    trials = study.get_trials(deepcopy=False)
    if len(trials) > len(read_trials(path, study.study_name)):
        attributes = [trial.user_attrs for trial in trials]
        write_whole(path, json.dumps({"study": study.study_name, "trials": attributes}))


def read_trials(path: Path, study: str) -> list[FrozenTrial]:
    """The trials in a file; none if it is missing, damaged, or of another study."""
    # a file that is missing or damaged is made anew
    with suppress(OSError, ValueError, KeyError):
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["study"] == study:
            return [create_trial(value=min(each[COSTS]), user_attrs=each) for each in found["trials"]]
    return []


def add_missing(study: optuna.Study, trials: Sequence[FrozenTrial]) -> None:
    """Add what a study has not yet; the same search has the same trials in the same order."""
    study.add_trials(trials[len(study.get_trials(deepcopy=False)) :])
