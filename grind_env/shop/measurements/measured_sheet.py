"""A measured file with rows and columns, as machines, data loggers, gauges and spreadsheets export it.

Logs, gauge files, tables of settings and the measurements of `grind advise` are read here by the same rules. A cell
that is neither readable nor missing (`MISSING`) is reported; too many such cells are refused.
"""

import csv
import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Floats
from grind_env.errors import GrindError
from grind_env.files import ReadError, read_bytes, shown
from grind_env.message_text import quoted
from grind_env.shop.measurements.clock_times import CLOCK, DATE, clock_seconds

SEPARATORS = (";", "\t", "|", ",", " ")
MOST_COLUMNS, MOST_LINES = 1000, 20  #: greatest number of columns of a file, and of lines of a quoted cell
#: numbers that no measurement reaches in any unit, and no time reaches, even in ns since 1970
MOST_NUMBER, MOST_TIME = 1e12, 1e19
#: rows from which layout and marks are inferred: the last `LOOKED_AT` of the first `HEAD` lines
LOOKED_AT, HEAD = 200, 5000
USUAL_SHARE = 0.6  #: least share of the lines that a separator must divide into columns
#: share of unreadable cells, and number of them in consecutive rows, from which on a column is refused
BAD_SHARE, IN_A_ROW = 0.02, 3
MISSING = re.compile(r"(?i)-*|ol|o\.l\.|#n/?a|#nv|n/?a|nan|null|[-+]?inf")  #: text of a cell where nothing was measured
_MARKS = str.maketrans(
    {**dict.fromkeys("\u2212\u2013\u2014", "-"), **dict.fromkeys("\u00a0\u202f\u2009\u2007", " "), "’": "'"}
)
_UNIT = re.compile(r"^(.+?)\s*[\[(]([^\[\]()]*)[\])]\s*$")
#: cell of a line of units
UNITS = re.compile(
    r"(?i)[\[(]?\s*(ms|s|sec|sek|min|h|us|µs|w|kw|watt|hp|ps|%|a|amp|ampere|mm|µm|um|in|inch|m/min|mm/min|mm/s|m/s|-|°c"
    r"|n|(hh:)?mm:ss(\.\w+)?|)\s*[\])]?"
)
YES = re.compile("1([.,]0)?|true|y(es)?|on|ja?|ein|x|si?|o(ui)?|aan|burnt?|brand|nok|nio")
NO = re.compile("0([.,]0)?|false|no?|off|nein|aus|non|nee|uit|none|ok|io|keiner?")
MILLIMETRES = {"mm": 1.0, "um": 1e-3, "nm": 1e-6, "in": 25.4, "inch": 25.4, "uin": 25.4e-6}
MICROMETRES = {"um": 1.0, **{unit: 1e3 * factor for unit, factor in MILLIMETRES.items()}}
#: factors of units; the first unit is the default for a heading without a unit
WATTS = {"w": 1.0, "watt": 1.0, "kw": 1e3, "hp": 745.7, "ps": 735.5}


def _number_with(decimal: str, group: str) -> re.Pattern[str]:
    grouped = rf"[1-9]\d{{0,2}}(?:(?P<mark>[ '{group}])\d{{3}})(?:(?P=mark)\d{{3}})*(?:{decimal}\d*)?"
    return re.compile(rf"[-+]?(?:{grouped}|(?:\d+(?:{decimal}\d*)?|{decimal}\d+)(?:[eE][-+]?\d+)?)")


#: numbers by their decimal mark; thousands may be set apart by the other mark, blanks or apostrophes
NUMBERS = {".": _number_with(r"\.", ","), ",": _number_with(",", r"\.")}
_VALUES = (*NUMBERS.values(), CLOCK, re.compile(DATE))


class SheetError(GrindError):
    """Measured file that is no table, or cell that cannot be read."""


class _Record(NamedTuple):
    line: int
    cells: list[str]


class Heading(NamedTuple):
    """Name of a column, and its unit if one is stated."""

    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class Sheet:
    """Rows and columns of a file; a faulty cell gives a `SheetError` that names it."""

    path: Path  #: path of the file
    headings: tuple[Heading, ...]  #: headings of the columns; `column 1` and so on if the file has none
    rows: Sequence[Sequence[str]]  #: cells of each row, as texts
    lines: Sequence[int]  #: number of the line in the file where each row begins
    separator: str  #: separator of the columns
    remarks: list[str]  #: sentences on how the file was read; reading a column adds its own

    def texts(self, column: int) -> list[str]:
        return [row[column] for row in self.rows]

    def values(self, column: int) -> Floats:
        """Return a column as numbers; NaN where a cell is no number."""
        texts, unit = self.texts(column), self.headings[column].unit or "%"
        cells = {text: _plain(text).removesuffix(unit).rstrip() for text in set(texts)}
        decimal = self._decimal(column, cells)
        numbers = {text: _number(cell, decimal) for text, cell in cells.items()}
        return np.array([numbers[text] for text in texts], np.float64)

    def numbers(
        self, column: int, *, above: float = -np.inf, beyond: float = MOST_NUMBER, bad_share: float = BAD_SHARE
    ) -> Floats:
        """Return a column as numbers above `above` and below `beyond`; NaN where a cell is missing or was left out."""
        values = self.values(column)
        for row in np.flatnonzero(np.abs(values) >= beyond).tolist():
            raise self.not_measured(column, row)
        what = "a number" if np.isinf(above) else f"a number above {above:g}"
        return self.checked(column, np.where(values > above, values, np.nan), what, bad_share)

    def quantity(self, column: int, units: Mapping[str, float], **limits: float) -> Floats:
        """Return a column of `numbers` in the unit whose factor is 1."""
        return self.factor(column, units) * self.numbers(column, **limits)

    def factor(self, column: int, units: Mapping[str, float], said: object = None) -> float:
        """Return the factor of a column's unit: the unit that a map or the heading states, else the first one."""
        name, unit = self.headings[column]
        unit = unit if said is None else str(said)
        factor = units.get(plain(unit).replace("^", "") or next(iter(units)))
        if factor is None:
            raise SheetError(
                f"{shown(self.path)}: column {quoted(name)} is in {quoted(unit)}, but its unit must be one of "
                f"{', '.join(units)}; convert it"
            )
        return factor

    def flags(self, column: int) -> Floats:
        """Return a column of words as 1 for yes, 0 for no and NaN where a cell is missing or was left out."""
        words = [plain(text).strip(".") for text in self.texts(column)]
        flags = [1.0 if YES.fullmatch(word) else 0.0 if NO.fullmatch(word) else np.nan for word in words]
        return self.checked(column, np.array(flags), "yes or no")

    def clock(self, column: int) -> Floats:
        """Return a column of clock times in s; NaN where a cell is missing or was left out."""
        return self.checked(column, clock_seconds(self.texts(column)), "a time")

    def is_clock(self, column: int) -> bool:
        """Return whether a column holds times such as 07:15:02."""
        looked = [text for text in self.texts(column)[:LOOKED_AT] if text]
        return sum(CLOCK.fullmatch(text) is not None for text in looked) > 0.5 * len(looked)

    def checked(self, column: int, values: Floats, what: str, bad_share: float = BAD_SHARE) -> Floats:
        """Return the values of a column; a remark names a cell that is neither readable (NaN) nor missing.

        Too many such cells, or several in consecutive rows, are refused.
        """
        texts, name = self.texts(column), quoted(self.headings[column].name)
        unread = np.flatnonzero(np.isnan(values)).tolist()
        bad = [row for row in unread if not is_missing(texts[row])]
        if bad:
            several = f"{len(bad)} cells are not {what}, the first one" if len(bad) > 1 else f"the cell is not {what}:"
            said = f"column {name}: {several} {quoted(texts[bad[0]])} in row {self.lines[bad[0]]}"
            if _are_many(bad, values.size - len(unread) + len(bad), bad_share):
                raise SheetError(
                    f"{shown(self.path)}, {said}; correct or empty such cells, or delete rows that are no measurements"
                )
            self.remarks.append(f"{said}; left out")
        return values

    def not_measured(self, column: int, row: int) -> SheetError:
        """Return the error of a cell whose number cannot have been measured."""
        return SheetError(
            f"{shown(self.path)}, row {self.lines[row]}: {quoted(self.rows[row][column])} in column "
            f"{quoted(self.headings[column].name)} cannot have been measured; correct that cell, or leave it empty"
        )

    def _decimal(self, column: int, cells: Mapping[str, str]) -> str:
        """Return the decimal mark of a column: by its own cells, else by the other columns, else by the separator."""
        point, comma, either = _decimals(cells.values())
        if point or comma or not either:
            return "." if point >= comma else ","
        others = (row[k] for row in self.rows[:LOOKED_AT] for k in range(len(row)) if k != column)
        point, comma, _ = _decimals({_plain(text).rpartition(":")[2] for text in others})  # a clock may have decimals
        marks = {mark for text in either for mark in ".," if mark in text}
        decimal = "." if point > comma or (point == comma and (self.separator == "," or "," not in marks)) else ","
        row, example = next((row, text) for row, text in enumerate(self.texts(column)) if cells[text] in either)
        said = f"column {quoted(self.headings[column].name)}: {quoted(example)} in row {self.lines[row]}"
        whole = [len(cell.lstrip("+-")) for cell in cells.values() if cell.lstrip("+-").isdigit()]
        if point == comma and decimal in marks and (len(marks) > 1 or (3 in whole and max(whole) < 4)):
            digits = re.sub("[.,]", "", example)
            raise SheetError(
                f"{shown(self.path)}, {said} is {digits} or a number with decimals; write {digits} or {example}0"
            )
        if decimal not in example or point == comma:
            self.remarks.append(f"{said} is read as {_number(cells[example], decimal):g}")
        return decimal


def read_sheet(path: Path) -> Sheet:
    """Read a file of rows and columns; a `SheetError` says what is wrong with it."""
    text = read_measured(path)
    if not text.strip():
        raise SheetError(f"{shown(path)} is empty; export the measurements again")
    separator, columns = _layout(path, text)
    records = [record for record in _records(path, text, separator) if any(record.cells)]
    looked = _rows_of(records)
    filled = [[c.cells[k] for c in looked if k < len(c.cells) and not is_missing(c.cells[k])] for k in range(columns)]
    measured = [k for k, cells in enumerate(filled) if cells and 2 * sum(map(_is_value, cells)) >= len(cells)]
    first = next((k for k, record in enumerate(records) if _is_row(record.cells, measured)), None)
    if first is None:
        raise SheetError(f"{shown(path)} has no row of numbers; export the log as text with a heading and rows")
    named = [
        k
        for k in range(first)
        if sum(map(bool, records[k].cells)) >= min(columns, 2) and not any(map(_is_value, records[k].cells))
    ]
    if not named:
        return _sheet(path, [Heading(f"column {k + 1}", "") for k in range(columns)], records[first:], separator)
    names, units = records[named[-1]].cells, list[str]()
    if len(named) > 1 and len(names) == columns and all(map(UNITS.fullmatch, names)):
        names, units = records[named[-2]].cells, [cell.strip("[]() ") for cell in names]
    headings = [_heading(name, unit) for name, unit in zip_longest(names, units[: len(names)], fillvalue="")]
    return _sheet(path, headings, records[named[-1] + 1 :], separator)


def sheet_of(path: Path, text: str) -> Sheet | None:
    """Return the table of a text whose first row names the columns, with any number of rows; None for an empty text."""
    counts = {each: text.lstrip("\n").partition("\n")[0].count(each) for each in (",", *SEPARATORS[:3])}
    separator = max(counts, key=lambda each: counts[each])
    records = [record for record in _records(path, text, separator) if record.cells]
    names = [_heading(name, "") for name in records[0].cells] if records else []
    return _sheet(path, names, records[1:], separator, strict=True) if records else None


def read_measured(path: Path) -> str:
    """Return the text of a file in UTF-8, UTF-16 or a code of Windows; a `SheetError` says that the file is no text."""
    try:
        data = read_bytes(path)
    except ReadError as error:
        raise SheetError(f"{error}; name a text file such as an export to CSV") from None
    marked, zero = data[:2] in (b"\xff\xfe", b"\xfe\xff"), data[:4].find(b"\0")
    try:
        text = data.decode("utf-16" if marked else {-1: "utf-8-sig", 1: "utf-16-le"}.get(zero, "utf-16-be"))
    except UnicodeDecodeError:
        text = "\0" if marked or zero >= 0 else data.decode("cp1252", "replace")
    if data[:4] == b"PK\x03\x04" or "\0" in text[:1000]:
        raise SheetError(f"{shown(path)} is no text; export it as CSV, for a spreadsheet file cannot be read")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def plain(text: str) -> str:
    """Return a text in small letters without accents."""
    folded = unicodedata.normalize("NFKD", text.casefold().replace("µ", "u").replace("μ", "u"))
    return "".join(each for each in folded if not unicodedata.combining(each)).strip()


def _records(path: Path, text: str, separator: str) -> list[_Record]:
    """Return all rows; rows of blank lines have no cells."""
    lines, records, line = text.split("\n"), list[_Record](), 1
    joined = (" ".join(each.split()) if separator == " " else each for each in lines)
    reader = csv.reader(
        (f"{each}\n" for each in joined), delimiter=separator, skipinitialspace=separator != " ", strict=True
    )
    try:
        for cells in reader:
            if reader.line_num - line > MOST_LINES:
                raise csv.Error
            records.append(_Record(line, [cell.strip() for cell in cells]))
            line = reader.line_num + 1
    except csv.Error:
        raise SheetError(
            f"{shown(path)} is no table from row {line} on: a quote is not closed in the row {quoted(lines[line - 1])}"
            ", or its cells are too long; close or delete the quote"
        ) from None
    return records


def _sheet(
    path: Path, headings: Sequence[Heading], records: Sequence[_Record], separator: str, strict: bool = False
) -> Sheet:
    """Return the table of some rows; rows with more cells than headings are refused, or left out if they are few."""
    width = max((k + 1 for k, heading in enumerate(headings) if heading.name), default=0)
    wide = [k for k, record in enumerate(records) if any(record.cells[width:])]
    remarks = []
    if wide:
        line, cells = records[wide[0]]
        said = f"{shown(path)}, row {line} has {len(cells)} cells, but the header {width}"
        if strict or _are_many(wide, len(records)):
            raise SheetError(f"{said}: name every column, and put cells that contain '{separator}' into quotes")
        remarks.append(f"{said}; {len(wide)} such rows were left out")
    kept = [record for record in records if not any(record.cells[width:])]
    rows = [(*record.cells[:width], *[""] * (width - len(record.cells))) for record in kept]
    return Sheet(path, tuple(headings[:width]), rows, [record.line for record in kept], separator, remarks)


def _layout(path: Path, text: str) -> tuple[str, int]:
    """Return the separator of the columns, and the number of columns."""
    head = re.sub(r'"[^"]*"', "0", "\n".join(text.split("\n", HEAD)[:HEAD])).split("\n")
    looked, layouts = _rows_of([line for line in head if line.strip()]), list[tuple[float, str, int]]()
    for separator in SEPARATORS:
        rows = [line.split() if separator == " " else line.split(separator) for line in looked]
        rows = [cells for cells in rows if len(cells) > 1]
        if len(rows) < USUAL_SHARE * len(looked):
            continue
        columns = Counter(map(len, rows)).most_common(1)[0][0]
        if columns > MOST_COLUMNS:
            raise SheetError(
                f"{shown(path)} has {columns} columns between '{separator}'; export those that were measured, "
                f"{MOST_COLUMNS} at most"
            )
        values = [_is_value(cell) or is_missing(cell) for cells in rows for cell in cells]
        layouts.append((sum(values) / len(values), separator, columns))
    if _is_one_column(head, looked, {separator for _, separator, _ in layouts}):
        return "\t", 1
    if not layouts:
        raise SheetError(
            f"{shown(path)} has no columns; between them must stand ';', ',', '|', a tabulator or blanks, the same in "
            "all rows"
        )
    return max(layouts, key=lambda layout: layout[0])[1:]


def _is_one_column(head: Sequence[str], looked: Sequence[str], separators: Collection[str]) -> bool:
    """Return whether lines that `separators` could divide are numbers; if by ',', only under a heading with a unit."""
    numbers = all(_is_value(line.strip()) or is_missing(line.strip()) for line in looked)
    heading = next((line for line in reversed(head) if line.strip() and not _is_value(line.strip())), ",")
    has_unit = "," not in heading and _heading(heading, "").unit != ""
    return numbers and (not separators or (has_unit and {*separators} == {","}))


def _rows_of(lines: Sequence[Any]) -> Sequence[Any]:
    """Return some lines that are rows, without lines of description at the beginning of a file."""
    head = lines[:HEAD]
    return head[len(head) // 2 :][-LOOKED_AT:]


def is_missing(cell: str) -> bool:
    """Return whether a cell says that nothing was measured."""
    return MISSING.fullmatch(_plain(cell)) is not None


def _is_value(cell: str) -> bool:
    return any(each.fullmatch(_plain(cell).removesuffix("%")) for each in _VALUES)


def _is_row(cells: Sequence[str], measured: Sequence[int]) -> bool:
    """Return whether every measured column has a value or is missing, and at least one has a value."""
    filled = [cells[k] for k in measured if k < len(cells) and not is_missing(cells[k])]
    return bool(filled) and all(map(_is_value, filled))


def _are_many(rows: Sequence[int], among: int, share: float = BAD_SHARE) -> bool:
    """Return whether bad rows are too many among all, or several of them are consecutive."""
    in_a_row = any(last - first < IN_A_ROW for first, last in zip(rows, rows[IN_A_ROW - 1 :], strict=False))
    return in_a_row or len(rows) >= share * among


def _plain(cell: str) -> str:
    """Return a cell with typographic minus signs, blanks and apostrophes replaced by those of a keyboard."""
    return cell if cell.isascii() else cell.translate(_MARKS).strip()


def _number(cell: str, decimal: str) -> float:
    """Return a plain cell as a number; NaN if it is none."""
    if not NUMBERS[decimal].fullmatch(cell):
        return np.nan
    grouping = "," if decimal == "." else "."
    return float(cell.replace(grouping, "").replace(" ", "").replace("'", "").replace(decimal, "."))


def _decimals(cells: Collection[str]) -> tuple[int, int, set[str]]:
    """Return how many plain cells need a decimal point, how many a comma, and the cells that may have either."""
    point, comma = ({cell for cell in cells if NUMBERS[mark].fullmatch(cell)} for mark in ".,")
    return len(point - comma), len(comma - point), {cell for cell in point & comma if "." in cell or "," in cell}


def _heading(name: str, unit: str) -> Heading:
    """Return a name and its unit, which may stand behind it in brackets or after `,`, `/` or `_`."""
    match = _UNIT.match(name)
    if match:
        return Heading(match[1], unit or match[2].strip())
    stem, _, end = re.sub(r"(?<=\S)(?: in |, ?|_|/)(?=[^ _/,]*$)", "\0", name).partition("\0")
    if end and UNITS.fullmatch(end) and end not in "-":
        return Heading(stem.strip(), unit or end)
    return Heading(name, unit)
