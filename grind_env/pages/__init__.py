"""Reference pages of the environments, written from the code for `make docs` and `grind tasks`."""

from grind_env.pages.notes import PageError
from grind_env.pages.page import page
from grind_env.pages.sheet import page_ids
from grind_env.pages.summary import TaskSummary, index, summaries, summary

__all__ = ["PageError", "TaskSummary", "index", "page", "page_ids", "summaries", "summary"]
