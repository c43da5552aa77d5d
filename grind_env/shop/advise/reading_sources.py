"""Sources of readings: a growing CSV file, JSON lines, a prompt."""

import json
import math
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Protocol

from grind_env.errors import GrindError
from grind_env.files import shown
from grind_env.message_text import quoted
from grind_env.shop.advise.operator_readings import ReadingError
from grind_env.shop.measurements import measured_sheet

POLL = 0.5  #: time between two reads of a growing file, s
LONGEST_LINE = 1_000_000  #: longest line with a JSON object, bytes
#: units that a header may state, by reading; the first unit is for a header without one
UNITS = {
    **dict.fromkeys(("mean_power", "first_power", "peak_power"), measured_sheet.WATTS),
    **dict.fromkeys(("size_error", "Ra", "Ra_before"), measured_sheet.MICROMETRES),
    "diameter": measured_sheet.MILLIMETRES,
}


class ReadingsRow(NamedTuple):
    """Unchecked readings of one row."""

    table: dict[str, Any]
    place: str  #: place of the row, for messages


class ReadingSource(Protocol):
    """Source of rows of readings, in the order in which the blocks are ground."""

    repeats_rows: bool  #: whether the source repeats the rows of earlier sessions, as a file does
    accepts_corrections: bool  #: whether a refused row may come again, corrected

    def next(self, asked: str) -> ReadingsRow | None:
        """Return the next row; None if there is no more. `asked` names the awaited readings."""

    def refused(self) -> None:
        """Refuse the last row: the next row must be of the same block."""
        return


class CsvSource:
    """CSV file whose header has the names of the readings; `peak_power [kW]` states a unit.

    With `follow`, the source waits for further rows; a last line without a line end is still being written.
    """

    repeats_rows = True

    def __init__(self, path: Path, *, follow: bool, wait: Callable[[float], None] = time.sleep) -> None:
        self.path, self.follow, self.wait, self.taken = path, follow, wait, 0
        self.accepts_corrections, self.before, self.faulty = follow, 0, ""

    def refused(self) -> None:
        # the row is read again once the file differs
        self.taken, self.faulty = self.before, self._text()

    def next(self, asked: str) -> ReadingsRow | None:
        self.before = self.taken
        while True:
            text = self._text()
            rows = [] if self.faulty and text == self.faulty else self._rows(text)
            if self.taken < len(rows):
                self.taken += 1
                return rows[self.taken - 1]
            if not self.follow:
                return None
            self.wait(POLL)

    def _text(self) -> str:
        text = measured_sheet.read_measured(self.path)
        return text[: text.rfind("\n") + 1] if self.follow else text

    def _rows(self, text: str) -> list[ReadingsRow]:
        try:
            sheet = measured_sheet.sheet_of(self.path, text)
            if sheet is None:
                return []
            names = [heading.name for heading in sheet.headings]
            twice = next((name for name, count in Counter(names).items() if count > 1 and name), None)
            if twice is not None:
                raise ReadingError(f"{shown(self.path)} has more than one column {quoted(twice)}: leave one of them")
            columns = [_readings(sheet, column) for column in range(len(names))]
        except measured_sheet.SheetError as error:
            raise ReadingError(str(error)) from None
        return [
            ReadingsRow(dict(zip(names, cells, strict=True)), f"{shown(self.path)}, row {line}")
            for line, *cells in zip(sheet.lines, *columns, strict=True)
        ]


def _readings(sheet: measured_sheet.Sheet, column: int) -> list[float | str | None]:
    """Return the readings of a column in their usual unit: numbers, texts that are no numbers, None where missing."""
    numbers = sheet.factor(column, UNITS.get(sheet.headings[column].name, {"-": 1.0})) * sheet.values(column)
    cells = zip(numbers.tolist(), sheet.texts(column), strict=True)
    return [
        number if math.isfinite(number) else None if measured_sheet.is_missing(text) else text for number, text in cells
    ]


class JsonLines(ReadingSource):
    """One JSON object a line, such as `{"peak_power": 2400, "size_error": 3}`; `{}` if nothing was measured."""

    repeats_rows, accepts_corrections = False, True

    def __init__(self, stream: BinaryIO) -> None:
        self.stream, self.line = stream, 0

    def next(self, asked: str) -> ReadingsRow | None:
        while data := self._read():
            place = f"line {self.line} of the input"
            try:
                text = data.decode().strip()
            except UnicodeDecodeError as error:
                raise ReadingError(f"{place}: its byte {error.start + 1} is not text in UTF-8; write it anew") from None
            if not text:
                continue
            try:
                table = json.loads(text)
            except (ValueError, RecursionError):
                table = None
            if not isinstance(table, dict):
                raise ReadingError(f"{place} is {quoted(text)}, but must be a JSON object of readings by name")
            return ReadingsRow(table, place)
        return None

    def _read(self) -> bytes:
        """Return the next line; empty at the end of the input."""
        self.line += 1
        try:
            data = self.stream.readline(LONGEST_LINE)
        except OSError as error:
            why = error.strerror or "not readable"
            raise GrindError(f"standard input cannot be read ({why}): name a file with --measurements") from None
        if len(data) == LONGEST_LINE:
            raise ReadingError(f"line {self.line} of the input has no end: write one JSON object a line")
        return data


class Prompt(ReadingSource):
    """Prompt at the terminal for one line a block, such as `peak_power=2400 size_error=3`."""

    repeats_rows, accepts_corrections = False, True

    def __init__(self, ask: Callable[[str], str] = input) -> None:
        self.ask = ask

    def next(self, asked: str) -> ReadingsRow | None:
        try:
            text = self.ask(f"{asked}, such as peak_power=2400 (Enter: none; stop: pause)> ").strip()
        except EOFError:
            return None
        except UnicodeDecodeError:
            raise ReadingError("what was typed is not text in UTF-8: type it again") from None
        if text == "stop":
            return None
        table: dict[str, Any] = {}
        for word in text.split():
            name, sign, value = word.partition("=")
            if not sign:
                raise ReadingError(f"{quoted(word)} is no reading: write name=value, such as peak_power=2400")
            table[name] = value
        return ReadingsRow(table, "what was typed")
