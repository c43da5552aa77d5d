"""A text of rows and columns as machines, data loggers and spreadsheets export it.

Between columns stand semicolons, tabulators, bars, commas or blanks; before the heading there may be lines about the
export, after it a line of units; numbers have a decimal point or a decimal comma.
"""

import csv
import io
import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.errors import quoted
from grind_env.extras import needing
from grind_env.files import ReadError, read_bytes, shown
from grind_env.shop.calibrate.errors import CalibrationError

with needing("shop", "a calibration needs"):
    import pandas

Floats = NDArray[np.float64]

SEPARATORS = (";", "\t", "|", ",", " ")
"""In the order in which they are tried: a comma may be that of decimals."""
MOST_COLUMNS = 1000
BEYOND, LATEST = 1e12, 1e19
"""What no measurement reaches in any unit, and no time, not even that of a clock in ns since 1970."""
LOOKED_AT = 200
"""Lines in which the layout of a text is looked for."""
USUAL_SHARE = 0.6
"""Of these lines that must have as many columns as most."""

_NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)*|[.,]\d+)([eE][-+]?\d+)?\s*%?")
_COMMA = re.compile(r"[-+]?[\d.]*,\d+([eE][-+]?\d+)?")
_POINT = re.compile(r"[-+]?\d*\.\d+([eE][-+]?\d+)?")
_CLOCK = re.compile(r"(\S+[ T])?\d{1,2}:\d{2}(:\d{2}([.,:]\d+)?)?(\s*[AaPp][Mm])?(\s*(Z|UTC|[-+]\d{2}:?\d{2}))?")
_DATE = re.compile(r"\d{1,4}[-./]\d{1,2}[-./]\d{1,4}")
_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")
_DATE_PARTS = r"(\d{1,4}[-./]\d{1,2}[-./]\d{1,4})"
_CLOCK_PARTS = r"(\d{1,2}):(\d{2})(?::(\d{2}(?:[.,:]\d+)?))?\s*([AaPp])?"
DATES = ("%Y-%m-%d", "%d-%m-%Y", "%m-%d-%Y", "%d-%m-%y", "%m-%d-%y", "%y-%m-%d")
DAY, BACK = 86_400.0, 3700.0
"""s; rows are never that much out of order, and summer time ends by less."""
UNITS = re.compile(
    r"(?i)[\[(]?\s*(ms|s|sec|sek|min|h|us|µs|w|kw|watt|hp|ps|%|a|amp|ampere|mm|µm|um|in|inch|m/min|mm/min|mm/s|m/s|-|°c|n"
    r"|hh:mm:ss(\.\w+)?|)\s*[\])]?"
)
"""What a line of units consists of."""


class Heading(NamedTuple):
    """A column's name, and its unit if one is stated."""

    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class Sheet:
    """Rows and columns of a text.

    Attributes:
        path: of the file.
        headings: of the columns; `column 1` and so on of a text without.
        cells: a pandas frame of texts; NaN where a cell is empty.
        decimal_comma: whether numbers have one.
        skipped: lines that have another number of columns.
    """

    path: Path
    headings: tuple[Heading, ...]
    cells: Any
    decimal_comma: bool
    skipped: int

    def numbers(self, column: int, beyond: float = BEYOND) -> Floats:
        """A column as numbers; NaN where a cell is none.

        Raises:
            CalibrationError: a number is beyond all measurements.
        """
        texts = self.cells[column].str.strip().str.rstrip("%").str.strip()
        if self.decimal_comma:
            texts = texts.str.replace(".", "", regex=False).str.replace(",", ".", regex=False)
        numbers: Floats = pandas.to_numeric(texts, errors="coerce").to_numpy(np.float64)
        for row in np.flatnonzero(np.abs(numbers) >= beyond).tolist():
            if any(letter.isdigit() for letter in texts[row]):  # else a word such as inf, for what is missing
                raise self.not_measured(column, row)
        return np.where(np.isfinite(numbers), numbers, np.nan)

    def not_measured(self, column: int, row: int) -> CalibrationError:
        """The error of a cell whose number is none that can have been measured."""
        heading, cell = self.headings[column].name, self.texts(column)[row]
        return CalibrationError(
            f"{shown(self.path)}: {quoted(cell)} in column {quoted(heading)} cannot have been measured; correct that "
            "cell, or leave it empty"
        )

    def texts(self, column: int) -> list[str]:
        """A column as texts; an empty one for an empty cell."""
        return [str(text).strip() for text in self.cells[column].fillna("")]

    def clock(self, column: int) -> Floats:
        """A column of clock times as seconds, which go on over midnight; NaN where a cell is none.

        Where they have no date, a clock that goes back by more than `BACK` s has passed midnight.
        """
        found = self.cells[column].str.extract(_CLOCK_PARTS)
        hours, minutes = (found[number].astype(np.float64).to_numpy() for number in (0, 1))
        seconds = found[2].fillna("0").str.replace("[,:]", ".", regex=True).astype(np.float64).to_numpy()
        half = found[3].str.lower()
        hours = np.where(half.notna(), hours % 12.0 + 12.0 * (half == "p"), hours)
        of_day: Floats = 3600.0 * hours + 60.0 * minutes + seconds
        days = _days(self.cells[column])
        return of_day + DAY * (_midnights(of_day) if days is None else days)

    def is_clock(self, column: int) -> bool:
        """Whether a column holds times such as 07:15:02."""
        looked = [text for text in self.texts(column)[:LOOKED_AT] if text]
        return bool(looked) and sum(bool(_CLOCK.fullmatch(text)) for text in looked) > 0.5 * len(looked)


def read_sheet(path: Path) -> Sheet:
    """Read a text of rows and columns.

    Raises:
        CalibrationError: it cannot be read, is no text, or has no rows of numbers.
    """
    lines = [line for line in _text(path).splitlines() if line.strip()]
    if not lines:
        raise CalibrationError(f"{shown(path)} is empty; export the measurements again")
    separator, columns = _layout(path, lines)
    first = next((number for number, line in enumerate(lines) if _is_data(_split(line, separator), columns)), None)
    if first is None:
        raise CalibrationError(f"{shown(path)} has no row of numbers; export the log as text with a heading and rows")
    data = [line for line in lines[first:] if len(_split(line, separator)) == columns]
    for line in data:
        if '"' in line and _is_open(line, separator):
            raise CalibrationError(
                f"{shown(path)}: a quote is not closed in the row {quoted(line)}; close or delete it"
            )
    looked = [cell.strip() for line in data[:LOOKED_AT] for cell in _split(line, separator)]
    comma = separator != "," and sum(bool(_COMMA.fullmatch(cell)) for cell in looked) > sum(
        bool(_POINT.fullmatch(cell)) for cell in looked
    )
    cells = pandas.read_csv(
        io.StringIO("\n".join(data)),
        sep=r"\s+" if separator == " " else separator,
        header=None,
        names=range(columns),
        dtype=str,
        keep_default_na=True,
        skipinitialspace=True,
        on_bad_lines="skip",
    )
    headings = _headings([_split(line, separator) for line in lines[:first]], columns)
    return Sheet(path, headings, cells, comma, len(lines) - first - len(cells))


def _days(texts: Any) -> Floats | None:
    """The dates in a column of texts, in days; None if they have none.

    Where the order of day and month cannot be told, it is that in which the column is the shorter time.
    """
    dates = texts.str.extract(_DATE_PARTS)[0].str.replace(r"[/.]", "-", regex=True)
    if dates.isna().all():
        return None
    read = [pandas.to_datetime(dates, format=form, errors="coerce") for form in DATES]
    dated = [each for each in read if (each.notna() == dates.notna()).all()]
    if not dated:
        return None
    shortest = min(dated, key=lambda each: each.max() - each.min())
    days: Floats = ((shortest - shortest.min()) / pandas.Timedelta(days=1)).to_numpy(np.float64)
    return days


def _midnights(of_day: Floats) -> Floats:
    """How often midnight has passed before each time of day; rows may run backwards, and a few may be out of order."""
    passed = np.zeros(of_day.size)
    known = np.flatnonzero(np.isfinite(of_day))
    jumps = np.diff(of_day[known], prepend=of_day[known[:1]])
    way = 1.0 if (jumps < 0.0).sum() <= (jumps > 0.0).sum() else -1.0
    passed[known] = way * np.cumsum(np.where(way * jumps < -BACK, 1.0, np.where(way * jumps > DAY - BACK, -1.0, 0.0)))
    return passed


def plain(text: str) -> str:
    """A text in small letters without accents."""
    folded = unicodedata.normalize("NFKD", text.casefold().replace("µ", "u").replace("μ", "u"))
    return "".join(each for each in folded if not unicodedata.combining(each)).strip()


def _text(path: Path) -> str:
    try:
        data = read_bytes(path)
    except ReadError as error:
        raise CalibrationError(f"{error}; name a text file such as an export to CSV") from None
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    if data[:4] == b"PK\x03\x04" or b"\0" in data[:1000]:
        raise CalibrationError(f"{shown(path)} is no text; export it as CSV, for a spreadsheet file cannot be read")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def _split(line: str, separator: str) -> list[str]:
    return line.split() if separator == " " else line.split(separator)


def _is_open(line: str, separator: str) -> bool:
    """Whether a quote of a line is closed in none of its cells, so that the next line would belong to the last one."""
    try:
        rows = list(csv.reader([f"{line}\n", "next"], delimiter=separator, skipinitialspace=True))
    except csv.Error:  # a cell of more than 100,000 characters
        return True
    return len(rows) == 1


def _layout(path: Path, lines: Sequence[str]) -> tuple[str, int]:
    """What stands between columns, and how many there are."""
    middle = max((len(lines) - LOOKED_AT) // 2, 0)  # a text may begin with lines about itself
    looked = lines[middle : middle + LOOKED_AT]
    for separator in SEPARATORS:
        counted = Counter(len(_split(line, separator)) for line in looked)
        if not counted:
            break
        columns, often = counted.most_common(1)[0]
        if columns > MOST_COLUMNS:
            raise CalibrationError(
                f"{shown(path)} has {columns} columns between '{separator}'; export those that were measured, "
                f"{MOST_COLUMNS} at most"
            )
        if columns > 1 and often >= USUAL_SHARE * len(looked):
            return separator, columns
    raise CalibrationError(
        f"{shown(path)} has no columns; between them must stand ';', ',', '|', a tabulator or blanks, the same in all "
        "rows"
    )


def _is_data(cells: Sequence[str], columns: int) -> bool:
    """Whether a line is a row: of its cells that are not empty at least half are numbers or times."""
    filled = [cell.strip().strip('"') for cell in cells if cell.strip()]
    values = [cell for cell in filled if any(each.fullmatch(cell) for each in (_NUMBER, _CLOCK, _DATE))]
    return len(cells) == columns and bool(values) and 2 * len(values) >= len(filled)


def _headings(before: Sequence[Sequence[str]], columns: int) -> tuple[Heading, ...]:
    """What the lines before the first row call the columns."""
    named = [[cell.strip().strip('"') for cell in cells] for cells in before if len(cells) == columns]
    if not named:
        return tuple(Heading(f"column {number}", "") for number in range(1, columns + 1))
    units = [""] * columns
    if len(named) > 1 and all(UNITS.fullmatch(cell) for cell in named[-1]):
        units = [cell.strip("[]() ") for cell in named.pop()]
    return tuple(_heading(name, unit) for name, unit in zip(named[-1], units, strict=True))


def _heading(name: str, unit: str) -> Heading:
    """A name and its unit, which may stand behind it in brackets or after `/` or `_`."""
    match = _UNIT.match(name)
    if match and match[1]:
        return Heading(match[1], unit or match[2].strip())
    stem, _, end = re.sub(r"(?<=\S)(?: in |_|/)(?=[^ _/]*$)", "\0", name).partition("\0")
    if end and UNITS.fullmatch(end) and end not in "-":
        return Heading(stem.strip(), unit or end)
    return Heading(name, unit)
