"""Every command says what it does, shows an example, is shown on a page, and is run by a test."""

import re
from pathlib import Path

import pytest
from typer import Context

from tests.test_outputs import TREE

FITS = ("run", "optimise", "sweep", "calibrate", "advise", "report", "train", "init")
ROOT = Path(__file__).parents[1]
PAGES = "".join(path.read_text() for path in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
TESTS = "".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.py"))


@pytest.mark.parametrize("name", TREE)
def test_a_command_is_told_shown_and_tested(name: str) -> None:
    click, (_, *words) = TREE[name].click, TREE[name].words
    assert click.help, f"{name} has no docstring, which is its help"
    assert click.epilog and name in click.epilog, f"{name} is registered without an example (epilog)"
    told = click.get_help(Context(click, info_name=name, terminal_width=80)).splitlines()
    assert f"  {click.epilog.splitlines()[0]}" in told[told.index("Examples:") :]
    if name.removeprefix("grind ") in FITS:
        assert len(told) <= 40 and max(map(len, told)) <= 80 and len(click.epilog.splitlines()) == 2
        assert not told[3], "the description is longer than a line"
    shown = any(f"{name}{end}" in PAGES for end in "` \n")
    assert shown, f"{name} is on no page: show it in docs/howto/"
    # the first word of what is run: a key such as outcomes["cost"] is none
    run = re.search(rf"""[(,] ?\[?\*?["'](agents |grind )?{words[0]}["' ]""", TESTS)
    assert run, f"no test runs {name}"
