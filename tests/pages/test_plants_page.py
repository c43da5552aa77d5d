"""The page of the machines that are not the model."""

import re

from grind_env.pages.plants import plants_page
from grind_env.plants import FAMILIES, find_plant


def test_it_has_every_family_with_every_number_and_its_source() -> None:
    page = plants_page()
    assert re.findall(r"^## (.+)$", page, re.MULTILINE) == [family.name for family in FAMILIES]
    span = r"(\S+) to (\S+?)(?:; held out (\S+) to (\S+?))?(, factor)?"
    rows = re.findall(rf"^\| `(\w+)` \| (.+) \| (.+) \| {span} \| (\w+): (.+) \|$", page, re.MULTILINE)
    ranges = [each for family in FAMILIES for each in family.ranges]
    assert [row[0] for row in rows] == [each.field for each in ranges]
    for row, each in zip(rows, ranges, strict=True):
        assert (float(row[3]), float(row[4]), bool(row[7])) == (each.low, each.high, each.factor)
        assert (float(row[5]), float(row[6])) == each.held_out if each.held_out else not row[5]
        assert (row[8], row[9]) == (each.basis.evidence.name.lower(), each.basis.text)


def test_the_names_that_it_gives_are_names() -> None:
    named = re.findall(r"^\| `([\w+:-]+)` \|", plants_page(), re.MULTILINE)
    assert len([find_plant(name) for name in named if not name.startswith("module:") and ":" in name]) == 7
