"""Compilation of scalar functions: one source for plain Python, the scalar loop and the SIMD block loop."""

from grind_env.kernel.compile import entry, inlined, inlined_rule
from grind_env.kernel.elementary import exp, log, logistic, power, tanh
from grind_env.kernel.tiers import compile_at_once, foresee, runs_alone

__all__ = [
    "compile_at_once",
    "entry",
    "exp",
    "foresee",
    "inlined",
    "inlined_rule",
    "log",
    "logistic",
    "power",
    "runs_alone",
    "tanh",
]
