"""What differs between environments whose step is one block: how it is simulated, and how a program says it."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from grind_env.envs.program import block_text, coming_block, part_program
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, TaskError, load_task
from grind_env.envs.view import view_of
from grind_env.render.view import View

CYCLES = ("G82", "G83")
"""The cycles that take off a given depth from parts that the wheel covers, and from wider ones."""


class Form(NamedTuple):
    """The form of the blocks of an environment."""

    cycle: str
    """The cycle of the blocks."""
    load: Callable[[str], Task]
    """Task of a name."""
    simulation: type[Simulation]
    """Steps its episodes."""
    text: Callable[[Task, Any], str]
    """What the control reads for one step, from what `block` says of it."""
    program: Callable[[Task, Sequence[Any]], str]
    """The part program of an episode."""
    block: Callable[..., Any] = coming_block
    """What there is to say of a step, before it: of a task, episodes, the number of one, and what was chosen for it."""
    view: Callable[..., View] = view_of
    """What a picture of an episode shows; arguments as for `view_of`."""


G82 = Form("G82", load_task, Simulation, block_text, part_program)
"""A step is one G82 cycle block."""


def check_cycle(form: Form, task: Task, cycle: str | None) -> None:
    """Check that the task and the requested cycle suit the form.

    Args:
        form: of the blocks.
        task: the task.
        cycle: as asked for; None for that of the form.

    Raises:
        TaskError: there is no such cycle, it is not that of the form, or it does not suit the width of a part.
    """
    asked = form.cycle if cycle is None else cycle
    if asked not in (*CYCLES, form.cycle):
        raise TaskError(f"cycle is {asked!r}, but must be one of {', '.join(CYCLES)}")
    check_width(task, asked)
    if asked != form.cycle:
        raise TaskError(
            f"cycle is {asked!r}, but the blocks of this environment are {form.cycle}: leave it out, or make "
            "grind/WidePlates-v0 for G83"
        )


def check_width(task: Task, cycle: str) -> None:
    """Check that a cycle suits the width of the parts of a task.

    Args:
        task: the task.
        cycle: G82 plunges with the wheel across the whole part, G83 needs a wider one for its cross picks.

    Raises:
        TaskError: a part is wider than the wheel under G82, or one is not under G83.
    """
    wheel = task.wheel.width
    for kind in task.kinds:
        sizes = f"a {kind.name} of {task.name} is {kind.width:g} mm wide, the wheel {wheel:g} mm"
        if cycle == "G82" and kind.width > wheel:
            raise TaskError(f"{sizes}: a G82 grinds only one strip of it; WidePlatesEnv grinds it with cycle='G83'")
        if cycle == "G83" and kind.width <= wheel:
            raise TaskError(f"{sizes}: a G83 has no strip to cross to; GrindEnv grinds it with cycle='G82'")
