"""View of a part program: its text with line numbers."""

import itertools

from grind_env.control import Programs
from grind_env.control.program_scanner import readable
from grind_env.notebook_views.markup import MOST_LINES, fragment, listing


def html(programs: Programs) -> str:
    """Return the first lines of the main program's file as HTML."""
    with programs.main.blocks.text.open() as handle:
        head = [data.decode("utf-8-sig", errors="surrogateescape") for data in itertools.islice(handle, MOST_LINES)]
        more = sum(1 for _ in handle)
    return fragment(programs.name, listing([readable(line).rstrip("\r\n") for line in head], more))
