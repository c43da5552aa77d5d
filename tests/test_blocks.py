"""`.ci/blocks.py` finds every block of every page, runs it as a reader would, and refuses unknown blocks."""

import re
import runpy
import shlex
import sys
from pathlib import Path

import pytest
from typer.main import get_command

import grind_env
from agents.command_line import app as agents
from grind_env.shop.calibrate.column_names import read_map

ROOT = Path(__file__).parents[1]
CI = runpy.run_path(str(ROOT / ".ci" / "blocks.py"))
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]


@pytest.fixture
def page(tmp_path: Path) -> Path:
    return tmp_path / "page.md"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_block_of_a_page_is_found(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    fences = [k for k, line in enumerate(lines, 1) if line.lstrip().startswith(("```", "~~~", ":::"))]
    shown = re.compile(r"```(text|toml|\{(eval-rst|toctree|include|literalinclude|raw)\})")
    opened = [k for k in fences[::2] if not shown.match(lines[k - 1]) and lines[k] != ":tags: [remove-input]"]
    places = [block.place for block in CI["blocks"](path)]
    assert places == [f"{path.relative_to(ROOT).as_posix()}:{k + 1}" for k in opened]


@pytest.mark.parametrize(
    "text, told",
    [
        ("```console\n$ ls\n```\n", "page.md:2: nothing says how a block 'console' is run"),
        ("- in a list\n\n  ```\n  ls\n  ```\n", "page.md:4: nothing says how a block '' is run"),
        ("An indented one\n\n    grind run part.nc\n", "nothing says how a block '' is run"),
        ("````{note}\n```sh\nls\n```\n````\n", "nothing says how a block '{note}' is run"),
        ("<!-- not run: it needs a machine -->\n\n```sh\nls\n```\n", "page.md:1: 'not run' stands above nothing"),
        ("<!-- not run: it is a table -->\n```toml\na = 1\n```\n", "page.md:1: 'not run' stands above nothing"),
    ],
)
def test_an_unknown_block_or_a_stray_comment_is_refused(page: Path, text: str, told: str) -> None:
    page.write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit, match=re.escape(told)):
        list(CI["blocks"](page))


AS_A_READER = """\
```python
written = "by Python"
```

<!-- not run: it would fail -->
```sh
exit 1
```

1. In a list, too:

   ```sh
   echo by bash > made.txt
   ```

```{code-cell}
print(written, "and", open("made.txt").read())
```

```{code-cell}
%%bash
cat made.txt
```
"""


@pytest.mark.parametrize(
    "block, wrong",
    [
        ("", None),
        ("```sh\nfalse | cat\n```\n", "ended with status"),
        ("```sh\nfalse\ntrue\n```\n", "ended with status"),
        ("```sh\necho $PYTHONPATH\n```\n", "ended with status"),
        ("```python\nassert written == 'by bash'\n```\n", "ended with status"),
        ("```{code-cell}\nsubprocess\n```\n", "ended with status"),
        ("```sh\n: grind optimise part.nc -o better.nc\n```\n", "did not write better.nc"),
    ],
)
def test_a_page_runs_from_top_to_bottom(page: Path, capfd, monkeypatch, block: str, wrong: str | None) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    page.write_text(AS_A_READER + "\n" + block, encoding="utf-8")
    ended = CI["main"](str(Path(sys.executable).parent), str(page))
    out = capfd.readouterr().out
    assert "by Python and by bash\n\n" in out
    assert "not run: " in out and ": it would fail\n" in out
    assert (ended is None) == (wrong is None)
    assert wrong is None or wrong in ended


def test_a_nightly_block_of_the_shell_begins_an_environment(page: Path) -> None:
    nightly = "<!-- not run: nightly -->\n"
    install, first, second = "```sh\npip install {}\n```\n", "```python\nimport a\n```\n", "```python\nimport b\n```\n"
    blocks = [install.format("a"), first, install.format("b"), second, second]
    page.write_text(first + "".join(nightly + block for block in blocks), encoding="utf-8")
    found = runpy.run_path(str(ROOT / ".ci" / "libraries.py"))["groups"](page)
    texts = [[block.text for block in group] for group in found]
    assert texts == [["pip install a\n", "import a\n"], ["pip install b\n", "import b\n", "import b\n"]]


def test_only_trainings_are_shortened() -> None:
    shortened = set[str]()
    for steps, fewer in CI["FEWER"].items():
        found = [block for path in PAGES for block in CI["blocks"](path) if steps in block.text]
        shortened |= {block.place.partition(":")[0] for block in found}
        script = CI["script"](found)
        left = script.replace(fewer, "").replace("grind train --steps 20000 ", "")
        assert script.count(fewer) >= len(found) > 0 and steps not in left
    assert shortened == {"README.md", "docs/howto/advise.md", "docs/howto/train.md"}


def test_toml_tables_on_pages_are_valid_jobs_or_catalogues(tmp_path: Path) -> None:
    job, catalogue = tmp_path / "part.toml", tmp_path / "ours.toml"
    shown = [table for path in PAGES for table in re.findall(r"```toml\n(.*?)```", path.read_text(), re.DOTALL)]
    assert shown
    for table in shown:
        if "[log]" in table:  # a columns file
            catalogue.write_text(table, encoding="utf-8")
            read_map(catalogue)
            continue
        part = (
            ""
            if "[part]" in table
            else '[part]\nmaterial = "aisi_52100"\nlength = 200\nwidth = 20\nstock = 0.2\nscrap_cost = 40\n'
        )
        ours = "[uncertainty]" in table
        catalogue.write_text(table if ours else "", encoding="utf-8")
        job.write_text(part + ('[catalogue]\nfiles = ["ours.toml"]\n' if ours else table), encoding="utf-8")
        grind_env.load_job(job)


def test_agents_commands_accept_the_options_shown_on_pages() -> None:
    known = get_command(agents).commands
    left_out = "".join(block.text for path in PAGES for block in CI["blocks"](path) if block.not_run)
    lines = re.findall(r"^python -m agents (.+)$", left_out, re.MULTILINE)
    assert lines
    for line in lines:
        name, *words = shlex.split(line, comments=True)
        known[name].make_context(name, words)  # raises on a wrong option
