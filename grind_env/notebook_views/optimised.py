"""View of an optimisation: varied values, both programs side by side, limits and verdict."""

from grind_env.notebook_views.markup import fragment, paragraphs, table
from grind_env.shop.optimise.result import Optimised
from grind_env.shop.optimise.tables import heading, sentences, tables_of


def html(found: Optimised) -> str:
    """Return the output of `grind optimise` as HTML."""
    tables = [table(shown.headings, shown.rows) for shown in tables_of(found)]
    return fragment(heading(found), *tables, paragraphs(sentences(found)))
