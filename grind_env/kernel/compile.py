"""The two ways in which a function of this package is compiled.

`inlined` marks a small scalar function (a rule of the control, an equation of the process). It is always
inlined into its caller, because LLVM vectorises a loop over environments only if the loop body holds no call.

`entry` marks a loop that Python calls. Only these are cached on disk. numba keys its cache on the file of the
cached function alone, so an edited equation in another file would go unnoticed; therefore the cache folder of an
entry is named after a hash of every source file and every constant that it is made of.

Both keep strict IEEE arithmetic (no fastmath, no fused multiply-add), so that the result for one environment
has the same bits on every machine, for every batch size, in compiled code and in plain Python
(`NUMBA_DISABLE_JIT=1`).
"""

import hashlib
import sys
import tempfile
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs

Function = TypeVar("Function", bound=Callable[..., Any])

PACKAGE = Path(__file__).resolve().parents[1]
KERNEL_FILES = frozenset(Path(__file__).resolve().parent.glob("*.py"))


def inlined(function: Function) -> Function:
    """Compile a scalar function so that it is inlined wherever it is called."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))


def entry(function: Function) -> Function:
    """Compile a loop that Python calls, without the GIL and with a disk cache that cannot be stale.

    Where the cache folder cannot be written to there is no disk cache: numba's own choice, a folder beside the
    source, would not notice an edit elsewhere.
    """
    user_choice = numba.config.CACHE_DIR
    base = user_choice or platformdirs.user_cache_dir("grind_env")
    folder = Path(base) / f"kernels-{fingerprint(function)}"
    numba.config.CACHE_DIR = str(folder)
    try:
        return cast(Function, numba.njit(error_model="numpy", nogil=True, cache=writable(folder))(function))
    finally:
        numba.config.CACHE_DIR = user_choice


def writable(folder: Path) -> bool:
    """Make a folder, and say whether files can be written into it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def fingerprint(function: Callable[..., Any]) -> str:
    """Hash of all that a function is made of: the files of this package that it reaches, and the constants.

    Follows the global names in the code of the function, and of every function of this package that they lead to.
    """
    files = set(KERNEL_FILES)
    constants: list[str] = []
    seen: set[int] = set()
    waiting: list[Any] = [function]
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        thing = getattr(thing, "py_func", thing)
        if isinstance(thing, types.FunctionType):
            files.add(Path(thing.__code__.co_filename))
            names = [name for name in thing.__code__.co_names if name in thing.__globals__]
            waiting += [thing.__globals__[name] for name in names]
            constants += [f"{name} = {_constant(thing.__globals__[name])}" for name in names]
            constants.append(" ".join(thing.__code__.co_names))  # generated code has no file, only names of fields
        elif isinstance(thing, types.ModuleType | type):
            module = thing if isinstance(thing, types.ModuleType) else sys.modules[thing.__module__]
            files.add(Path(module.__file__ or "."))
            waiting += [value for value in vars(module).values() if hasattr(value, "py_func")]
    digest = hashlib.sha256("\n".join(sorted(constants)).encode())
    for path in sorted(files):
        if path.is_relative_to(PACKAGE):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _constant(value: Any) -> str:
    return repr(value) if isinstance(value, int | float | str | tuple | list | type) else type(value).__name__
