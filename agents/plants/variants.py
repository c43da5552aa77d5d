"""A program with other E and picks, and one that grinds several parts with an E of their own."""

import re
from pathlib import Path

FEED, PICK, DRESSES = re.compile(r"\bE(\d+\.?)"), re.compile(r"\bJ-(\d*\.\d+)"), re.compile(r" D\d+")
INFEED = re.compile(r"(G01 Y-\.\d+ F)(\.\d+)")
"""Beside a table that runs."""
NEXT = "G80\nM00\n"
END = re.compile(r"^N\d+ M30$", re.MULTILINE)


def scaled(text: str, E: float = 1.0, J: float = 1.0, *, dressed: bool = True) -> str:
    """The program with its E times a factor, depths of cut times J, and without dresses where it is not `dressed`."""
    text = FEED.sub(lambda found: f"E{E * float(found[1]):.0f}.", text)
    text = PICK.sub(lambda found: f"J-{J * float(found[1]):.4f}", text)
    text = INFEED.sub(lambda found: f"{found[1]}{E * J * float(found[2]):.4f}", text)
    return text if dressed else DRESSES.sub(" D0", text)


def batch(text: str, feeds: tuple[float, ...], dressed: tuple[bool, ...]) -> str:
    """The program for as many parts, one after the other, each with its E times a factor, and dressed or not."""
    head, body, tail = _pieces(text)
    parts = [_unnumbered(scaled(body, E, dressed=D)) for E, D in zip(feeds, dressed, strict=True)]
    return head + NEXT.join(parts) + "M30\n" + tail


def _pieces(text: str) -> tuple[str, str, str]:
    """What comes before the first block, the blocks up to M30, and the subprograms."""
    begin = text.index("\nN10 ") + 1
    end = END.search(text)
    assert end is not None
    return text[:begin], text[begin : end.start()], text[end.end() :]


def _unnumbered(text: str) -> str:
    return re.sub(r"^N\d+ ", "", text, flags=re.MULTILINE)


def write(path: Path, text: str) -> Path:
    """Write a program."""
    path.write_text(text, encoding="utf-8")
    return path
