"""Simulator and Gymnasium environments for the surface-grinding cycles of a CNC grinder control.

Importing the package registers the environments `grind/<Task>-v0`. `evaluate(policy, id)` says what a policy is worth.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grind_env.policies.judging import evaluate

try:
    from grind_env.envs import register
except KeyboardInterrupt:
    # the command `grind` has to import its package before it can guard anything
    if sys.argv[0].replace("\\", "/").rpartition("/")[2] in ("grind", "grind.exe"):
        sys.exit(130)
    raise

__all__ = ["__version__", "evaluate"]
__version__ = "0.1.0"

register()


def __getattr__(name: str) -> Any:
    """What is imported when it is asked for, because it takes long."""
    if name == "evaluate":
        return import_module("grind_env.policies.judging").evaluate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
