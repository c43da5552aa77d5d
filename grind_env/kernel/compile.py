"""The two ways in which a function of this package is compiled.

`inlined` marks a small scalar function (a rule of the control, an equation of the process). It is always
inlined into its caller, because LLVM vectorises a loop over environments only if the loop body holds no call.

`entry` marks a loop that Python calls. Only these are cached on disk.

Both keep strict IEEE arithmetic (no fastmath, no fused multiply-add), so that the result for one environment
has the same bits on every machine, for every batch size, in compiled code and in plain Python
(`NUMBA_DISABLE_JIT=1`).
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from grind_env.kernel.cache import keep_on_disk

Function = TypeVar("Function", bound=Callable[..., Any])


def inlined(function: Function) -> Function:
    """Compile a scalar function so that it is inlined wherever it is called."""
    return cast(Function, numba.njit(error_model="numpy", forceinline=True)(function))


def entry(function: Function) -> Function:
    """Compile a loop that Python calls, without the GIL and with a disk cache that cannot be stale."""
    compiled = numba.njit(error_model="numpy", nogil=True)(function)
    if not numba.config.DISABLE_JIT:
        keep_on_disk(compiled)
    return cast(Function, compiled)
