"""Cached evaluations of policies.

Evaluations run once, in chunks of episodes, and are reused while no input of the result has changed.
"""

import ast
import hashlib
import os
import sys
import zipfile
from contextlib import suppress
from dataclasses import asdict, fields
from functools import cache
from pathlib import Path

import numpy as np

from agents.provenance import ROOT
from grind_env.envs.cost import Outcome
from grind_env.envs.distribution_splits import EVERY, SPLITS
from grind_env.envs.reset_options import find_split
from grind_env.envs.simulation import Simulation, advance
from grind_env.policies.evaluation import Evaluation, episode_seeds, run_seeds, start_episodes
from grind_env.policies.nominal_model import model_beside
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.scripted.rules import Random

RUNS = ROOT / "runs"  #: folder of the cache
RESULTS = ROOT / "agents" / "results"  #: the checked-in results
#: number of episodes evaluated at once. A planner may share random moves among them, so the result depends on it
CHUNK = 64
PROBES = 4
REWARD = Outcome._fields.index("reward")
#: prefixes of modules that decide observations or actions, but that the probe of a problem does not run
UNPROBED = (
    "grind_env.belief.",
    "grind_env.envs.block_rollouts",
    "grind_env.envs.episode_state",
    "grind_env.envs.learning_scales",
    "grind_env.envs.observation_memory",
    "grind_env.envs.filter_members",
    "grind_env.envs.space_metadata",
    "grind_env.envs.simulation",
    "grind_env.envs.wrappers",
    "grind_env.kernel.network_layers",
)
#: prefixes of all modules with code of policies and of their training
DECIDING = ("agents.", "grind_env.policies.", *UNPROBED)


def cached_evaluation(
    policy: Policy, problem: Problem, seeds: range, folder: Path = RUNS, *, split: str = EVERY, fresh: bool = False
) -> Evaluation:
    """Return the evaluation on some seeds; chunks cached with equal inputs are not run again.

    On another machine, a policy on measurements computes with the model; other policies know the machine.
    """
    simulation = problem.simulation()
    model, code = model_beside(problem) if policy.sees == "measurements" else None, code_of(policy, problem)
    chunks = []
    for first in range(0, len(seeds), CHUNK):
        part = seeds[first : first + CHUNK]
        path, fingerprint = cached_file(policy.name, code, problem, part, split, folder)
        result = None if fresh else read_cached(path, fingerprint)
        if result is None:
            result = run_seeds(policy, simulation, part, split, model)
            write_cached(path, fingerprint, result)
        chunks.append(result)
    return Evaluation.joined(chunks)


def code_of(policy: Policy, problem: Problem) -> str:
    """Return a fingerprint of a policy, its problem and its model."""
    model = model_beside(problem) if policy.sees == "measurements" else None
    simulation = problem.simulation()
    made_of = [sources(name) for name in (type(policy).__module__, reveal.__module__, *modules_of(simulation))]
    known = hashlib.sha256(f"{made_of} {behaviour(simulation)} {policy!r}".encode()).hexdigest()
    return known + ("" if model is None else behaviour(model))


def cached_file(name: str, code: str, problem: Problem, seeds: range, split: str, folder: Path) -> tuple[Path, str]:
    """Return the file of a chunk of episodes of a policy, and the fingerprint of its inputs."""
    place, drawn_from = folder / problem.name / "cells" / name, find_split(split)
    of_split = "" if drawn_from == SPLITS[EVERY] else f" {drawn_from}"
    return (place / split if of_split else place) / f"{seeds.start}.npz", f"{code} {seeds}{of_split}"


def read_cached(path: Path, fingerprint: str) -> Evaluation | None:
    """Return the evaluation in a file; None if the file is missing, damaged or has another fingerprint."""
    with suppress(OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile), np.load(path) as file:
        if str(file["fingerprint"]) == fingerprint:
            return Evaluation(*(file[each.name] for each in fields(Evaluation)))
    return None


def write_cached(path: Path, fingerprint: str, result: Evaluation) -> None:
    """Write an evaluation and its fingerprint in one atomic step."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.stem}.{os.getpid()}.npz")
    np.savez(partial, fingerprint=np.array(fingerprint), **asdict(result))
    partial.replace(path)


def behaviour(simulation: Simulation) -> str:
    """Return a hash of a problem's code and data, from its answers to a probe.

    A hash of the code would discard hours of planning for a comment. The reward is left out: results set its unit.
    """
    digest = hashlib.sha256()
    probe, state = Random(), start_episodes(simulation, episode_seeds("training", PROBES))
    probe.begin(simulation, PROBES)
    while not simulation.over(state).all():
        seen = simulation.observe(state)
        outcomes, results = advance(simulation, state, *probe.act(seen, None))
        for numbers in (seen, np.delete(outcomes, REWARD, axis=1), results):
            digest.update(numbers.tobytes())
    return digest.hexdigest()


def modules_of(simulation: Simulation) -> list[str]:
    """Return the modules of a simulation; the probe does not run all of their code, such as reading observations."""
    parts = simulation, simulation.branches, simulation.empty_episodes(0)
    return sorted({kind.__module__ for part in parts for kind in type(part).__mro__} - {object.__module__})


@cache
def sources(module: str, deciding: tuple[str, ...] = DECIDING) -> str:
    """Return a hash of the code of a module and its imports, without comments and docstrings."""
    digest = hashlib.sha256()
    for _, path in sorted(imported(module, deciding).items()):
        digest.update(bare(path.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()


def imported(module: str, deciding: tuple[str, ...] = DECIDING) -> dict[str, Path]:
    """Return the files of a module and of its direct and indirect imports in `deciding`, by module name."""
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        known = name in found or not (name == module or name.startswith(deciding))
        if known or (path := _file_of(name)) is None:
            continue
        found[name] = path
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                waiting += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found


def _file_of(module: str) -> Path | None:
    """Return the file of a module; None for another name."""
    if module in sys.modules:
        return Path(str(sys.modules[module].__file__))
    path = ROOT.joinpath(*module.split("."))
    return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()), None)


def bare(text: str) -> str:
    """Return the code of a module without imports, docstrings and comments."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [each for each in node.body if not ignored(each)] or [ast.Pass()]
    return ast.unparse(tree)


def ignored(node: ast.stmt) -> bool:
    """Return whether a statement is an import or a string."""
    return isinstance(node, ast.Import | ast.ImportFrom) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    )
