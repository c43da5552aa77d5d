"""View of a task: its kinds of block, its choices and its page."""

from grind_env.envs.tasks import Kind, Task
from grind_env.envs.tasks.schema import document, toml_text
from grind_env.notebook_views.markup import fragment, items, table
from grind_env.pages import page as page_of

HEADINGS = (
    "block",
    "material",
    "stock, mm",
    "pick, mm",
    "width, mm",
    "length, mm",
    "Ra limit, µm",
    "tolerance, µm",
    "rise limit, K",
    "scrap, $",
)


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
    rows = [_row(kind, task) for kind in task.kinds]
    return fragment(f"{task.name}: {task.title}", table(HEADINGS, rows, left=2), items(said))


def page(task: Task) -> Page:
    """Return the page of a task; for a user's task file, its content with all defaults."""
    if task.file:
        return Page(f"# {task.name}\n\n```toml\n{toml_text(document(task))}\n```\n")
    return Page(page_of(task.environment_id))


def _row(kind: Kind, task: Task) -> list[str]:
    asked = [f"{limit:g}" if limit > 0.0 else "" for limit in (kind.roughness_limit, kind.tolerance)]
    lengths = [f"{value:g}" for value in (kind.stock, kind.pick, kind.width, kind.length)]
    return [kind.name, kind.material, *lengths, *asked, f"{task.limits(kind).rise:g}", f"{kind.scrap:g}"]
