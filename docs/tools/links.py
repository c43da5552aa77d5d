"""Check that every link within the built site leads somewhere: `python docs/tools/links.py FOLDER`."""

import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

from bs4 import BeautifulSoup

LINKS = {"a": "href", "link": "href", "img": "src", "script": "src", "source": "src", "video": "src"}


def broken(folder: Path) -> list[str]:
    """Return a line for every link to a missing file or anchor in the folder."""
    pages = {path: BeautifulSoup(path.read_bytes(), "html.parser") for path in sorted(folder.rglob("*.html"))}
    anchors = {
        path: {element.get(name) for name in ("id", "name") for element in page.find_all(attrs={name: True})}
        for path, page in pages.items()
    }
    found = []
    for path, page in pages.items():
        for tag, attribute in LINKS.items():
            for element in page.find_all(tag, attrs={attribute: True}):
                link = urlsplit(element[attribute])
                if link.scheme or link.netloc:
                    continue
                target = (path.parent / unquote(link.path)).resolve() if link.path else path
                anchor = unquote(link.fragment)
                there = target.is_file() and (not anchor or target not in anchors or anchor in anchors[target])
                if not there:
                    found.append(f"{path.relative_to(folder)}: {element[attribute]}")
    return sorted(set(found))


if __name__ == "__main__":
    lost = broken(Path(sys.argv[1]).resolve())
    sys.exit("\n".join([f"{len(lost)} links lead nowhere", *lost]) if lost else None)
