"""Reference pages of the environments, written from the code for `make docs` and `grind tasks`."""

from grind_env.pages.task_index import TaskSummary, index, summaries, summary
from grind_env.pages.task_notes import PageError
from grind_env.pages.task_page import page
from grind_env.pages.task_page_data import page_ids

__all__ = ["PageError", "TaskSummary", "index", "page", "page_ids", "summaries", "summary"]
