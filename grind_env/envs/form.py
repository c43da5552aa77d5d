"""What differs between environments whose step is one block: how it is simulated, and how a program says it."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from grind_env.envs.program import CycleBlock, block_text, part_program
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, TaskError, load_task

CYCLES = ("G82", "G83")
"""The cycles that take off a given depth from parts that the wheel covers, and from wider ones."""


class Form(NamedTuple):
    """The form of the blocks of an environment."""

    load: Callable[[str], Task]
    """Task of a name."""
    simulation: type[Simulation]
    """Steps its episodes."""
    text: Callable[[Task, CycleBlock], str]
    """What the control reads for one step."""
    program: Callable[[Task, Sequence[CycleBlock]], str]
    """The part program of an episode."""


G82 = Form(load_task, Simulation, block_text, part_program)
"""A step is one G82 cycle block."""


def check_cycle(task: Task, cycle: str) -> None:
    """Refuse a cycle that does not suit the parts of a task.

    Args:
        task: the task.
        cycle: `"G82"`, which plunges with the wheel across the whole part, or `"G83"` with cross picks.

    Raises:
        TaskError: there is no such cycle, a part is wider than the wheel under G82, or one is not under G83.
    """
    if cycle not in CYCLES:
        raise TaskError(f"cycle is {cycle!r}, but must be one of {', '.join(CYCLES)}")
    wheel = task.wheel.width
    for kind in task.kinds:
        sizes = f"a {kind.name} of {task.name} is {kind.width:g} mm wide, the wheel {wheel:g} mm"
        if cycle == "G82" and kind.width > wheel:
            raise TaskError(f"{sizes}: a G82 grinds only one strip of it; use cycle='G83'")
        if cycle == "G83" and kind.width <= wheel:
            raise TaskError(f"{sizes}: a G83 has no strip to cross to; use cycle='G82'")
