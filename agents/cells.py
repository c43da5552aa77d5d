"""Evaluations that are kept.

They are run once, in chunks of episodes, and taken up again while nothing that decides has changed.
"""

import ast
import hashlib
import os
import sys
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, fields
from functools import cache
from pathlib import Path

import numpy as np

from agents.provenance import ROOT
from grind_env.envs.contexts import SPLITS
from grind_env.envs.rows import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.evaluation import Evaluation, episode_seeds, evaluate, split_of, start_episodes
from grind_env.policies.policy import Policy
from grind_env.policies.scripted.rules import Random

RUNS = ROOT / "runs"
"""Folder of what is kept."""
RESULTS = ROOT / "agents" / "results"
"""The checked-in results."""
CHUNK = 64
"""Episodes evaluated at once. A planner may share random moves among them, so the chunks are part of its result."""
PROBES = 4
REWARD = Outcome._fields.index("reward")
DECIDING = ("agents.", "grind_env.policies.")
"""Where policies lie, and what trains them."""
UNPROBED = tuple(
    f"grind_env.{name}"
    for name in ("envs.belief", "envs.belief_kernel", "envs.belief_rows", "envs.memory", "kernel.layers")
)
"""Modules that decide what a policy sees or does, and that the probe of a task does not run."""
RANGES_OF = {"test": SPLITS["test"]}
"""What the contexts of a split of seeds are drawn from, where it is not everything."""

Advance = Callable[[int], object]


def kept_evaluation(
    policy: Policy,
    task: Task,
    seeds: range,
    folder: Path = RUNS,
    *,
    fresh: bool = False,
    advance: Advance = lambda episodes: None,
) -> Evaluation:
    """The evaluation of the seeds: every chunk that is kept of the same policy, code and task, the others anew.

    Args:
        policy: the policy; its repr tells its parameters.
        task: the task.
        seeds: of the episodes.
        folder: chunks are kept below, in `<task>/cells/<policy>/<first seed>.npz`.
        fresh: run also what is kept.
        advance: called with the number of episodes of each chunk that is done.
    """
    place = folder / task.name / "cells" / policy.name
    code = hashlib.sha256(f"{sources(type(policy).__module__)} {behaviour(task)} {policy!r}".encode()).hexdigest()
    drawn_from = RANGES_OF.get(split_of(seeds.start))
    chunks = []
    for first in range(0, len(seeds), CHUNK):
        part = seeds[first : first + CHUNK]
        path, fingerprint = place / f"{part.start}.npz", f"{code} {part}" + (f" {drawn_from}" if drawn_from else "")
        result = None if fresh else kept(path, fingerprint)
        if result is None:
            result = evaluate(policy, task, part)
            keep(path, fingerprint, result)
        chunks.append(result)
        advance(len(part))
    return Evaluation(*(np.concatenate([getattr(chunk, each.name) for chunk in chunks]) for each in fields(Evaluation)))


def kept(path: Path, fingerprint: str) -> Evaluation | None:
    """The evaluation in a file; None if the file is missing, damaged or of something else."""
    with suppress(OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile), np.load(path) as file:
        if str(file["fingerprint"]) == fingerprint:
            return Evaluation(*(file[each.name] for each in fields(Evaluation)))
    return None


def keep(path: Path, fingerprint: str, result: Evaluation) -> None:
    """Write the evaluation, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.stem}.{os.getpid()}.npz")
    np.savez(partial, fingerprint=np.array(fingerprint), **asdict(result))
    partial.replace(path)


def behaviour(task: Task) -> str:
    """Stands for the code and the data of a task: a hash of what it answers to a probe.

    A hash of the code would throw away hours of planning for a comment. The reward is left out, because it is in
    units of the reference cost, which is measured with the very evaluations that are kept.
    """
    digest = hashlib.sha256()
    simulation = Simulation(task)
    probe, state = Random(), start_episodes(simulation, episode_seeds("training", PROBES))
    probe.begin(task, PROBES)
    for _ in range(task.blocks):
        seen = simulation.observe(state)
        outcomes, results = simulation.step(state, *probe.act(seen, None))
        for numbers in (seen, np.delete(outcomes, REWARD, axis=1), results):
            digest.update(numbers.tobytes())
    return digest.hexdigest()


@cache
def sources(module: str) -> str:
    """Hash of the code of a module and of those that it stands on, comments and docstrings left out."""
    digest = hashlib.sha256()
    for name in sorted(imported(module)):
        digest.update(bare(Path(str(sys.modules[name].__file__)).read_text(encoding="utf-8")).encode())
    return digest.hexdigest()


def imported(module: str) -> set[str]:
    """Names of the modules that a module stands on, its own among them: those of `DECIDING`, and `UNPROBED`.

    What else of `grind_env` decides, `behaviour` sees.
    """
    found: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found or name not in sys.modules or not (name.startswith(DECIDING) or name in UNPROBED):
            continue
        found.add(name)
        tree = ast.parse(Path(str(sys.modules[name].__file__)).read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                waiting += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found


def bare(text: str) -> str:
    """The code of a module without imports, docstrings and comments, which decide nothing."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            node.body = [each for each in node.body if not ignored(each)] or [ast.Pass()]
    return ast.unparse(tree)


def ignored(node: ast.stmt) -> bool:
    """Whether a statement is an import or a string."""
    return isinstance(node, ast.Import | ast.ImportFrom) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    )
