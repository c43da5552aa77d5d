"""Simulator and Gymnasium environments for the surface-grinding cycles of a CNC grinder control.

Import the package and Gymnasium, in any order, to register the environments `grind/<Task>-v0`.
`evaluate(policy, id)` returns cost and score of a policy in one task, `evaluate_core(policy)` in all core tasks.
`grind`, `optimise`, `sweep`, `calibrate` and `report` are the commands of these names as functions, on the same files.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from grind_env.envs import register

if TYPE_CHECKING:
    from grind_env import examples
    from grind_env.control import read as parse_program
    from grind_env.control import read_file as read_program
    from grind_env.envs.tasks import load_task
    from grind_env.machine.grind import grind_file as grind
    from grind_env.machine.job.job_file import load_job
    from grind_env.machine.script.script import script_of
    from grind_env.policies.core_scores import evaluate_core
    from grind_env.policies.scoring import evaluate
    from grind_env.shop.python_api import calibrate, optimise, report, sweep

__all__ = [
    "__version__",
    "calibrate",
    "evaluate",
    "evaluate_core",
    "examples",
    "grind",
    "load_job",
    "load_task",
    "optimise",
    "parse_program",
    "read_program",
    "report",
    "script_of",
    "sweep",
]
__version__ = "0.3.0"

#: module and name of each object that is imported on first use, because its import is slow
LAZY = {
    "calibrate": ("shop.python_api", "calibrate"),
    "evaluate": ("policies.scoring", "evaluate"),
    "evaluate_core": ("policies.core_scores", "evaluate_core"),
    "grind": ("machine.grind", "grind_file"),
    "load_job": ("machine.job.job_file", "load_job"),
    "load_task": ("envs.tasks", "load_task"),
    "optimise": ("shop.python_api", "optimise"),
    "parse_program": ("control", "read"),
    "read_program": ("control", "read_file"),
    "report": ("shop.python_api", "report"),
    "script_of": ("machine.script.script", "script_of"),
    "sweep": ("shop.python_api", "sweep"),
}

register()


def __getattr__(name: str) -> Any:
    """Import slow modules on first use."""
    if name == "examples":
        return import_module("grind_env.examples")
    if name in LAZY:
        module, own_name = LAZY[name]
        return getattr(import_module(f"grind_env.{module}"), own_name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return all public names, including slow modules, so that notebooks can complete them."""
    return sorted({*globals(), *__all__})
