"""Write the folder from which Sphinx makes the site: `python docs/tools/sources.py FOLDER`.

Hand-written pages are copied from `docs/`; pages on tasks, fields, validation, plants, facts, commands and results are
written from code and results; notebooks have the outputs that are in git.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

from citation import bibtex, read_citation
from commands import commands_page
from errors import errors_page
from facts import facts_page
from flow import flow
from gallery import png, sheet, still

from agents.command_line import app as agents_app
from agents.dressing.table import COLUMNS, read_studies
from grind_env.cli import app as grind_app
from grind_env.data_table import table_of
from grind_env.pages.__main__ import write as write_pages

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
RESULTS = ROOT / "agents" / "results"
#: places of the generated pages that do not describe a task
NOT_TASKS = {
    "fields.md": "reference/fields.md",
    **{name: name for name in ("validation.md", "validation.png", "validation.csv", "plants.md")},
}
PAGES = (".md", ".png", ".svg", ".toml", ".nc", ".csv")
UNSEEN = ("Job-v0.md", "Task-v0.md")  #: pages without a picture, because their ids need a file
GALLERY = "![Eight tasks in the middle of an episode](../images/gallery.png)"
#: head of a page that the search leaves out, because it contains nearly every word
NOT_SEARCHED = b"---\nnosearch: true\n---\n\n"
Page = tuple[str, bytes]  #: path in the folder, and content


def by_hand() -> Iterator[Page]:
    """Yield the pages of `docs/`, the changelog, the licence and the pictures of the notebooks."""
    for path in sorted(DOCS.rglob("*")):
        place = path.relative_to(DOCS)
        if path.suffix in PAGES and place.parts[0] not in ("tools", "static"):
            yield place.as_posix(), path.read_bytes()
    yield "project/CHANGELOG.md", NOT_SEARCHED + (ROOT / "CHANGELOG.md").read_bytes()
    yield "project/LICENSE", (ROOT / "LICENSE").read_bytes()
    for path in sorted((ROOT / "notebooks" / "images").iterdir()):
        yield f"images/{path.name}", path.read_bytes()


def tutorials() -> Iterator[Page]:
    """Yield the notebooks with their outputs."""
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        yield f"tutorials/{path.name}", path.read_bytes()


def from_code() -> Iterator[Page]:
    """Yield the pages on tasks, fields, validation, plants, facts, errors and commands, the figure and the citation."""
    with TemporaryDirectory() as folder:
        for path in write_pages(Path(folder)):
            text = path.read_bytes()
            if path.name == "index.md":
                text = _index(text.decode()).encode()
            if path.name not in (*NOT_TASKS, *UNSEEN, "index.md"):
                yield f"tasks/{path.stem}.png", png(still(f"grind/{path.stem}"))
                title, _, rest = text.decode().partition("\n")
                text = f"{title}\n\n![A picture of an episode]({path.stem}.png)\n{rest}".encode()
            yield NOT_TASKS.get(path.name, f"tasks/{path.name}"), text
    yield "images/gallery.png", png(sheet())
    yield "control/facts.md", facts_page().encode()
    yield "api/errors.md", errors_page(DOCS).encode()
    yield "reference/grind.md", commands_page(grind_app, "grind").encode()
    yield "reference/agents.md", commands_page(agents_app, "python -m agents").encode()
    yield "process/flow.svg", flow().encode()
    yield "project/cite.bib", bibtex(read_citation(ROOT / "CITATION.cff"), (ROOT / "LICENSE").read_text()).encode()


def _index(text: str) -> str:
    """Return the index of the tasks with the links of the site and a table of contents."""
    linked = text.replace("(validation.md)", "(../validation.md)").replace("(fields.md)", "(../reference/fields.md)")
    return f"{linked}\n{GALLERY}\n\n```{{toctree}}\n:hidden:\n:glob:\n\n*\n```\n"


def results() -> Iterator[Page]:
    """Yield the tables and figures of `agents/results`."""
    for path in sorted((*RESULTS.rglob("*.md"), *RESULTS.rglob("*.png"))):
        # links to pages of `docs/` are shorter on the site than in the checkout
        content = path.read_bytes()
        content = content.replace(b"](../../docs/", b"](../../") if path.suffix == ".md" else content
        yield f"benchmark/results/{path.relative_to(RESULTS).as_posix()}", content
    yield "benchmark/dress_study.txt", table_of(COLUMNS, read_studies(RESULTS / "dress_study")).markdown().encode()
    shown = [
        f"### {path.stem}\n\n![dress study of {path.stem}](results/{path.relative_to(RESULTS).as_posix()})\n"
        for path in sorted((RESULTS / "dress_study").glob("*.png"))
    ]
    yield "benchmark/dress_study_pictures.txt", "\n".join(shown).encode()


def write(folder: Path) -> int:
    """Replace the content of a folder by all pages; return the number of pages."""
    pages = dict([*by_hand(), *tutorials(), *from_code(), *results()])
    rmtree(folder, ignore_errors=True)
    for place, content in pages.items():
        path = folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return len(pages)


if __name__ == "__main__":
    print(f"{write(Path(sys.argv[1]))} files in {sys.argv[1]}")
