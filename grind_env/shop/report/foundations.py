"""What the numbers of every report rest on: revisions of files, values of the catalogue, and the reach of the model."""

import hashlib
from collections.abc import Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.files import read_bytes
from grind_env.machine.job import Job
from grind_env.shop.report.assumptions import changes
from grind_env.shop.report.document import items, paragraph, table
from grind_env.validation import unfit_uses

if TYPE_CHECKING:
    from markupsafe import Markup


def revisions(files: Mapping[str, Path]) -> dict[str, str]:
    """Names and revisions of files by what they are, and when the page was written."""
    facts = {}
    for name, path in files.items():
        changed = datetime.fromtimestamp(path.stat().st_mtime, timezone.utc)
        facts[name] = path.name
        facts[f"revision of the {name}"] = f"{_digest(path)}, {changed:%Y-%m-%d %H:%M} UTC"
    return facts | {"report written": f"{datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC"}


def foundations(job: Job) -> "list[Markup]":
    """What of a job differs from the built-in catalogue, and what the process model must not be used for."""
    found = changes(job)
    rows = [(each.entry, each.key, each.unit, each.here, each.known) for each in found]
    state = (
        "These values differ from the built-in catalogue; all others are its literature values."
        if found
        else "No value differs from the built-in catalogue: nothing is calibrated to this machine, wheel or material."
    )
    unfit = [f"{use}: {why}." for use, why in unfit_uses().items()]
    told = [paragraph(state)]
    if rows:
        told.append(table(("entry", "value", "unit", "here", "catalogue"), rows, left=3))
    return [*told, paragraph("What the process model must not be used for:"), items(unfit)]


def _digest(path: Path) -> str:
    return f"sha256 {hashlib.sha256(read_bytes(path)).hexdigest()[:16]}"
