"""The form that the blocks of a task have."""

from grind_env.envs.form import G82, Form
from grind_env.envs.reciprocation.simulation import G81
from grind_env.envs.tasks import Task
from grind_env.envs.wide_plates.simulation import G83

FORMS = {form.cycle: form for form in (G81, G82, G83)}


def form_of(task: Task) -> Form:
    """The form of the blocks of a task, which follows from its cycle."""
    return FORMS[task.cycle]
