"""The fingerprint of a compiled kernel: one hash of everything that its machine code depends on.

numba copies all values that a function names into its machine code: compiled functions, constants, arrays, fields of
named tuples. The fingerprint follows these names through globals, closures, default arguments and attributes of
modules. It hashes code, not files, so generated code counts like any other. The fingerprint is computed when numba
compiles, because names may be bound after a function is defined.

The code of intrinsics and overloads cannot be seen from their callers. They must be in `grind_env.kernel`, whose files
are always part of the fingerprint.

A library counts by its version. Anything else is an `UnknownIngredient`, because a guess could load stale code.
"""

import dis
import enum
import functools
import hashlib
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import llvmlite
import numba
import numpy as np

KERNEL = __name__.rpartition(".")[0]
LIBRARIES = sys.stdlib_module_names | {"numba", "numpy"}
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(...))
ELSEWHERE = ("CACHE_", "CUDA_", "NUMBA_")  # numba settings to ignore: cache folders, graphics cards, numbers of threads

Description: TypeAlias = Any  # a plain constant, or a tuple of descriptions: its `repr` is the same in every process
Seen: TypeAlias = dict[Callable[..., Any], int]


class UnknownIngredient(TypeError):
    """A kernel that uses a value of unknown content."""


def fingerprint(function: Callable[..., Any], *conditions: Any) -> str:
    """Return the hash of a function, its compile conditions (argument types, CPU) and the compiler.

    Raises:
        UnknownIngredient: a value cannot be described with certainty.
    """
    seen: Seen = {}
    if isinstance(function, types.FunctionType):
        made_of = _function(function, seen)
    else:
        made_of = _described(function, function.__qualname__, seen)
    conditions = _described(conditions, f"the conditions of {function.__qualname__}", seen)
    return _hash((made_of, conditions, _compiler(), _kernel_files()))[:32]


def count_functions(function: Callable[..., Any]) -> int:
    """Return the number of functions that a function uses, with itself; the compile time is proportional to it.

    Raises:
        UnknownIngredient: as for `fingerprint`.
    """
    seen: Seen = {}
    _described(function, function.__qualname__, seen)
    return len(seen)


def _compiler() -> Description:
    """Return versions and settings of everything that turns code into machine code."""
    settings = {name: str(value) for name, value in vars(numba.config).items() if name.isupper()}
    chosen = sorted((name, value) for name, value in settings.items() if not name.startswith(ELSEWHERE))
    return sys.version, numba.__version__, llvmlite.__version__, np.__version__, *chosen


@functools.cache
def _kernel_files() -> str:
    return _hash([(path.name, path.read_bytes()) for path in sorted(Path(__file__).parent.glob("*.py"))])


def _hash(description: Description) -> str:
    return hashlib.sha256(repr(description).encode()).hexdigest()


def _described(value: Any, place: str, seen: Seen) -> Description:
    inner = functools.partial(_described, place=place, seen=seen)
    if type(value) in PLAIN:
        return value
    if isinstance(value, enum.Enum):
        return "member", inner(type(value)), value.name
    if isinstance(value, tuple | list):
        return inner(type(value)), *map(inner, value)
    if isinstance(value, set | frozenset):
        return inner(type(value)), *sorted(repr(inner(element)) for element in value)
    if isinstance(value, dict):
        return inner(type(value)), *((inner(key), inner(element)) for key, element in value.items())
    if isinstance(value, slice):
        return "slice", inner(value.start), inner(value.stop), inner(value.step)
    if isinstance(value, np.dtype) and not value.hasobject:
        return "dtype", repr(value)
    if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
        layout = (value.flags.c_contiguous, value.flags.f_contiguous, value.flags.aligned)
        return inner(type(value)), repr(value.dtype), value.shape, layout, hashlib.sha256(value.tobytes()).hexdigest()
    if isinstance(value, types.CodeType):
        return _code(value, inner)
    if numba.extending.is_jitted(value):
        return "compiled", inner(value.targetoptions), inner(value.locals), _function(value.py_func, seen)
    if isinstance(value, numba.types.Omitted):
        return "omitted", inner(value.value)  # numba may compare these types by address
    if isinstance(value, numba.types.Type):
        return "type", type(value).__qualname__, inner(value.key)  # numba itself compares types by this key
    if isinstance(value, type) and issubclass(value, enum.Enum):
        members = ((name, inner(member.value)) for name, member in value.__members__.items())
        return "enum", value.__module__, value.__qualname__, *map(inner, value.__mro__[1:-1]), *members
    if isinstance(value, type) and hasattr(value, "_fields") and hasattr(value, "_field_defaults"):
        return "record", value.__module__, value.__qualname__, value._fields, inner(value._field_defaults)
    if _known_by_name(value):
        return "name", _origin(value), value.__name__
    if isinstance(value, types.FunctionType) and _origin(value).rpartition(".")[0] == KERNEL:
        return "made", _function(value, seen)  # by a function of this package; its closure is described, too
    raise UnknownIngredient(
        f"{place} is of type {type(value).__name__}, whose content the cache of kernels cannot tell: compiled code may "
        f"name constants, arrays, named tuples, enums, @inlined functions and entries, and overloads of {KERNEL}"
    )


def _function(function: types.FunctionType, seen: Seen) -> Description:
    """Return code, defaults and named values of a function; a number if the function was described before."""
    if function in seen:
        return "again", seen[function]
    seen[function] = len(seen)
    name, code = function.__qualname__, function.__code__
    return (
        (function.__module__, name),
        _described(code, name, seen),
        _described(function.__defaults__, f"a default of {name}", seen),
        _described(function.__kwdefaults__, f"a default of {name}", seen),
        *((free, _described(value, f"{free} in {name}", seen)) for free, value in _cells(function)),
        *_globals(function, seen),
    )


def _code(code: types.CodeType, inner: Callable[[Any], Description]) -> Description:
    arguments = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    handlers = getattr(code, "co_exceptiontable", None)  # Python 3.10 has them in the code
    return "code", code.co_name, code.co_code, handlers, arguments, names, inner(code.co_consts)


def _cells(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield from _with_attributes(name, cell.cell_contents, names_in(function.__code__))


def _globals(function: types.FunctionType, seen: Seen) -> Iterator[Description]:
    """Yield every global whose name is in the code, also as an attribute, because telling these apart is slow."""
    names = names_in(function.__code__)
    for name in names:
        if name in function.__globals__:
            for path, value in _with_attributes(name, function.__globals__[name], names):
                before = len(seen)
                try:
                    yield path, _described(value, f"{path} in {function.__qualname__}", seen)
                except UnknownIngredient:
                    if _loads(function.__code__, name):
                        raise
                    while len(seen) > before:
                        seen.popitem()  # their descriptions are dropped with the failed one


def names_in(code: types.CodeType) -> list[str]:
    """Return the names of globals and attributes in a code object, and in functions and comprehensions within it."""
    return list(dict.fromkeys([*code.co_names, *(name for within in _within(code) for name in names_in(within))]))


def _loads(code: types.CodeType, name: str) -> bool:
    """Return whether the code uses the name for a global, not only for an attribute."""
    loaded = (step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"))
    return name in loaded or any(_loads(within, name) for within in _within(code))


def _within(code: types.CodeType) -> Iterator[types.CodeType]:
    return (constant for constant in code.co_consts if isinstance(constant, types.CodeType))


def _with_attributes(
    name: str, value: Any, names: list[str], above: tuple[types.ModuleType, ...] = ()
) -> Iterator[tuple[str, Any]]:
    """Yield a name with its value; for a module that is no library, the attributes that the code names."""
    if not isinstance(value, types.ModuleType) or _known_by_name(value):
        yield name, value
    elif value not in above:
        for attribute in names:
            if hasattr(value, attribute):
                yield from _with_attributes(f"{name}.{attribute}", getattr(value, attribute), names, (*above, value))


def _known_by_name(value: Any) -> bool:
    """Return whether the name alone identifies a value: one of a library, our overloads, or an exception class."""
    if isinstance(value, type) and issubclass(value, BaseException):
        return True
    origin, name = _origin(value), getattr(value, "__name__", None)
    if isinstance(value, types.ModuleType):
        return origin.partition(".")[0] in LIBRARIES
    if origin.partition(".")[0] not in LIBRARIES and origin.rpartition(".")[0] != KERNEL:
        return False
    return name is not None and getattr(sys.modules.get(origin), name, None) is value


def _origin(value: Any) -> str:
    """Return the name of the module of a value; for a module its own name."""
    if isinstance(value, np.ufunc):
        return "numpy"  # ufuncs of older versions have no `__module__`
    return str(value.__name__ if isinstance(value, types.ModuleType) else getattr(value, "__module__", None))
