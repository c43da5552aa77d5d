"""What a node must have as this machine has it, so that it finds what would have been found here."""

import hashlib
import platform
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import agents
import grind_env
from agents.cells import RESULTS, behaviour
from agents.provenance import commit, installed
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import CONFIGS, tuned_folder
from grind_env.scores import FILE as SCORES

LIBRARIES = ("cma", "gymnasium", "numba", "numpy", "sb3_contrib", "stable_baselines3", "torch")
WRITTEN = (RESULTS, CONFIGS, SCORES)
"""Where commands write: parameters go with a cell, settings are compared for a training, the others decide nothing."""

Facts = Mapping[str, str]


@cache
def of_machine() -> Facts:
    """Versions, and a hash of the code and data of both packages."""
    files = []
    for package in (grind_env, agents):
        folder = Path(str(package.__file__)).parent
        files += [(path.relative_to(folder.parent).as_posix(), path) for path in folder.rglob("*") if _decides(path)]
    versions = {library: installed(library) for library in LIBRARIES}
    return {"code": _digest(path for _, path in sorted(files)), "python": platform.python_version(), **versions}


@cache
def of_problem(problem: Problem, trains: bool) -> Facts:
    """Hashes of what a problem answers to a probe and, where agents are trained, of what their trainings are set to."""
    simulation = problem.simulation()
    task = simulation.task
    facts = {problem.name: behaviour(simulation)[:12]}
    if trains:
        name = f"{problem.name}.toml"
        facts["settings of agents"] = _digest([tuned_folder(task) / name])
    return facts


def difference(node: str, theirs: Facts, ours: Facts) -> str | None:
    """A sentence on the first fact in which a node differs from this machine; None if there is none."""
    for name in ours:
        if theirs.get(name) != ours[name]:
            return (
                f"the node {node} has {name} {theirs.get(name)} where this machine has {ours[name]}:"
                f" it must have commit {commit()}, the same versions and the same files of tasks"
            )
    return None


def _decides(path: Path) -> bool:
    written = any(place in (path, *path.parents) for place in WRITTEN)
    return path.is_file() and "__pycache__" not in path.parts and not written


def _digest(paths: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes() if path.is_file() else b"")
    return digest.hexdigest()[:12]
