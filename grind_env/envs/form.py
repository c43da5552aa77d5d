"""What differs between environments whose step is one block: how it is simulated, and how a program says it."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from grind_env.envs.blocks.program import block_text, coming_block, job, job_of_kinds, part_program
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, TaskError
from grind_env.envs.view import view_of
from grind_env.errors import quoted
from grind_env.machine.job import Job
from grind_env.render.view import View

CYCLES = ("G81", "G82", "G83")
"""The cycles of blocks: with an infeed of the program, with plunge picks, and with cross picks on wider parts."""


class Form(NamedTuple):
    """The form of the blocks of an environment."""

    cycle: str
    """The cycle of the blocks."""
    simulation: type[Simulation]
    """Steps its episodes."""
    text: Callable[[Task, Any], str]
    """What the control reads for one step, from what `block` says of it."""
    program: Callable[[Task, Sequence[Any]], str]
    """The part program of an episode."""
    block: Callable[..., Any] = coming_block
    """What there is to say of a step, before it: of a task, episodes, the number of one, and what was chosen for it."""
    job: Callable[[Task, Sequence[Any]], Job] = job_of_kinds
    """The job of that program, for nominal parts and a new wheel."""
    view: Callable[..., View] = view_of
    """What a picture of an episode shows; arguments as for `view_of`."""


G82 = Form("G82", Simulation, block_text, part_program)
"""A step is one G82 cycle block."""


def check_task(task: Task, cycle: str | None = None) -> None:
    """Check that the program of a task can be run, and that its blocks have the cycle asked for; None asks for none.

    Raises:
        TaskError: there is no such cycle, it is not that of the task, or its dresses leave no time for their program.
    """
    try:
        job(task, task.kinds[0])
    except TaskError as error:
        raise TaskError(error.message, error.key, error.found, error.legal, task.file) from None
    if cycle is None:
        return
    if cycle not in CYCLES:
        raise TaskError(f"cycle is {quoted(cycle)}, but must be one of {', '.join(CYCLES)}")
    if cycle != task.cycle:
        raise TaskError(f"cycle is {cycle!r}, but the blocks of {task.name} are {task.cycle}: leave it out")
