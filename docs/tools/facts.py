"""Page of the facts of the control, made from `grind_env/control/facts.toml`."""

import re
from collections.abc import Iterator

from grind_env.control.facts import FILE, MARKS, Fact, load_facts
from grind_env.data_table import table_of

INTRODUCTION = """\
# Facts of the control

This list describes what the simulated control does; `grind facts` prints the same list. Page numbers are those of the
grinder manual 8520-GUM. A prefix marks a page of another manual: L lathe, M mill, AMP the AMP reference, OCI the
operator interface.

A **seen** statement is on the page, an **inferred** one follows from the page. **DECIDED** marks a choice of this
project where the manuals are silent or contradict each other; look there first if your own machine behaves
differently. Every statement names the tests that check it, or says why the simulator leaves it out."""
HEADING = re.compile(r"^# --- (.+)$|^id = \"(.+)\"$", re.MULTILINE)


def facts_page() -> str:
    """Return the Markdown page: a table for each section of the file."""
    known = {fact.id: fact for fact in load_facts()}
    count = ", ".join(f"{sum(fact.mark == mark for fact in known.values())} {mark}" for mark in MARKS)
    parts = [INTRODUCTION, f"{len(known)} statements: {count}."]
    for heading, ids in _sections():
        shown = table_of(("", "mark", "statement"), [_cells(known[each]) for each in ids])
        parts += [f"## {heading}", shown.markdown()]
    return "\n\n".join(parts) + "\n"


def _sections() -> Iterator[tuple[str, list[str]]]:
    """Yield the headings, which are comments in the file, with the facts below them."""
    heading, ids = "", list[str]()
    for match in HEADING.finditer(FILE.read_text(encoding="utf-8")):
        if match[1] is None:
            ids.append(match[2])
            continue
        if ids:
            yield heading, ids
        heading, ids = match[1].partition(", one of the four")[0], []
    yield heading, ids


def _cells(fact: Fact) -> tuple[str, str, str]:
    held = f"outside: {fact.outside}" if fact.outside else ", ".join(f"`{test}`" for test in fact.tests)
    mark = "**DECIDED**" if fact.mark == "decided" else fact.mark
    page = f"page {fact.page}" if fact.page and not fact.id.startswith(fact.page) else ""
    return f"`{fact.id}` {page}".strip(), mark, f"{fact.text} <br><small>{held}</small>"
