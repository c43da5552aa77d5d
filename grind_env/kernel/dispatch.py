"""Two ways to run an entry, with the same bits: plain Python for little work, compiled code for much.

An entry that is neither compiled in this process nor in the cache on disk runs as plain Python. Once plain calls have
taken a share of its compile time, a background process compiles the entry into the cache, from where it is loaded.
Without a background process the entry is compiled in place, once plain calls have taken as long as its compilation.
"""

import time
from collections.abc import Callable, Iterator
from types import CellType, FunctionType, ModuleType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from numba.core.registry import CPUDispatcher
from numba.extending import is_jitted

from grind_env.kernel.background_compiler import Background
from grind_env.kernel.cache import compile_seconds

SHARE = 0.05  #: ratio of the time of plain calls to the compile time at which the background process starts to compile
INLINED_SECONDS = 0.1  #: time of plain calls after which an inlined function is compiled, s: about its compile time
MANY = 16  #: number of parallel episodes from which on plain Python is too slow
MANY_ROWS = 1024  #: number of rows in one call from which on plain Python is too slow
CACHE_CHECK_SECONDS = 0.25  #: time of plain calls between two checks of the cache, s
#: errors of Python floats, such as a division by 0, where compiled code continues with infinity or NaN
PYTHON_ERRORS = ArithmeticError, ValueError

#: the plain Python function of each compiled function that has run as plain Python
WRITTEN: dict[Any, FunctionType] = {}


class Entry(CPUDispatcher):  # type: ignore[misc]  # numba has no types
    """An entry before its compilation. Afterwards numba's class replaces this one, so that calls are as fast."""

    at_once: ClassVar[bool] = False  #: whether the first call compiles an entry
    #: function that makes the stand-in for plain Python; None without one. `runs_alone` sets it
    alone: Callable[[], Any] | None = None
    spent: float = 0.0  #: CPU-seconds of plain calls so far
    due: float = 0.0  #: CPU-seconds of plain calls at which `_pays` is called next

    def __call__(self, *args: Any) -> Any:
        if not (Entry.at_once or self.overloads or (self.spent >= self.due and self._pays(args))):
            before = [(array, array.copy()) for array in _arrays(args)]
            begin = time.thread_time()
            try:
                with np.errstate(all="ignore"):  # as compiled code does
                    return as_written(self)(*args)
            except PYTHON_ERRORS:
                for array, values in before:
                    array[...] = values
            finally:
                self.spent += time.thread_time() - begin
        self.__class__ = CPUDispatcher
        return self(*args)

    def _pays(self, args: tuple[Any, ...]) -> bool:
        """Return whether to run compiled code; start the background compilation when it is due."""
        types = tuple(map(self.typeof_pyval, args))
        if self._cache.has(types):
            return True
        self.due = self.spent + CACHE_CHECK_SECONDS
        price = compile_seconds(self)
        if self.spent < SHARE * price:
            self.due = SHARE * price
            return False
        return not Background.compiles(self, types, self._cache.folder) and self.spent >= price


class Inlined(CPUDispatcher):  # type: ignore[misc]  # numba has no types
    """An inlined function that Python calls: plain Python for few calls, compiled code for many."""

    spent: float = 0.0  #: CPU-seconds of plain calls so far

    def __call__(self, *args: Any) -> Any:
        """Run the function, which changes no argument."""
        if self.spent < INLINED_SECONDS:
            begin = time.thread_time()
            try:
                with np.errstate(all="ignore"):
                    return as_written(self)(*args)
            except PYTHON_ERRORS:
                pass
            finally:
                self.spent += time.thread_time() - begin
        self.__class__ = CPUDispatcher
        return self(*args)


def compile_at_once() -> None:
    """Compile entries at their first call from now on, because there is much work to come."""
    Entry.at_once = True


def runs_alone(kernel: Any, twin: Callable[[], Any]) -> None:
    """Let another entry replace a kernel in plain Python, such as a loop with one lane; `twin()` returns it."""
    if isinstance(kernel, Entry):
        kernel.alone = twin


def as_written(function: Any) -> Any:
    """Return the plain Python of a compiled function, with all functions that it calls; other values unchanged."""
    if not is_jitted(function):
        return function
    if function in WRITTEN:
        return WRITTEN[function]
    if twin := getattr(function, "alone", None):
        WRITTEN[function] = as_written(twin())
        return WRITTEN[function]
    python = function.py_func
    names = {**python.__globals__}
    cells = tuple(CellType() for _ in python.__closure__ or ())
    made = FunctionType(python.__code__, names, python.__name__, python.__defaults__, cells or None)
    WRITTEN[function] = made  # before the functions that it calls, which may call it
    for name in python.__code__.co_names:
        if isinstance(names.get(name), ModuleType):
            names[name] = SimpleNamespace(**{each: as_written(value) for each, value in vars(names[name]).items()})
        elif name in names:
            names[name] = as_written(names[name])
    for cell, own in zip(cells, python.__closure__ or (), strict=True):
        cell.cell_contents = as_written(own.cell_contents)
    return made


def _arrays(values: tuple[Any, ...]) -> Iterator[Any]:
    """Yield the arrays in nested tuples that a function may write."""
    for value in values:
        if isinstance(value, tuple):
            yield from _arrays(value)
        elif isinstance(value, np.ndarray) and value.flags.writeable:
            yield value
