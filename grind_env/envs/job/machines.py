"""Machines that may be that of a job, in numbers: episodes run on one of them each."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grind_env.arrays import Table
from grind_env.envs.job.outline import BlockOutline
from grind_env.machine.dress.mounting import first_wheel
from grind_env.machine.job import Job


class Machines(NamedTuple):
    """M machines of one process, which may be another one than that of the job."""

    jobs: tuple[Job, ...]
    base: Table
    """Parameters, shape (M, 1 or blocks, fields of `StrokeParameters`)."""
    cooler: Table
    """By how much the limits of temperature lie above those of the first job, K, shape (M, 1 or blocks)."""
    starts: Table
    """Wheel as the first block finds it, and what the process remembers then, shape (M, fields of both)."""


def machines_of(jobs: Sequence[Job], blocks: Sequence[BlockOutline], nominal: Job) -> Machines:
    """The numbers of some jobs that differ from a nominal one in their entries, for the blocks of its program."""
    limits = _rises(nominal, blocks)
    return Machines(
        jobs=tuple(jobs),
        base=np.array([[each.parameters for each in _by_block(job, blocks)] for job in jobs]),
        cooler=np.array([np.subtract(_rises(job, blocks), limits) for job in jobs]),
        starts=np.array([_start(job, blocks[0]) for job in jobs]),
    )


def _by_block(job: Job, blocks: Sequence[BlockOutline]) -> list[Job]:
    """The job of each block where its parts may differ, or the one of all."""
    return [job.of_part(block.part + 1) for block in blocks] if job.stations else [job]


def _rises(job: Job, blocks: Sequence[BlockOutline]) -> list[float]:
    return [each.limits.rise for each in _by_block(job, blocks)]


def _start(job: Job, first: BlockOutline) -> tuple[float, ...]:
    return *first_wheel(job, first.dress, job.of_part(first.part + 1).parameters), *job.own_at_start
