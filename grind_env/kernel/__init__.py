"""Compilation of scalar functions: one source for plain Python, the scalar loop and the SIMD block loop."""

from grind_env.kernel.dispatch import MANY, MANY_ROWS, compile_at_once, runs_alone
from grind_env.kernel.exp_log import exp, log, logistic, power, tanh
from grind_env.kernel.jit_decorators import entry, inlined, inlined_rule

__all__ = [
    "MANY",
    "MANY_ROWS",
    "compile_at_once",
    "entry",
    "exp",
    "inlined",
    "inlined_rule",
    "log",
    "logistic",
    "power",
    "runs_alone",
    "tanh",
]
