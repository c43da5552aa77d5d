"""Compile ahead of time by running the usual first steps of users."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import gymnasium as gym
import numpy as np

from grind_env import examples
from grind_env.errors import GrindError
from grind_env.kernel import compile_at_once
from grind_env.kernel.cache import cache_folder
from grind_env.machine.grind import grind_file
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import job_beside, load_job
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.optional_libraries import MissingExtra
from grind_env.pages.task_page_data import page_ids
from grind_env.process.force_correction import EXPONENTS
from grind_env.shop.python_api import optimise

BUDGET = 1.0  #: time of the search, s; its first runs compile all code that it needs
SPREAD = 0.02  #: spread of the exponents of `calibrated`; any other spread above 0 compiles the same code


def uses() -> dict[str, Callable[[], object]]:
    """Return all steps by name: run every example, step every environment and run a search; some of them calibrated."""
    programs = [examples.path(name) for name in examples.names()]
    first, search = programs[0], partial(optimise, budget=BUDGET)
    job = calibrated(load_job(job_beside(first)))
    return {
        **{f"grind run {program.name}": partial(grind_file, program) for program in programs},
        **{name: partial(step, name) for name in page_ids()},
        f"grind optimise {first.name}": partial(search, first),
        f"grind run {first.name}, calibrated": partial(grind_file, first, job),
        f"grind optimise {first.name}, calibrated": partial(search, first, job),
    }


def calibrated(job: Job) -> Job:
    """Return the job with uncertain exponents of depth, speed and volume, as after a calibration: other code."""
    names = tuple(f"material.{each}" for each in EXPONENTS)
    correlation = tuple(map(tuple, np.eye(len(names)).tolist()))
    return replace(
        job, uncertainty=Uncertainty(names=names, spread=(SPREAD,) * len(names), correlation=correlation, source="here")
    )


def step(name: str) -> None:
    """Make the environment of an id, alone and as a vector of two; reset both and make a step."""
    for env in (gym.make(name), gym.make_vec(name, num_envs=2)):
        env.reset(seed=0)
        env.step(env.action_space.sample())
        env.close()


def warm_up(steps: Mapping[str, Callable[[], object]]) -> Iterator[tuple[str, float, int, str]]:
    """Run the steps; yield the name, time, s, and number of new kernels of each, and the extra that it lacks."""
    folder = cache_folder()
    compile_at_once()
    for name, call in steps.items():
        begin, before = time.perf_counter(), kernels()
        try:
            call()
        except MissingExtra as error:
            yield name, 0.0, 0, str(error)
        else:
            yield name, time.perf_counter() - begin, kernels() - before, ""
    if not kernels():
        raise GrindError(
            f"no kernel is in {folder}: let it be written to, or name another by NUMBA_CACHE_DIR, and unset "
            "NUMBA_DISABLE_JIT"
        )


def kernels() -> int:
    """Return the number of kernels in the cache."""
    return len([*cache_folder().glob("*.nbc")])
