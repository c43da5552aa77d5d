"""View of a record: parts, totals, exceeded limits and warnings."""

from typing import TYPE_CHECKING

from grind_env.machine.record import GrindingRecord
from grind_env.notebook_views.markup import fragment, items, paragraphs, table
from grind_env.render.block_comparison import HEADINGS, compared_blocks, compared_dresses
from grind_env.render.record_plots import draw_record
from grind_env.render.record_tables import faults, part_table, totals

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def html(record: GrindingRecord) -> str:
    """Return the output of `grind run` as HTML."""
    parts = part_table(record)
    found = faults(record)
    return fragment(
        record.programs.name,
        table(parts.headings, parts.rows),
        table(HEADINGS, compared_blocks(record)),
        paragraphs(compared_dresses(record)),
        paragraphs([totals(record)]),
        "".join(
            paragraphs([fault.sentence], bad=True) + paragraphs([fault.why] if fault.why else []) for fault in found
        ),
        items([f"warning: {warning}" for warning in record.warnings]),
    )


def figure(record: GrindingRecord) -> "Figure":
    """Return the figure of `grind run --plot`."""
    return draw_record(record, record.programs.name)
