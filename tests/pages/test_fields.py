"""The page of all fields, against the dataclasses."""

import re
from dataclasses import fields

import pytest

from grind_env.envs.tasks.reading import TABLES
from grind_env.envs.tasks.tables import Kind
from grind_env.machine.job import Diamond, Lots, Part, Setup, Stage, Times, WheelStart
from grind_env.pages.fields import fields_page
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.entries import Quantity, quantities

PAGE = fields_page()
JOB, CATALOGUE, TASK = (re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:])[:3]


def rows(text: str, heading: str) -> dict[str, list[str]]:
    """The cells of the first table under a heading, by their key."""
    part = text.partition(f"### {heading}\n")[2].partition("\n### ")[0]
    lines = [line for line in part.splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return {row[0].strip("`"): row[1:] for row in cells}


@pytest.mark.parametrize(
    ("heading", "table"),
    [
        ("[part]", Part),
        ("[[part.stages]]", Stage),
        ("[setup]", Setup),
        ("[times]", Times),
        ("[wheel]", WheelStart),
        ("[diamond]", Diamond),
        ("[lots]", Lots),
    ],
)
def test_every_field_of_a_job_has_unit_range_and_meaning(heading: str, table: type) -> None:
    found = rows(JOB, heading)
    for field in fields(table):
        if field.name == "stages":  # a table of its own
            continue
        unit, holds, default, meaning = found[field.name]
        quantity = next((each for each in getattr(field.type, "__metadata__", ()) if isinstance(each, Quantity)), None)
        assert default and meaning
        if quantity is not None:
            assert unit == (quantity.unit or "–") and str(quantity) in holds


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_of_a_catalogue_entry(kind: str) -> None:
    found = rows(CATALOGUE, f"[{kind}.NAME]")
    for key, legal in quantities(KINDS[kind]).items():
        cells = found[key]
        if isinstance(legal, Quantity):
            assert cells[:3] == [legal.symbol, legal.unit or "–", f"{legal.low:g} to {legal.high:g}"]
    for name, entry in getattr(load_catalogue(), f"{kind}s").items():
        assert entry.name == name and name in found


def test_every_field_of_a_task() -> None:
    for name, table in {**TABLES, "kind": Kind}.items():
        found = rows(TASK, f"[[{name}]]" if name == "kind" else f"[{name}]")
        assert {field.name for field in fields(table)} <= set(found)
