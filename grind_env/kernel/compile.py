"""The two ways in which a function of this package is compiled.

`inlined` marks a small scalar function (a rule of the control, an equation of the process). It is always
inlined into its caller, because LLVM vectorises a loop over environments only if the loop body holds no call.

`entry` marks a loop that Python calls. Only these are cached on disk. numba keys its cache on the file of the
cached function alone, so an edited equation in another file would go unnoticed; therefore the cache folder is
named after a hash of every source file that kernels are made of.

Both keep strict IEEE arithmetic (no fastmath, no fused multiply-add), so that the result for one environment
has the same bits on every machine, for every batch size, in compiled code and in plain Python
(`NUMBA_DISABLE_JIT=1`).
"""

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs

Function = TypeVar("Function", bound=Callable[..., Any])

PACKAGE = Path(__file__).resolve().parents[1]


def inlined(function: Function) -> Function:
    """Compile a scalar function so that it is inlined wherever it is called."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))


def entry(function: Function) -> Function:
    """Compile a loop that Python calls, without the GIL and with a disk cache that cannot be stale."""
    user_choice = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        return cast(Function, numba.njit(error_model="numpy", nogil=True, cache=True)(function))
    finally:
        numba.config.CACHE_DIR = user_choice


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled kernels: below `NUMBA_CACHE_DIR` or the user's cache, named after the sources."""
    base = numba.config.CACHE_DIR or platformdirs.user_cache_dir("grind_env")
    return Path(base) / f"kernels-{source_hash(PACKAGE)}"


def source_hash(package: Path) -> str:
    """Hash of the name and content of every Python file below `package`."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        digest.update(str(path.relative_to(package)).encode())
        digest.update(b"\0")
        digest.update(path.read_bytes())
        digest.update(b"\0")
    return digest.hexdigest()[:16]
