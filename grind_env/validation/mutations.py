"""Mutation test: the laws of `laws.csv` are changed one at a time, and the rows that then fail are listed."""

import inspect
import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from grind_env.errors import GrindError
from grind_env.process.catalogue import load_catalogue
from grind_env.validation import CHECKS, known_failures, measured_data, row_of
from grind_env.validation.rig import Rig

LEAST_ROWS = 2  #: least number of rows that must notice the change of a law that carries a decision
#: row that is left out: it checks entries of the catalogue, not laws, and takes a fifth of the time of all rows
SKIPPED_ROW = "idle fields"


class Law(NamedTuple):
    """A law of the process after a change; the fields are the columns of `laws.csv`."""

    name: str
    function: str  #: name of the function below `grind_env.process`
    old: str  #: text that occurs once in the source of the function
    new: str
    decides: str = ""  #: the decision of a shop that the law carries; "" for none
    known: str = ""  #: reason why fewer than `LEAST_ROWS` rows notice the law; "" if `LEAST_ROWS` rows must notice it

    def original(self) -> Any:
        """Return the unchanged function of the process."""
        module, _, name = self.function.rpartition(".")
        return getattr(import_module(f"grind_env.process.{module}"), name)

    def source(self) -> str:
        """Return the source of the changed function."""
        text = inspect.getsource(self.original())
        if (count := text.count(self.old)) != 1:
            said = f"{self.function} has {self.old!r} {count} times"
            raise GrindError(f"laws.csv: {self.name}: {said}; write a text that stands there once")
        return text.replace(self.old, self.new)


LAWS = tuple(Law(**row) for row in measured_data.rows("laws", Path(__file__).parent))


class MutationResult(NamedTuple):
    """A changed law and the names of the rows that pass without the change and fail with it."""

    law: Law
    rows: tuple[str, ...]

    @property
    def is_expected(self) -> bool:
        """Return whether enough rows notice the law, or it is a known exception."""
        return not self.law.decides or (len(self.rows) < LEAST_ROWS) == bool(self.law.known)


@contextmanager
def changed(law: Law) -> Iterator[None]:
    """Return a context in which a law is changed for all callers of its function; only without compilation."""
    function = law.original()
    names = {**function.__globals__}
    exec(law.source(), names)
    before, function.__code__ = function.__code__, names[function.__name__].__code__
    try:
        yield
    finally:
        function.__code__ = before


def notice(law: Law) -> MutationResult:
    """Return a law with the rows that notice its change."""
    rig = Rig(load_catalogue())
    checks = [check for check in CHECKS if check.name not in known_failures() and check.name != SKIPPED_ROW]
    with changed(law):
        return MutationResult(law, tuple(check.name for check in checks if not row_of(check, rig).passed))


def mutate() -> list[MutationResult]:
    """Return each law with the rows that notice its change; laws change one at a time, in uncompiled processes."""
    before = os.environ.get("NUMBA_DISABLE_JIT", "0")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
        found = list(pool.map(notice, LAWS))
    os.environ["NUMBA_DISABLE_JIT"] = before
    return found
