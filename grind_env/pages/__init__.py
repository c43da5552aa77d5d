"""Reference pages of the environments, written from the code for `make docs` and `grind tasks`."""

from grind_env.pages.task_notes import PageError
from grind_env.pages.task_page import page
from grind_env.pages.task_sheet import page_ids
from grind_env.pages.task_summary import TaskSummary, index, summaries, summary

__all__ = ["PageError", "TaskSummary", "index", "page", "page_ids", "summaries", "summary"]
