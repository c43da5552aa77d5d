"""Runs every entry as plain Python and compiled, on the same arguments: `python -m tests.kernel.both_tiers`.

The script prints module and name of each entry that has run. A fresh process is needed: no entry is compiled there.
"""

import copy
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import gymnasium as gym
import numpy as np
from numba.core.registry import CPUDispatcher

from grind_env import examples
from grind_env.control import read
from grind_env.envs.actions import ActionError
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.errors import GrindError
from grind_env.kernel.dispatch import WRITTEN, Entry, as_written
from grind_env.machine.grind import grind_file
from grind_env.machine.script.block_settings import DRESS_DEPTH, D, E
from grind_env.plants.plant_names import find_plant
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scoring import evaluate
from grind_env.process.catalogue import load_catalogue
from grind_env.shop.kernel_warm_up import step
from grind_env.validation import CHECKS, Rig, row_of
from tests.machine.harness import DRESS, job
from tests.soak.found import FOUND, PLAIN

FORMS = "grind/PowerLimited-v0", "grind/Reciprocation-v0", "grind/WidePlates-v0", "grind/Job-v0"
POLICIES = "power_threshold", "belief_rule"


def values(tree: Any) -> Iterator[bytes]:
    """Yield the bits of nested tuples of numbers and arrays."""
    if isinstance(tree, tuple):
        for each in tree:
            yield from values(each)
    elif tree is not None:
        yield np.asarray(tree).tobytes()


def call(self: Any, *args: Any) -> Any:
    """Run an entry in both tiers and require the same bits; this function replaces `Entry.__call__`."""
    copied = copy.deepcopy(args)
    with np.errstate(all="ignore"):
        plain = as_written(self)(*copied)
    compiled = CPUDispatcher.__call__(self, *args)
    assert list(values((plain, copied))) == list(values((compiled, args))), self.py_func
    return compiled


def main() -> None:
    """Call every entry through environments, example programs, jobs, policies and validation checks."""
    for name in FORMS:
        step(name)
    env = gym.make("grind/Reciprocation-v0")
    env.reset(seed=0)
    with suppress(ActionError):
        env.step(np.full(2, np.nan))
    simulation: Any = env.unwrapped.simulation
    simulation.writer.text(simulation.writer.block(simulation.start([np.random.default_rng(0)]), 0, 12_000.0, 0.0))
    for name in examples.names():
        grind_file(examples.path(name))
    for text, shop in FOUND.values():
        with suppress(GrindError):
            run_through(JobSimulation(read(text + DRESS), shop, 0.0))
    run_through(JobSimulation(read(PLAIN + DRESS), job().on(find_plant("drift:1")), 0.0))
    for name in POLICIES:
        evaluate(name, find_problem("oracle6"), seeds="validation", episodes=2)
    evaluate("robust", find_problem("power_limited"), seeds="validation", episodes=2)
    rig = Rig(load_catalogue())
    for check in {check.group: check for check in CHECKS}.values():
        row_of(check, rig)
    for function in WRITTEN:
        if hasattr(function, "_cache"):
            print(function.py_func.__module__, function.py_func.__name__)


def run_through(simulation: JobSimulation) -> None:
    """Step a program to its end, with another dress depth where the depth can be chosen."""
    episodes = simulation.start([np.random.default_rng(0)])
    for block in simulation.blocks:
        choice = np.array([block.plan.feed]), np.array([float(block.plan.dresses)])
        settings = simulation.own_settings(episodes) if simulation.compiled else None
        if settings is not None:
            settings[:, E], settings[:, D] = choice
            settings[:, DRESS_DEPTH] *= 1.5
        simulation.step(episodes, *choice, settings=settings)


if __name__ == "__main__":
    Entry.__call__ = call
    main()
