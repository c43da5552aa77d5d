"""Every command has help that fits on a screen, is shown on a page and run by a test; renamed options say so."""

import re
from pathlib import Path
from typing import Any

import pytest
import typer.main
from typer import Context

from agents.command_line import app as agents
from grind_env.cli import app as grind
from grind_env.command_exit import command
from grind_env.command_help import RENAMED
from tests.test_outputs import TREE

ROOT = Path(__file__).parents[1]
PAGES = "".join(path.read_text() for path in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
TESTS = "".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.py"))


def help_of(click: Any, name: str) -> list[str]:
    lines: list[str] = click.get_help(Context(click, info_name=name, terminal_width=80)).splitlines()
    assert len(lines) <= 40 and max(map(len, lines)) <= 80
    assert not lines[3], "the description is longer than a line"
    return lines


@pytest.mark.parametrize("name", TREE)
def test_a_command_has_short_help_two_examples_a_page_and_a_test(name: str) -> None:
    click, (_, *words) = TREE[name].click, TREE[name].words
    examples = click.epilog.splitlines()
    assert len(examples) == 2 and all(name in each for each in examples)
    assert help_of(click, name)[-3:] == ["Examples:", *(f"  {each}" for each in examples)]
    assert any(f"{name}{end}" in PAGES for end in "` \n"), f"{name} is on no page: show it in docs/howto/"
    # the first word of a command line, but no key such as outcomes["cost"]
    run = re.search(rf"""[(,] ?\[?\*?["'](agents |grind )?{words[0]}["' ]""", TESTS)
    assert run, f"no test runs {name}"


@pytest.mark.parametrize("app", [grind, agents])
def test_the_help_of_a_group_has_the_first_line_of_each_command(app: typer.Typer) -> None:
    click: Any = typer.main.get_command(app)
    lines = [" ".join(line.split()) for line in help_of(click, "grind")]
    for word, each in click.commands.items():
        assert lines.count(f"{word} {each.help.splitlines()[0]}") == 1


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_a_renamed_option_is_refused_with_its_new_name(old: str, new: str, capsys: pytest.CaptureFixture[str]) -> None:
    taking = [leaf.click for leaf in TREE.values() if any(new in each.opts for each in leaf.click.params)]
    assert taking, f"no command has {new}"
    for click in taking:
        for words in ([old, "1"], [f"{old}=1"]):
            with pytest.raises(SystemExit) as stopped, command("grind"):
                click(words)
            assert (stopped.value.code, capsys.readouterr().err) == (2, f"grind: {old} was renamed to {new}\n")
