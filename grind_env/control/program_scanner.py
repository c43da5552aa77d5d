"""The text of a part program, cut into blocks one at a time (10-6).

Blocks are not kept in memory: each reader cuts them from the bytes again. So a program takes no more memory than one
chunk, however many blocks it has.
"""

import codecs
import functools
import io
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple

from grind_env.control.errors import ControlError, Place
from grind_env.files import ReadError, contents, open_file

CHUNK = 1 << 16  #: bytes read at a time; a longer block is read in one piece
#: length, bytes, from which a line is read in pieces cut at ``;``; remarks behind ``;`` are not recognised there
LONGEST_LINE = CHUNK
LONGEST_BLOCK = 10_000
IN_MEMORY_BYTES = 1 << 20  #: size, bytes, up to which a file stays in memory instead of being read again

#: a remark behind ``;``, not a block: it begins with a letter without a number. An O in XO is a mistyped zero
_REMARK = (
    r"(?:[ \t]*(?!(?i:IF|WHILE|GOTO|DO|END)[ \t]*[\[#0-9]|[E-FI-KQRX-Ze-fi-kqrx-z][Oo](?![A-Za-z]))"
    r"(?:[A-Za-z][ \t]*[^-+.0-9\[# \t\r\n();%]|[^A-Za-z(/#;%\s])[^\r\n]*)?"
)
_BLOCK = re.compile(r"([^(;%\r\n]*(?:\([^);\r\n]*[^(;%\r\n]*)*)(\r\n|;" + _REMARK + r"|[%\r\n]|\Z)")
_LINE_ENDS = ("\r\n", "\r", "\n")
#: bytes that are not UTF-8 are decoded to half surrogates, and shown as the letters of Latin-1
_EIGHT_BIT = {0xDC00 + byte: byte for byte in range(0x80, 0x100)}
_LINE_END = re.compile(rb"\r\n|\r|\n")
_COMMENTS = re.compile(r"(?:\([^()]*\)\s*)*")
#: bytes that no part program contains, and the message for each
_NO_TEXT = {
    b"\0": "a byte 0 stands in this line, as in no text in UTF-8 or Latin-1; save the part program as text",
    **{
        bytes(
            [0x10 + number]
        ): f"the code DC{number} of a data transfer stands in this line; delete it, or receive the "
        "program without DC1 to DC4"
        for number in (1, 2, 3, 4)
    },
}


class SourceText(NamedTuple):
    """The text of one block as it stands in the file; line and column count from 1."""

    file: str
    line: int
    column: int
    text: str

    @property
    def deletable(self) -> bool:
        return self.text.startswith("/")

    @property
    def place(self) -> Place:
        return Place(self.file, self.line, self.column, self.line)


@dataclass(frozen=True, slots=True)
class Text:
    """A text in UTF-8, or in an 8-bit code such as Latin-1, that can be read again and again."""

    name: str  #: name of the file, for the places of blocks
    title: str  #: name of the text in messages about the text as a whole
    open: Callable[[], BinaryIO]  #: opens its bytes; a `ControlError` says why they cannot be read


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in a text where a block may begin: byte from 0, line and column from 1.

    `begun` says whether a block that is no comment stands before it, so that the next ``%`` ends the text.
    """

    offset: int = 0
    line: int = 1
    column: int = 1
    begun: bool = False


def text_of(text: str, name: str) -> Text:
    """Return `text` as a `Text` in memory; half surrogate pairs, which are no characters, become question marks."""
    return Text(name, name, functools.partial(io.BytesIO, text.encode("utf-8", "replace")))


def readable(text: str) -> str:
    """Return a text decoded with `surrogateescape`, with the bytes that are not UTF-8 as in Latin-1."""
    return text if text.isascii() else text.translate(_EIGHT_BIT)


def lines_of(text: Text) -> list[str]:
    """Return the lines of a text without line ends, for display; line 1 has index 0."""
    with text.open() as handle:
        data = handle.read().removeprefix(codecs.BOM_UTF8)
    return [readable(line.decode(errors="surrogateescape")) for line in _LINE_END.split(data)]


def text_in(path: Path) -> Text:
    """Return the text of a file; a large file must not change while it is read.

    A pipe, which can be read only once, is read into memory.
    """
    try:
        with open_file(path) as handle:
            if isinstance(handle, io.BytesIO) or os.fstat(handle.fileno()).st_size <= IN_MEMORY_BYTES:
                return Text(path.name, str(path), functools.partial(io.BytesIO, contents(handle, path)))
            return Text(path.name, str(path), functools.partial(_reopened, path, _state(handle)))
    except ReadError as error:
        raise _unreadable(error) from None


class Scanner:
    """Iterator over the blocks of a text, from a mark to the closing ``%``; `unread` if text follows the ``%``."""

    def __init__(self, handle: BinaryIO, text: Text, start: Mark) -> None:
        self._handle, self._text, self._start = handle, text, start
        self._last: tuple[re.Match[str], int, int, int] | None = None
        self._begun, self.unread = start.begun, False

    def __iter__(self) -> Iterator[SourceText]:
        name, line = self._text.name, self._start.line
        line_begin = 1 - self._start.column
        pieces = self._pieces()
        for offset, piece in pieces:
            for match in _BLOCK.finditer(piece):
                text, end = match.groups()
                block = readable(text.strip())
                if block:
                    self._last = match, offset, line, line_begin
                    self._begun = self._begun or not _COMMENTS.fullmatch(block)
                    column = match.start() + len(text) - len(text.lstrip()) - line_begin + 1
                    source = SourceText(name, line, column, block)
                    if len(block) > LONGEST_BLOCK:
                        message = f"the block has {len(block)} characters; {LONGEST_BLOCK} are allowed"
                        raise source.place.error("block-format", message)
                    yield source
                if end == "%" and self._begun:
                    self.unread = bool(piece[match.end() :].strip())
                    for _, further in pieces:  # what follows must be text as well
                        self.unread = self.unread or bool(further.strip())
                    return
                if end in _LINE_ENDS:
                    line, line_begin = line + 1, match.end()
            line_begin -= len(piece)

    @property
    def mark(self) -> Mark:
        """Place after the last block, before the ``%`` that ends the text."""
        if self._last is None:
            return self._start
        match, offset, line, line_begin = self._last
        end = match.end(1) if match[2] == "%" else match.end()
        offset += len(match.string[:end].encode(errors="surrogateescape"))
        if match[2] in _LINE_ENDS:
            return Mark(offset, line + 1, 1, self._begun)
        return Mark(offset, line, end - line_begin + 1, self._begun)

    def _pieces(self) -> Iterator[tuple[int, str]]:
        offset = self._start.offset
        self._handle.seek(offset)
        rest = b"" if offset else self._handle.read(len(codecs.BOM_UTF8))
        if rest == codecs.BOM_UTF8:
            offset, rest = len(rest), b""
        while more := self._handle.read(max(CHUNK, len(rest))):
            data = rest + more
            line_end = max(data.rfind(b"\n"), data.rfind(b"\r", 0, -1))
            end = 1 + (line_end if line_end >= 0 or len(data) < LONGEST_LINE else data.rfind(b";"))
            yield offset, self._decoded(data[:end], offset)
            offset, rest = offset + end, data[end:]
        yield offset, self._decoded(rest, offset)

    def _decoded(self, data: bytes, offset: int) -> str:
        for byte, message in _NO_TEXT.items():
            if byte in data:
                self._handle.seek(0)
                line = 1 + len(_LINE_END.findall(self._handle.read(offset + data.index(byte))))
                raise Place(self._text.name, line, 1, line).error("file", message)
        return data.decode(errors="surrogateescape")


def _unreadable(error: ReadError) -> ControlError:
    return ControlError("file", f"{error}; name a text file")


def _state(handle: BinaryIO) -> tuple[int, ...]:
    status = os.fstat(handle.fileno())
    return status.st_ino, status.st_size, status.st_mtime_ns


def _reopened(path: Path, state: tuple[int, ...]) -> BinaryIO:
    try:
        handle = open_file(path)
    except ReadError as error:
        raise _unreadable(error) from None
    if isinstance(handle, io.BytesIO) or _state(handle) != state:
        handle.close()
        raise changed(str(path))
    return handle


def changed(title: str) -> ControlError:
    """Return the error for a text that has changed since its programs were found."""
    return ControlError("file", f"{title} has changed since it was read; read it again")
