"""Every command says what it does, shows an example, is shown on a page, and is run by a test."""

import re
from pathlib import Path

import pytest

from tests.test_outputs import TREE

ROOT = Path(__file__).parents[1]
PAGES = "".join(path.read_text() for path in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
TESTS = "".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.py"))


@pytest.mark.parametrize("name", TREE)
def test_a_command_is_told_shown_and_tested(name: str) -> None:
    click, (_, *words) = TREE[name].click, TREE[name].words
    assert click.help
    assert click.epilog and name in click.epilog
    assert f"{name}`" in PAGES or f"{name} " in PAGES or f"{name}\n" in PAGES
    # the first word of what is run: a key such as outcomes["cost"] is none
    assert re.search(rf"""[(,] ?\[?\*?["'](agents |grind )?{words[0]}["' ]""", TESTS)
