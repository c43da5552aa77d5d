"""Change the laws of `laws.csv` one at a time, and list the rows that notice."""

import inspect
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from grind_env.errors import GrindError
from grind_env.process.catalogue import load_catalogue
from grind_env.validation import CHECKS, data, known_failures, row_of
from grind_env.validation.rig import Rig

LEAST = 2
"""Rows that have to notice a law that carries a decision."""
OF_ENTRIES = "idle fields"
"""The row that asks what entries do, and nothing of a law; it takes a fifth of the time of all."""


class Law(NamedTuple):
    """A law of the process after a change; the fields are the columns of `laws.csv`."""

    name: str
    function: str
    """Below `grind_env.process`."""
    old: str
    """Stands once in the source of the function."""
    new: str
    decides: str = ""
    """The decision of a shop that the law carries; "" for none."""
    known: str = ""
    """Why fewer than `LEAST` rows notice the law; "" where as many have to."""

    def original(self) -> Any:
        """Return the function as the process has it."""
        module, _, name = self.function.rpartition(".")
        return getattr(import_module(f"grind_env.process.{module}"), name)

    def source(self) -> str:
        """Return the source of the changed function."""
        text = inspect.getsource(self.original())
        if (count := text.count(self.old)) != 1:
            said = f"{self.function} has {self.old!r} {count} times"
            raise GrindError(f"laws.csv: {self.name}: {said}; write a text that stands there once")
        return text.replace(self.old, self.new)


LAWS = tuple(Law(**row) for row in data.rows("laws", Path(__file__).parent))


class Noticed(NamedTuple):
    """A changed law and the names of the rows that pass without the change and fail with it."""

    law: Law
    rows: tuple[str, ...]

    @property
    def as_known(self) -> bool:
        """Return whether enough rows notice the law, or it is a known exception."""
        return not self.law.decides or (len(self.rows) < LEAST) == bool(self.law.known)


@contextmanager
def changed(law: Law) -> Iterator[None]:
    """Change a law for a while, wherever its function is called from; only where nothing is compiled."""
    function = law.original()
    names = {**function.__globals__}
    exec(law.source(), names)
    before, function.__code__ = function.__code__, names[function.__name__].__code__
    try:
        yield
    finally:
        function.__code__ = before


def notice(law: Law) -> Noticed:
    """Take all rows with a changed law."""
    rig = Rig(load_catalogue())
    checks = [check for check in CHECKS if check.name not in known_failures() and check.name != OF_ENTRIES]
    with changed(law):
        return Noticed(law, tuple(check.name for check in checks if not row_of(check, rig).passed))


def mutate(laws: Sequence[Law] = LAWS) -> list[Noticed]:
    """Change laws one at a time, in processes that run plain Python; returns what notices them, in order."""
    before = os.environ.get("NUMBA_DISABLE_JIT", "0")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    with ProcessPoolExecutor(os.cpu_count(), multiprocessing.get_context("spawn")) as pool:
        found = list(pool.map(notice, laws))
    os.environ["NUMBA_DISABLE_JIT"] = before
    return found
