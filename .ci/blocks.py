"""Run the code blocks of the README and of `docs/` as printed, each page from top to bottom in an empty folder.

`.ci/blocks.py BIN [PAGE...]` uses the commands in BIN, the bin folder of an environment with the installed wheel;
`make blocks` creates one. A shell block runs in a bash of its own, the Python blocks of a page in one session; only
trainings are shortened. A block that cannot run says why in the line above: `<!-- not run: it needs Windows -->`.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt  # comes with rich, which the wheel needs

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
RUN = ("sh", "python")
#: kinds of blocks that contain nothing to run
SHOWN = ("text", "toml", "{eval-rst}", "{include}", "{literalinclude}", "{raw}", "{toctree}")
NOT_RUN = re.compile(r"<!-- not run: (\S.*) -->\n")
BASH = ["bash", "-euxo", "pipefail", "-c"]
#: replacements that shorten trainings from minutes to seconds
FEWER = {"1_000_000": "20_000", "grind train ": "train_briefly "}
#: shell function for a short training; exit status 3 (the agent is not recommended) is no failure
BRIEFLY = 'train_briefly() { grind train --steps 20000 --episodes 8 "$@" || [ $? = 3 ]; }\n'
#: standard input of the blocks: readings of two parts, as somebody types them at the machine
READINGS = '{"mean_power": 2600, "peak_power": 2900}\n{"mean_power": 1700, "peak_power": 1900, "size_error": 1.5}\n'
WRITES = re.compile(r" (?:-o|--output|--plan|--plot|--record|--report|--submit) ([\w./-]+)")


class Block(NamedTuple):
    """Block that a reader may run: place (page, colon, first line), kind, text, and why it is not run here."""

    place: str
    kind: str
    text: str
    not_run: str | None


def blocks(page: Path) -> Iterator[Block]:
    """Yield the blocks of a page in order.

    Raises:
        SystemExit: a block has an unknown kind, or no block follows a "not run".
    """
    name = os.path.relpath(page, ROOT)
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    reasons = {token.map[1]: mark[1] for token in tokens if (mark := NOT_RUN.fullmatch(token.content))}
    for token in tokens:
        kind, text = _printed(token.info, token.content)
        if token.type not in ("fence", "code_block") or kind in SHOWN:
            continue
        place, reason = f"{name}:{token.map[0] + 2}", reasons.pop(token.map[0], None)
        if kind not in RUN and reason is None:
            raise SystemExit(f"{place}: nothing says how a block '{kind}' is run; see .ci/blocks.py")
        yield Block(place, kind, text, reason)
    for line in reasons:
        raise SystemExit(f"{name}:{line}: 'not run' stands above nothing that would run")


def _printed(info: str, content: str) -> tuple[str, str]:
    """Return kind and text of a block as a reader sees it; a cell is Python, shell or hidden."""
    if info != "{code-cell}":
        return info.split(" ")[0], content
    if content.startswith(":tags: [remove-input]\n"):
        return "text", content
    return ("sh", content.removeprefix("%%bash\n")) if content.startswith("%%bash\n") else ("python", content)


def script(found: list[Block]) -> str:
    """Return Python code that runs blocks one after the other; tracebacks have the line numbers of the page."""
    lines = []
    for place, kind, text, _ in found:
        page, _, line = place.rpartition(":")
        for steps, fewer in FEWER.items():
            text = text.replace(steps, fewer)
        lines.append(f"print({f'--- {place}'!r}, flush=True)")
        if kind == "sh":
            lines.append(f"__import__('subprocess').run({[*BASH, BRIEFLY + text]!r}, check=True)")
        else:
            lines.append(f"exec(compile({chr(10) * (int(line) - 1) + text!r}, {str(ROOT / page)!r}, 'exec'))")
    return "\n".join(lines)


def run(found: list[Block], environment: dict[str, str]) -> str | None:
    """Run blocks in an empty folder; return what is wrong, or None."""
    with tempfile.TemporaryDirectory() as empty:
        ended = subprocess.run(
            ["python", "-c", script(found)], cwd=empty, env=environment, input=READINGS, text=True, check=False
        )
        if ended.returncode != 0:
            return f"a block ended with status {ended.returncode}; see its output above"
        written = [f"/{each.relative_to(empty).as_posix()}" for each in Path(empty).rglob("*")]
    named = [name for block in found if block.kind == "sh" for name in WRITES.findall(block.text)]
    missing = [name for name in named if not any(each.endswith(f"/{name}") for each in written)]
    return f"did not write {', '.join(missing)}" if missing else None


def main(folder: str, *chosen: str) -> str | None:
    """Run the chosen pages, or all, and print a line for each; return what is wrong, or None."""
    environment = {**os.environ, "PATH": f"{Path(folder).resolve()}{os.pathsep}{os.environ['PATH']}"}
    environment.pop("PYTHONPATH", None)  # it may lead to a checkout
    found = {page: list(blocks(page)) for page in [Path(each).resolve() for each in chosen] or PAGES}
    told, failed = [], []
    for page, all_blocks in found.items():
        told += [f"not run: {block.place}: {block.not_run}" for block in all_blocks if block.not_run]
        if runs := [block for block in all_blocks if not block.not_run]:
            before = sum(os.times()[2:4])
            wrong = run(runs, environment)
            name, seconds = os.path.relpath(page, ROOT), sum(os.times()[2:4]) - before
            told.append(f"{'failed' if wrong else 'OK'}: {name}, {len(runs)} blocks, {seconds:.0f} s of CPU")
            failed += [f"{name}: {wrong}"] if wrong else []
    print("\n".join(told))
    return "\n".join(failed) or None


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
