"""Write the pages of ids, fields of files, plants and validation: `python -m grind_env.pages FOLDER`."""

import sys
from importlib.util import find_spec
from pathlib import Path

from grind_env.pages.file_keys import FILE as FIELDS
from grind_env.pages.file_keys import fields_page
from grind_env.pages.plants import FILE as PLANTS
from grind_env.pages.plants import plants_page
from grind_env.pages.task_index import file_name, index
from grind_env.pages.task_page import page
from grind_env.pages.task_page_data import page_ids
from grind_env.pages.validation import FILE, PICTURE, ROWS, validation_page
from grind_env.pages.validation_figure import plot_series
from grind_env.validation import validate
from grind_env.validation.report import write_csv


def write(folder: Path) -> list[Path]:
    """Write all pages into a folder, which is created if necessary; return the files written.

    The picture of the validation needs matplotlib; without matplotlib it is left out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows = validate()
    caption = plot_series(folder / PICTURE) if find_spec("matplotlib") else ""
    write_csv(rows, folder / ROWS)
    texts = {
        "index.md": index(),
        FIELDS: fields_page(),
        PLANTS: plants_page(),
        FILE: validation_page(rows, caption),
        **{file_name(env_id): page(env_id) for env_id in page_ids()},
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in (*texts, *[PICTURE] * bool(caption), ROWS)]


def main(arguments: list[str]) -> str | None:
    """Write the pages; return a line on usage if the arguments are wrong."""
    if len(arguments) != 1:
        return "usage: python -m grind_env.pages FOLDER"
    files = write(Path(arguments[0]))
    print(f"{len(files)} files in {arguments[0]}")
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
