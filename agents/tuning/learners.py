"""Tunes the settings of a kind of learned agent for a task: short trainings, judged on the validation episodes."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import optuna
from optuna.samplers import TPESampler
from optuna.trial import TrialState

from agents.budgets import TRIAL_STEPS, TRIALS
from agents.cells import RUNS
from agents.learning.checkpoint import CheckpointError
from agents.learning.settings import CONFIGS, DEFAULTS, Number, Settings
from agents.learning.train import fingerprint, train
from agents.tuning.studies import open_study, sqlite_url
from grind_env.errors import did_you_mean, quoted, reason
from grind_env.files import ReadError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import ConfigError, write_whole
from grind_env.toml import TomlError, read_toml

EPISODES = 64
"""Validation episodes that judge a training."""
RANDOM_TRIALS = 4
"""Trials before the sampler learns from them."""

DEFAULT = "default"
"""Marks the trial that has the default settings."""
FAILURE = "failure"
"""Says why the training of a trial ended without an agent; a trial that was killed has none."""

WIDTHS = {"small": (64, 64), "middle": (128, 128), "large": (256, 256)}
ROLLOUT_SHARES = (2, 4, 8)
"""Batches that a rollout of all environments is divided into."""

Propose = Callable[[optuna.Trial, Settings], Number]

SPACE: Mapping[str, Propose] = {
    "learning_rate": lambda trial, _: trial.suggest_float("learning_rate", 2e-4, 3e-3, log=True),
    "gamma": lambda trial, _: 1.0 - trial.suggest_float("1 - gamma", 0.005, 0.1, log=True),
    "gae_lambda": lambda trial, _: trial.suggest_float("gae_lambda", 0.8, 0.98),
    "ent_coef": lambda trial, _: trial.suggest_float("ent_coef", 3e-4, 2e-2, log=True),
    "n_epochs": lambda trial, _: trial.suggest_int("n_epochs", 3, 10),
    "gradient_steps": lambda trial, _: trial.suggest_int("gradient_steps", 4, 16),
}
"""What is tuned of the arguments of an algorithm, where it has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How long and where to search; `storage` is the URL of a database, by default an SQLite file below `runs`."""

    trials: int = TRIALS
    steps: int = TRIAL_STEPS
    seed: int = 0
    storage: str | None = None
    configs: Path = CONFIGS
    runs: Path = RUNS
    fresh: bool = False


def tune_learner(
    problem: Problem, kind: str, search: Search, report: Callable[[int, float], object] = lambda number, cost: None
) -> tuple[Settings, float]:
    """The settings of the cheapest trial and its validation cost, $ an episode; they are stored for `settings_for`.

    The first trial has the defaults, so that the outcome is no worse than they are. A trial that was killed is run
    again, and its training goes on from its checkpoint; one that failed, as a training that diverges does, is not, but
    counts. One process at a time can work on a study.

    Args:
        problem: what is ground.
        kind: of the agent.
        search: how long and where.
        report: called with the number of trials done and the cost of the last one, infinite if it failed.

    Raises:
        ConfigError: if there is no such kind, the file of the settings is damaged, or every trial failed.
        CheckpointError: if a checkpoint is damaged or cannot be written, which is no fault of the settings.
    """
    if kind not in DEFAULTS:
        raise ConfigError(
            f"there is no kind of agent {quoted(kind)}{did_you_mean(kind, DEFAULTS)}: choose from {', '.join(DEFAULTS)}"
        )
    path = search.configs / f"{problem.name}.toml"
    # what is found goes there: better to learn now than after hours of training that it cannot
    _tables(path)
    default = shortened(DEFAULTS[kind], search.steps)
    url = sqlite_url(search.runs / problem.name / "tune.db") if search.storage is None else search.storage
    # trials of other code, or of another length, are of another study
    name = f"{problem.name}/{kind}/{fingerprint(problem, kind, default, search.seed)}"
    study = open_study(url, name, fresh=search.fresh)
    for killed in study.get_trials(states=[TrialState.RUNNING]):
        study.tell(killed.number, state=TrialState.FAIL)
    while (done := len(ended(study))) < search.trials:
        # the same ended trials have the same next one, in whatever process and however many were killed
        study.sampler = TPESampler(seed=search.seed + done, n_startup_trials=RANDOM_TRIALS)
        trial = study.ask()
        if done == 0:
            trial.set_user_attr(DEFAULT, True)
        settings = default if done == 0 else proposed(trial, default)
        try:
            cost = validation_cost(problem, kind, settings, search)
        except CheckpointError:
            raise
        # weights that are no numbers show as any of these
        except (ArithmeticError, ValueError, RuntimeError) as error:
            cost = math.inf
            trial.set_user_attr(FAILURE, f"{type(error).__name__}: {reason(error)}")
            study.tell(trial, state=TrialState.FAIL)
        else:
            study.tell(trial, cost)
        report(done + 1, cost)
    if not study.get_trials(states=[TrialState.COMPLETE]):
        failure = ended(study)[-1].user_attrs[FAILURE]
        raise ConfigError(
            f"all {done} trainings of {kind} on {problem.name} failed ({failure}): mend it, and add --fresh"
        )
    best = study.best_trial
    settings = default if DEFAULT in best.user_attrs else proposed(optuna.trial.FixedTrial(best.params), default)
    write_settings(path, kind, settings, DEFAULTS[kind])
    return settings, study.best_value


def shortened(default: Settings, steps: int) -> Settings:
    """The settings for trainings of that many steps; where all steps of the default are labelled, these are too."""
    cloned = default.hyper.get("labels") == default.steps
    return replace(default, steps=steps, hyper={**default.hyper, **({"labels": steps} if cloned else {})})


def ended(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    """The trials that have a cost or have failed, in order; not those that were killed."""
    trials = study.get_trials(states=[TrialState.COMPLETE, TrialState.FAIL])
    return [trial for trial in trials if trial.state == TrialState.COMPLETE or FAILURE in trial.user_attrs]


def tuned_names(default: Settings) -> set[str]:
    """The arguments of the algorithm that `proposed` chooses."""
    return {name for name in SPACE if name in default.hyper} | ({"batch_size"} if "n_steps" in default.hyper else set())


def proposed(trial: Any, default: Settings) -> Settings:
    """The settings that a trial proposes: those in `SPACE`, the width of the layers and the size of a batch."""
    hyper = {name: propose(trial, default) for name, propose in SPACE.items() if name in default.hyper}
    if "n_steps" in default.hyper:
        share = trial.suggest_categorical("batches", ROLLOUT_SHARES)
        hyper["batch_size"] = int(default.hyper["n_steps"]) * default.envs // share
    width = trial.suggest_categorical("hidden", list(WIDTHS)) if len(default.hidden) > 1 else None
    hidden = default.hidden if width is None else WIDTHS[width]
    return replace(default, hidden=hidden, hyper={**default.hyper, **hyper})


def validation_cost(problem: Problem, kind: str, settings: Settings, search: Search) -> float:
    """Mean cost of a validation episode, $, after a training with the settings."""
    path = train(problem, kind, search.seed, settings, search.runs, quiet=True)
    simulation, seeds = problem.simulation(), episode_seeds("validation", EPISODES)
    return float(run_seeds(load_policy(path, simulation=simulation), simulation, seeds).cost.mean())


def write_settings(path: Path, kind: str, settings: Settings, default: Settings) -> None:
    """Write what was tuned and differs from the defaults as the tables `[kind]` and `[kind.hyper]` of a file.

    What the file says beside it stays: other kinds, the steps of a whole training, arguments that are not tuned.

    Raises:
        ConfigError: if the file is damaged.
    """
    tables = _tables(path)
    changes: dict[str, Any] = {} if settings.hidden == default.hidden else {"hidden": list(settings.hidden)}
    old, names = tables.get(kind, {}), tuned_names(default)
    before = {name: value for name, value in old.items() if name not in ("hidden", "hyper")}
    # what an earlier tuning found goes, even where the default is best now
    hyper = {name: value for name, value in old.get("hyper", {}).items() if name not in names}
    hyper |= {name: settings.hyper[name] for name in sorted(names) if settings.hyper[name] != default.hyper[name]}
    tables[kind] = before | changes | ({"hyper": hyper} if hyper else {})
    lines = [f"# Settings of learned agents for {path.stem}, tuned by `python -m agents tune --kind`."]
    for name, table in sorted(tables.items()):
        lines += ["", f"[{name}]", *(f"{key} = {value!r}" for key, value in table.items() if key != "hyper")]
        if "hyper" in table:
            lines += [f"[{name}.hyper]", *(f"{key} = {value!r}" for key, value in table["hyper"].items())]
    write_whole(path, "\n".join(lines) + "\n")


def _tables(path: Path) -> dict[str, Any]:
    """What a file of settings says; nothing if it is not there."""
    try:
        tables = read_toml(path) if path.exists() else {}
    except (ReadError, TomlError) as error:
        raise ConfigError(f"{path} is damaged ({reason(error)}): mend or delete it") from None
    if other := next((name for name in tables if name not in DEFAULTS), None):
        raise ConfigError(
            f"{path} has {quoted(other)}, which is no kind of agent, and is not written over: name another --configs"
        )
    return tables
