"""The two ways to compile a function of this package.

`inlined` marks a small scalar function (a rule of the control, an equation of the process). It is always
inlined into its caller, because LLVM vectorises a loop over environments only if the loop body holds no call.

`entry` marks a loop that Python calls. Only these are cached on disk.

Both keep strict IEEE arithmetic (no fastmath, no fused multiply-add), so that the result for one environment
has the same bits on every machine, for every batch size, in compiled code and in plain Python
(`NUMBA_DISABLE_JIT=1`).
"""

import functools
import gc
from collections.abc import Callable
from inspect import isfunction
from types import FunctionType
from typing import Any, ClassVar, TypeVar, cast

import llvmlite.binding as llvm
import numba
from numba.core.compiler import Compiler

from grind_env.kernel.cache import keep_on_disk
from grind_env.kernel.dispatch import Entry, Inlined

Function = TypeVar("Function", bound=Callable[..., Any])

# inlined functions allocate nothing: the reference counting of arrays took a quarter of the time of a step
INLINED = {"error_model": "numpy", "forceinline": True, "_nrt": False}


class KernelCompiler(Compiler):  # type: ignore[misc]
    """numba's compiler, with instructions scheduled for parallelism.

    LLVM's default order saves registers. A stroke is a long chain of divisions and exponentials, and runs faster if
    independent operations stand side by side. The results have the same bits. The option holds for the whole process,
    so it is set only during a compilation and the compilations inside it, under numba's lock. Meanwhile Python's
    garbage collection, which took a tenth of the compile time, is off.
    """

    under_way: ClassVar[int] = 0
    collects: ClassVar[bool] = False  #: whether garbage collection was on before the compilation

    def compile_extra(self, function: Any) -> Any:
        if KernelCompiler.under_way == 0:
            llvm.set_option("", "--pre-RA-sched=list-ilp")
            KernelCompiler.collects = gc.isenabled()
            gc.disable()
        KernelCompiler.under_way += 1
        try:
            return super().compile_extra(function)
        finally:
            KernelCompiler.under_way -= 1
            if KernelCompiler.under_way == 0:
                llvm.set_option("", "--pre-RA-sched=default")
                if KernelCompiler.collects:
                    gc.enable()


def inlined(function: Function) -> Function:
    """Compile a scalar function so that it is inlined wherever it is called."""
    compiled = numba.njit(**INLINED)(function)
    if not numba.config.DISABLE_JIT:
        # the wrappers for Python took a third of the compile time: compiled callers use a twin without wrappers
        twin = numba.njit(**INLINED, no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)
        compiled.get_call_template, compiled.get_overload = twin.get_call_template, twin.get_overload
        compiled.__class__ = Inlined
    return cast(Function, compiled)


def inlined_rule(rule: Function) -> Function:
    """Return a plain Python rule compiled as by `inlined`, with the plain functions that the rule calls."""
    return cast(Function, _inlined_rule(rule))


@functools.cache
def _inlined_rule(rule: FunctionType) -> Any:
    names = rule.__globals__
    called = {name: _inlined_rule(names[name]) for name in rule.__code__.co_names if isfunction(names.get(name))}
    return inlined(FunctionType(rule.__code__, {**names, **called}, rule.__name__))


def entry(function: Function) -> Function:
    """Compile a loop that Python calls; the loop releases the GIL and is cached on disk."""
    options = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True, "pipeline_class": KernelCompiler}
    # numba passes `_nrt` from caller to callee: an entry first compiled in an inlined function could not make arrays
    compiled = numba.njit(**options, _nrt=True)(function)
    if not numba.config.DISABLE_JIT:
        keep_on_disk(compiled)
        compiled.__class__ = Entry
    return cast(Function, compiled)
