"""View of a sweep: its tables of settings, and the best one."""

from grind_env.notebook_views.markup import fragment, paragraphs, table
from grind_env.shop.sweep.figure import draw_sweep
from grind_env.shop.sweep.study import Sweep
from grind_env.shop.sweep.table import sentences, tables_of
from grind_env.shop.trials import lots_text

figure = draw_sweep


def html(found: Sweep) -> str:
    """Return the output of `grind sweep` as HTML."""
    bodies = [paragraphs([shown.title]) + table(shown.headings, shown.rows, left=0) for shown in tables_of(found)]
    title = f"{found.program}, batches of {found.parts} {found.counted}s, {lots_text(found.lots)}"
    return fragment(title, *bodies, paragraphs(sentences(found)))
