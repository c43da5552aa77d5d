"""Two tiers with the same bits: an entry runs as plain Python while that is little work, and compiled where it pays.

Where it is neither compiled in this process nor on disk, it runs as it is written until that has taken a share of the
time to compile it. Then another process compiles it into the cache while plain calls go on, and it is taken from there.
Where there is no such process, it is compiled here once plain calls have taken as long as that does.
"""

import time
from collections.abc import Callable
from types import CellType, FunctionType, ModuleType, SimpleNamespace
from typing import Any, ClassVar, TypeVar

import numpy as np
from numba.core.registry import CPUDispatcher
from numba.extending import is_jitted

from grind_env.kernel.background import Background
from grind_env.kernel.cache import compile_seconds

Function = TypeVar("Function", bound=Callable[..., Any])

SHARE = 0.05
"""Of the time to compile an entry, for which it runs as plain Python before that is begun in the background."""
FEW = 0.1
"""s of plain calls of an inlined function, about what it takes to compile it."""
MANY = 16
"""Episodes side by side from which on plain Python would be slow."""
MANY_ROWS = 1024
"""The same of rows in one call."""
LOOK = 0.25
"""s of plain calls between two looks for the file."""

WRITTEN: dict[Any, FunctionType] = {}
"""Compiled functions as they are written, of those that have run so."""


class Entry(CPUDispatcher):  # type: ignore[misc]
    """What `entry` makes of a function. Once it is compiled it is numba's dispatcher and nothing else."""

    at_once: ClassVar[bool] = False
    """Whether entries are compiled when they are called first."""
    alone: Callable[[], Any] | None = None
    """Of `runs_alone`."""
    spent: float = 0.0
    """CPU-seconds of plain calls."""
    due: float = 0.0
    """Of these, at which it is to be asked again whether to compile."""

    def __call__(self, *args: Any) -> Any:
        """Run it."""
        if Entry.at_once or self.overloads or (self.spent >= self.due and self._pays(args)):
            self.__class__ = CPUDispatcher
            return self(*args)
        begin = time.thread_time()
        try:
            with np.errstate(all="ignore"):  # as compiled code does
                return as_written(self)(*args)
        finally:
            self.spent += time.thread_time() - begin

    def _pays(self, args: tuple[Any, ...]) -> bool:
        """Whether it is to be had from disk, or is to be compiled here; the background is asked for what is missing."""
        types = tuple(map(self.typeof_pyval, args))
        if self._cache.has(types):
            return True
        self.due = self.spent + LOOK
        price = compile_seconds(self)
        if self.spent < SHARE * price:
            self.due = SHARE * price
            return False
        return not Background.compiles(self, types, self._cache.folder) and self.spent >= price


class Inlined(CPUDispatcher):  # type: ignore[misc]
    """What `inlined` makes of a function: plain Python where Python calls it, until it is compiled for many calls."""

    spent: float = 0.0
    """CPU-seconds of plain calls."""

    def __call__(self, *args: Any) -> Any:
        """Run it."""
        if self.spent < FEW:
            begin = time.thread_time()
            try:
                with np.errstate(all="ignore"):
                    return as_written(self)(*args)
            except ArithmeticError:  # of Python's own floats, where compiled code has an infinity or NaN
                pass
            finally:
                self.spent += time.thread_time() - begin
        self.__class__ = CPUDispatcher
        return self(*args)


def compile_at_once() -> None:
    """Compile entries from now on when they are called first: for much work, of which plain Python would be slow."""
    Entry.at_once = True


def runs_alone(kernel: Any, twin: Callable[[], Any]) -> None:
    """Let another entry run as plain Python in the place of one, such as one with a single lane; `twin()` makes it."""
    if isinstance(kernel, Entry):
        kernel.alone = twin


def as_written(function: Any) -> Any:
    """A compiled function as it is written, with all that it calls; anything else as it is."""
    if not is_jitted(function):
        return function
    if function in WRITTEN:
        return WRITTEN[function]
    twin = getattr(function, "alone", None)
    if twin is not None:
        WRITTEN[function] = as_written(twin())
        return WRITTEN[function]
    code = function.py_func
    names = {**code.__globals__}
    cells = tuple(CellType() for _ in code.__closure__ or ())
    made = FunctionType(code.__code__, names, code.__name__, code.__defaults__, cells or None)
    WRITTEN[function] = made  # before what it calls, which may call it
    for name in code.__code__.co_names:
        if isinstance(names.get(name), ModuleType):
            names[name] = SimpleNamespace(**{each: as_written(value) for each, value in vars(names[name]).items()})
        elif name in names:
            names[name] = as_written(names[name])
    for cell, own in zip(cells, code.__closure__ or (), strict=True):
        cell.cell_contents = as_written(own.cell_contents)
    return made
