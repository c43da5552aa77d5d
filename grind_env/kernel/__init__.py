"""Compilation of scalar functions: one source for plain Python, the scalar loop and the SIMD block loop."""

from grind_env.kernel.compile import entry, inlined, inlined_rule, plain
from grind_env.kernel.elementary import exp, log, logistic, power, tanh

__all__ = ["entry", "exp", "inlined", "inlined_rule", "log", "logistic", "plain", "power", "tanh"]
