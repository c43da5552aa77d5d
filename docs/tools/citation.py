"""BibTeX entry of the package, made from `CITATION.cff`."""

import re
from pathlib import Path
from typing import Any

import yaml


def read_citation(path: Path) -> dict[str, Any]:
    """Return the content of the file by its keys."""
    found: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return found


def bibtex(cited: dict[str, Any], licence: str) -> str:
    """Return a BibTeX entry. Before a release, its year is that of the licence. Organisations are in braces."""
    (year,) = re.findall(r"Copyright \(c\) (\d{4})", licence)
    authors = " and ".join(_author(each) for each in cited["authors"])
    fields = {
        "author": authors,
        "title": f"{{{cited['title']}}}",
        "version": cited["version"],
        "year": str(cited.get("date-released", year))[:4],
        "doi": cited.get("doi", ""),
        "url": cited.get("repository-code", ""),
        "license": cited["license"],
    }
    lines = [f"  {name} = {{{text.replace('_', chr(92) + '_')}}},\n" for name, text in fields.items() if text]
    return f"@software{{grind_env,\n{''.join(lines)}}}\n"


def _author(person: dict[str, str]) -> str:
    return f"{{{person['name']}}}" if "name" in person else f"{person['family-names']}, {person['given-names']}"
