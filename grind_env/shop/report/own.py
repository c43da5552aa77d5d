"""The page of a run, by which `grind report` knows it again: it replaces no other that it was not told the name of."""

import re

from grind_env.targets import Own

TITLE = "Grinding report: "
PAGE = Own("page of `grind report`", re.compile(rb"(?s).*<title>" + TITLE.encode()).match)
