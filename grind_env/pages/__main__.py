"""Write the pages of all ids, their index, and the validation of the process: `python -m grind_env.pages FOLDER`."""

import sys
from pathlib import Path

from grind_env.pages.page import page
from grind_env.pages.sheet import page_ids
from grind_env.pages.summary import file_name, index
from grind_env.pages.validation import FILE, validation_page


def write(folder: Path) -> list[Path]:
    """Write all of them into a folder, which is made if need be; returns the files written."""
    pages = {file_name(env_id): page(env_id) for env_id in page_ids()}
    texts = {"index.md": index(), FILE: validation_page(), **pages}
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in texts]


def main(arguments: list[str]) -> str | None:
    """Write the pages; returns a line on usage if the arguments do not fit."""
    if len(arguments) != 1:
        return "usage: python -m grind_env.pages FOLDER"
    files = write(Path(arguments[0]))
    print(f"{len(files)} pages in {arguments[0]}")
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
