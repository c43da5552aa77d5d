"""View of a calibration: fitted constants, prediction errors, and how the files were read."""

from grind_env.notebook_views.markup import fragment, items, paragraphs, table
from grind_env.shop.calibrate.calibration_output import all_sentences, constants_table
from grind_env.shop.calibrate.figure import draw_calibration
from grind_env.shop.calibrate.result import Calibration

figure = draw_calibration


def html(found: Calibration) -> str:
    """Return the output of `grind calibrate` as HTML."""
    constants = constants_table(found)
    shown = table(constants.headings, constants.rows) if constants.rows else ""
    return fragment(f"Calibrated from {found.source}", shown, paragraphs(all_sentences(found)), items(found.remarks))
