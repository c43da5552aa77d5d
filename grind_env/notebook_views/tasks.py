"""View of a task: its kinds of block, its choices and its page."""

from grind_env.data_table import Column
from grind_env.envs.tasks import Task
from grind_env.envs.tasks.schema import document, toml_text
from grind_env.notebook_views.markup import fragment, items, table
from grind_env.pages import page as page_of


class Page(str):
    """A text in Markdown, which a notebook shows as a page."""

    __slots__ = ()

    def _repr_markdown_(self) -> str:
        return str(self)


def html(task: Task) -> str:
    """Return set-up, kinds of block and ranges of the actions of a task as HTML."""
    low, high = task.action.speed_ends
    setup, dress = task.setup, task.dress
    said = [
        f"{task.blocks} blocks of {task.cycle} an episode; {task.environment_id}",
        f"E from {low:g} to {high:g} mm/min, D from 0 to {task.action.executions}",
        f"wheel {setup.wheel}, {setup.wheel_speed:g} m/s when new; {setup.dresser}, {setup.fluid}, {setup.machine}",
        f"a dress is {dress.passes} passes of {dress.depth:g} mm with a lead of {dress.lead:g} mm a revolution, "
        f"{task.dress_seconds:.1f} s",
        "a reward of -1 is " + (f"{task.reference_cost:.4g} $" if task.reference_cost else "the cheapest fixed plan"),
    ]
    columns = (
        Column("block", "name"),
        Column("material", "material"),
        *(Column(f"{length}, mm", length, "g", right=True) for length in ("stock", "pick", "width", "length")),
        Column("Ra limit, µm", lambda kind: f"{kind.roughness_limit:g}" if kind.roughness_limit else "", right=True),
        Column("tolerance, µm", lambda kind: f"{kind.tolerance:g}" if kind.tolerance else "", right=True),
        Column("rise limit, K", lambda kind: task.limits(kind).rise, "g", right=True),
        Column("scrap, $", "scrap", "g", right=True),
    )
    return fragment(f"{task.name}: {task.title}", table(columns, task.kinds), items(said))


def page(task: Task) -> Page:
    """Return the page of a task; for a user's task file, its content with all defaults."""
    if task.file:
        return Page(f"# {task.name}\n\n```toml\n{toml_text(document(task))}\n```\n")
    return Page(page_of(task.environment_id))
