"""Compilation of scalar functions: one source for plain Python, the scalar loop and the SIMD block loop."""

from grind_env.kernel.compile import entry, inlined
from grind_env.kernel.elementary import exp, log, logistic, power, softplus, tanh

__all__ = ["entry", "exp", "inlined", "log", "logistic", "power", "softplus", "tanh"]
