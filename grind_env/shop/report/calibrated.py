"""The report of a calibration: what `grind calibrate --report` writes."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.figure import comparable, comparison, named, residuals
from grind_env.shop.calibrate.result import Calibration, catalogue_text
from grind_env.shop.calibrate.show import error_sentences, kept_sentences, meter_sentences
from grind_env.shop.calibrate.solver import YES_OR_NO
from grind_env.shop.report.document import (
    Line,
    Part,
    Section,
    figure,
    items,
    listing,
    page,
    paragraph,
    table,
    verdict,
)
from grind_env.shop.report.foundations import foundations, revisions
from grind_env.table import Cell

if TYPE_CHECKING:
    from markupsafe import Markup

FEW = 5
"""Measurements of a kind from which on they are drawn."""


def calibrated_report(found: Calibration, files: Mapping[str, Path]) -> str:
    """The page of a calibration, HTML.

    Args:
        found: what it has found.
        files: by what they are, such as log and job; the page states their revisions.

    Raises:
        MissingExtra: as of `page`.
    """
    sections = [
        Section("Verdict", [_verdict(found)]),
        Section("Constants", [_constants(found)]),
        Section("Measured and modelled", _figures(found)),
        Section("Reading of the measurements", [items(_reading(found))]),
        Section("Catalogue file", _catalogue(found)),
        Section("What the numbers rest on", [items(_rests_on(found)), *foundations(found.fitted)]),
    ]
    return page(f"Calibrated: {found.source}", sections, revisions(files))


def _verdict(found: Calibration) -> "Markup":
    count = len(found.estimates)
    told = count - len(found.not_told)
    more = [f"The measurements tell {told} of {count} constants.", *error_sentences(found), *kept_sentences(found)]
    return verdict(found.verdict.level, found.verdict.headline, more)


def _constants(found: Calibration) -> "Markup":
    rows = [
        [
            f"{each.parameter.kind} {each.parameter.entry}",
            each.parameter.key,
            each.parameter.unit,
            f"{each.parameter.prior:.4g}",
            f"{each.value:.4g}",
            f"{each.low:.3g} to {each.high:.3g}",
            f"{100.0 * each.share:.0f}",
            Cell("told", "good") if each.told else "kept",
        ]
        for each in found.estimates
    ]
    headings = ("entry", "constant", "unit", "catalogue", "estimate", "90 % interval", "spread left, %", "state")
    caption = (
        "A constant is kept at the value of the catalogue where the measurements do not tell it. The spread left is "
        "that after measuring over that before."
    )
    return table(headings, rows, caption, left=3)


def _figures(found: Calibration) -> "list[Part]":
    whole = "part" if found.program else "setting"
    said = [
        "Grey rings are the catalogue as it was, blue points the fit, red crosses were left out; on the line the model "
        f"is right. Residuals are measured less modelled, each {whole}'s in order of time, those of every second "
        f"{whole} orange squares."
    ]
    if YES_OR_NO in found.data.kinds:
        said.append("Burn, which is yes or no, is not drawn.")
    drawn: list[Part] = [paragraph(" ".join(said))]
    few = np.zeros(found.data.value.size, np.bool_)
    for kind in found.data.kinds:
        chosen = comparable(found, kind)
        if kind != YES_OR_NO and chosen.sum() < FEW:
            few |= chosen
        elif kind != YES_OR_NO:
            drawn.append(figure(comparison(found, kind), f"Measured over modelled {kind}"))
            drawn.append(figure(residuals(found, kind), f"Residuals of {kind} over {whole}s"))
    return [*drawn, _table(found, few)] if few.any() else drawn


def _table(found: Calibration, chosen: NDArray[np.bool_]) -> "Markup":
    """Measurements that are too few for a figure."""
    rows = [
        [
            f"{named(str(found.data.kind[k]))}, {found.label[k]}",
            f"{found.data.value[k]:.3g}",
            f"{found.fit.predicted[k]:.3g}",
            f"{found.fit.nominal[k]:.3g}",
            "" if found.fit.used[k] else Cell("left out", "poor"),
        ]
        for k in np.flatnonzero(chosen).tolist()
    ]
    return table(("measurement", "measured", "fit", "catalogue", ""), rows)


def _reading(found: Calibration) -> list[str]:
    said = []
    if not math.isnan(found.quality):
        said.append(
            f"The strokes of {found.program} stand in the log with a median correlation of {found.quality:.3f}."
        )
        said.append("Strokes have means of their own." if found.by_stroke else "Strokes have no means of their own.")
    return [*said, *meter_sentences(found), *found.remarks]


def _catalogue(found: Calibration) -> "list[Markup]":
    if found.tells_nothing:
        return [paragraph("There is none: nothing was found that could stand in it.")]
    return [listing([Line(str(k), text) for k, text in enumerate(catalogue_text(found).splitlines(), 1)])]


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
