"""The report of a calibration, which `grind calibrate --report` writes."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.data_table import Cell, Column, table_of
from grind_env.shop.calibrate.calibration_output import COLUMNS, error_sentences, kept_sentences, meter_sentences
from grind_env.shop.calibrate.figure import comparable, comparison, residuals
from grind_env.shop.calibrate.least_squares import YES_OR_NO
from grind_env.shop.calibrate.result import Calibration, catalogue_text
from grind_env.shop.report.document import Section, figure, items, listing, page, paragraph, table, verdict
from grind_env.shop.report.provenance import foundations, revisions

if TYPE_CHECKING:
    from markupsafe import Markup


def calibrated_report(found: Calibration, files: Mapping[str, Path]) -> str:
    """Return the page of a calibration, HTML."""
    none = [paragraph("None: the measurements determine no constant.")]
    sections = [
        Section("Verdict", [_verdict(found)]),
        Section("Constants", [_constants(found)]),
        Section("Measured and modelled", _figures(found)),
        Section("Reading of the measurements", [items(_reading(found))]),
        Section("Catalogue file", none if found.tells_nothing else listing(catalogue_text(found).splitlines())),
        Section("What the numbers rest on", [items(_rests_on(found)), *foundations(found.fitted)]),
    ]
    return page(f"Calibrated: {found.source}", sections, revisions(files))


def _verdict(found: Calibration) -> "Markup":
    count = len(found.estimates)
    known = count - len(found.undetermined)
    more = [f"The measurements tell {known} of {count} constants.", *error_sentences(found), *kept_sentences(found)]
    return verdict(found.verdict.level, found.verdict.headline, more)


def _constants(found: Calibration) -> "Markup":
    state = Column("state", lambda each: Cell("told", "good") if each.determined else Cell("kept"))
    caption = "Kept: the measurements do not determine the constant. Spread left: after the fit, in % of that before."
    return table(table_of((*COLUMNS, state), found.estimates), caption)


def _figures(found: Calibration) -> "list[Markup]":
    whole = "part" if found.program else "setting"
    said = [
        "Grey rings: catalogue; blue points: fit; red crosses: left out. On the line the model is exact. Residuals are "
        f"measured minus modelled values, in order of time; those of every second {whole} are orange squares."
    ]
    if YES_OR_NO in found.data.kinds:
        said.append("Burn, which is yes or no, is not drawn.")
    drawn = [paragraph(" ".join(said))]
    for kind in found.data.kinds:
        if kind != YES_OR_NO and comparable(found, kind).any():
            drawn.append(figure(comparison(found, kind), f"Measured over modelled {kind}"))
            drawn.append(figure(residuals(found, kind), f"Residuals of {kind} over {whole}s"))
    return drawn


def _reading(found: Calibration) -> list[str]:
    said = []
    if not math.isnan(found.quality):
        said.append(
            f"The strokes of {found.program} stand in the log with a median correlation of {found.quality:.3f}."
        )
        said.append("Strokes have means of their own." if found.by_stroke else "Strokes have no means of their own.")
    return [*said, *meter_sentences(found), *found.remarks]


def _rests_on(found: Calibration) -> list[str]:
    out = int((~found.fit.used).sum())
    enlarged = [f"{kind} by {factor:.2g}" for kind, factor in found.fit.factors.items() if factor > 1.0]
    return [
        "Constants are the most probable ones, given the measurements and how uncertain the catalogue is before them; "
        "intervals take the posterior for normal around these.",
        f"{found.data.value.size} measurements, of which {out} were left out as outliers or without a value.",
        "Errors of measurements were enlarged until residuals agree with them: " + ", ".join(enlarged) + "."
        if enlarged
        else "Residuals agree with the errors of the measurements.",
    ]
