"""Write the pages of all registered ids and their index: `python -m grind_env.pages FOLDER`."""

import sys
from pathlib import Path

from grind_env.pages.page import page
from grind_env.pages.sheet import page_ids
from grind_env.pages.summary import file_name, index


def write(folder: Path) -> list[Path]:
    """Write the index and all pages into a folder, which is made if need be; returns the files written."""
    texts = {"index.md": index(), **{file_name(env_id): page(env_id) for env_id in page_ids()}}
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
