"""Optuna studies: every trial of a search in a database, so that a search that was killed goes on where it was."""

import sqlite3
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import optuna
import sqlalchemy
from optuna.trial import TrialState, create_trial
from sqlalchemy.exc import SQLAlchemyError

from agents.tuning.search import Costs
from grind_env.errors import reason
from grind_env.policies.tuned import ConfigError

optuna.logging.set_verbosity(optuna.logging.WARNING)

BUSY_SECONDS = 60
"""How long to wait for an SQLite file that another process writes to."""
ENTRIES, POINTS, COSTS = "entries", "points", "costs"
"""Attributes of a trial of a search: names of the entries of a point, the points, and what they cost."""


def sqlite_url(path: Path) -> str:
    """URL of an SQLite file, whose folder is made."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"the folder {path.parent} cannot be made: {error.strerror}") from None
    return f"sqlite:///{path}"


def open_study(url: str, name: str, *, fresh: bool = False) -> optuna.Study:
    """Open the study of that name, made if it is not there; `fresh` throws away what it holds."""
    try:
        waiting = {"connect_args": {"timeout": BUSY_SECONDS}}
        _make_tables(sqlalchemy.create_engine(url, **waiting))
        storage = optuna.storages.RDBStorage(url, engine_kwargs=waiting)
        if fresh and name in optuna.get_all_study_names(storage):
            optuna.delete_study(study_name=name, storage=storage)
        return optuna.create_study(storage=storage, study_name=name, load_if_exists=True)
    except (SQLAlchemyError, sqlite3.Error, optuna.exceptions.StorageInternalError) as error:
        raise ConfigError(
            f"{url} cannot be opened ({reason(error)}): delete it, or name another folder with --runs"
        ) from None


def _make_tables(engine: sqlalchemy.Engine) -> None:
    """Make the tables of Optuna in an SQLite file that has none, all or nothing.

    Optuna makes them one by one. Killed in between, it leaves a file that it can never open again.
    """
    model = optuna.storages.RDBStorage("sqlite://").engine
    with closing(engine.raw_connection()) as here, closing(model.raw_connection()) as there:
        file: Any = here.driver_connection
        tables: Any = there.driver_connection
        # no transaction but the one below
        file.isolation_level = None
        file.execute("BEGIN IMMEDIATE")
        if file.execute("SELECT name FROM sqlite_master").fetchone() is None:
            _, *statements, _ = tables.iterdump()
            for statement in statements:
                file.execute(statement)
        file.execute("COMMIT")
    engine.dispose()


class KeptCosts:
    """Costs that are kept in a study, in the order in which a search asks for them.

    A search that repeats itself asks for the kept points first and gets their costs without a new evaluation. What is
    asked for together is one trial: a transaction for each entry would take longer than most evaluations.
    """

    def __init__(
        self, study: optuna.Study, names: Sequence[str], costs: Costs, advance: Callable[[int], object] = lambda n: None
    ) -> None:
        self.study, self.names, self.costs, self.advance = study, list(names), costs, advance
        trials = study.get_trials(deepcopy=False, states=[TrialState.COMPLETE])
        self.kept = [pair for trial in trials for pair in zip(*map(trial.user_attrs.get, (POINTS, COSTS)), strict=True)]
        self.asked = 0

    def __call__(self, points: Sequence[Any]) -> list[float]:
        """Return the costs at points, each shape (entries,); refuse a study that holds another point here."""
        wanted = [[float(value) for value in point] for point in points]
        kept = self.kept[self.asked : self.asked + len(wanted)]
        if any(point != known for point, (known, _) in zip(wanted, kept, strict=False)):
            raise ConfigError(f"the study {self.study.study_name} is of another search: tune again with --fresh")
        values = [float(cost) for _, cost in kept]
        if new := wanted[len(kept) :]:
            found = [float(cost) for cost in self.costs(points[len(kept) :])]
            about = {ENTRIES: self.names, POINTS: new, COSTS: found}
            self.study.add_trial(create_trial(value=min(found), user_attrs=about))
            values += found
        self.asked += len(wanted)
        self.advance(len(wanted))
        return values
