"""Recognise files of the adviser, so that no other file is replaced."""

import re

from grind_env.output_checks import HEAD, FileKind

LOG_COLUMNS = ("time", "block", "part", "advised_E", "advised_D", "E", "D")  #: first columns of a log
_VALUE = re.compile(rb"[ \t]*(?:(?:#[ \t]*\d+[ \t]*=[ \t]*[-+.\d]+[ \t]*(?:\([^()]*\))?|%|O\d+|M30|M99)[ \t]*)?")


STATE = FileKind("state of an adviser", re.compile(rb'\s*\{\s*"format"\s*:\s*\d+\s*,\s*"origin"\s*:').match)
LOG = FileKind("log of an adviser", re.compile(",".join(LOG_COLUMNS).encode()).match)
VALUES = FileKind(
    "file of values alone, such as #101=12000.",
    lambda head: len(head) < HEAD and all(_VALUE.fullmatch(line) for line in head.splitlines()),
)
