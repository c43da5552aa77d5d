"""All ids at a glance, for `grind tasks` and the index of the pages."""

import math
from dataclasses import dataclass

from grind_env.data_table import Column, table_of
from grind_env.envs.actions import ACTIONS
from grind_env.pages.task_page_data import page_ids, sheet
from grind_env.score_scale import find_reference, normalise


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskSummary:
    """An id in one row; None stands for a missing lower bound of the reward and for a missing score."""

    id: str
    title: str
    steps: int
    actions: tuple[str, ...]
    observation: int
    full: int
    reward: tuple[float | None, float]
    hard: str
    scripted: float | None


def summary(env_id: str) -> TaskSummary:
    """Return the row of a registered id.

    Raises:
        PageError: the id is not registered or has no notes.
    """
    about = sheet(env_id)
    known = find_reference(about.id)
    return TaskSummary(
        id=about.id,
        title=about.title,
        steps=about.steps,
        actions=ACTIONS,
        observation=len(about.readings),
        full=len(about.full),
        reward=(about.reward.least if math.isfinite(about.reward.least) else None, about.reward.most),
        hard=about.note.hard,
        scripted=None if known is None else round(normalise(about.id, known.returns[known.best_scripted].value), 3),
    )


def summaries() -> list[TaskSummary]:
    """Return the rows of all registered ids."""
    return [summary(env_id) for env_id in page_ids()]


def file_name(env_id: str) -> str:
    """Return the file name of a page: `Rush-v0.md` for `grind/Rush-v0`."""
    return f"{env_id.removeprefix('grind/')}.md"


def index() -> str:
    """Return the index of the pages, Markdown."""
    columns = (
        Column("id", lambda each: f"[{each.id}]({file_name(each.id)})"),
        Column("job", "title"),
        Column("steps", lambda each: each.steps or "-"),
        Column("actions", lambda each: ", ".join(each.actions)),
        Column("observation", "observation"),
        Column("difficulty", "hard"),
    )
    judged = "How the process model under them compares with measured grinding: [validation](validation.md)."
    written = "What may stand in the files of a job, a catalogue and a task: [fields](fields.md)."
    return f"# Environments\n\n{table_of(columns, summaries()).markdown()}\n\n{written}\n\n{judged}\n"
