"""Files of loggers, gauges and spreadsheets are read correctly, or refused with place and remedy."""

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.process.catalogue import load_catalogue
from grind_env.shop.advise.operator_readings import readings_of
from grind_env.shop.advise.reading_sources import CsvSource, ReadingsRow
from grind_env.shop.calibrate.column_names import Map
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.gauged_parts import read_gauge
from grind_env.shop.calibrate.power_logs import read_log
from grind_env.shop.calibrate.table_calibration import calibrate_table
from grind_env.shop.measurements.measured_sheet import SheetError
from tests.shop.advising import rows_of
from tests.shop.coverage import EXAMPLES

SAMPLE = Path(grind_env.__file__).parent / "shop" / "start"
MACHINE = load_catalogue().machine("default")
#: seconds and W of the log that `grind init` writes
TIMES, POWERS = zip(
    *(row.split(",") for row in (SAMPLE / "log.csv").read_text(encoding="utf-8").splitlines()[1:]), strict=True
)
SECONDS, WATTS = np.array(TIMES, float), np.array(POWERS, float)
LOW = [f"{watts - 700:.0f}" for watts in WATTS]  #: powers with only the peaks above 1000 W
NBSP, NARROW = "\u00a0", "\u202f"


def grouped(mark: str, powers: Iterable[str]) -> list[str]:
    return [f"{int(power):,}".replace(",", mark) for power in powers]


def comma(numbers: Iterable[str]) -> list[str]:
    return [number.replace(".", ",") for number in numbers]


def text_of(separator: str, heading: str, *columns: Iterable[str]) -> str:
    return "\n".join([heading, *(separator.join(cells) for cells in zip(*columns, strict=True))]) + "\n"


def minutes(seconds: float) -> str:
    """Return a time as a spreadsheet shows it by mm:ss.0, which restarts at 00:00.0 every hour."""
    tenths = round(10.0 * seconds) + 35_861  # 59:46.1
    return f"{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


TABLE = """table_speed [m/min];downfeed [um];volume;Ft [N/mm];Fn [N/mm];Ra [um]
8;5;200;2.36;5.34;0.31
8;5;{};5.15;12.32;0.35
8;15;200;4.51;10.17;0.42
20;5;{};7.15;17.32;0.40
"""


@pytest.mark.parametrize("volume", ["~1200", "1_200", "±1200", "<1200", "1200 mm"])
def test_a_volume_that_is_no_number_is_refused(volume: str, tmp_path: Path) -> None:
    with pytest.raises(SheetError, match=re.escape(repr(volume)) + ".* in row 3"):
        calibrate_table(write(tmp_path / "table.csv", TABLE.format(volume, volume)), EXAMPLES / "plate_g82.toml")


def test_one_invalid_volume_among_many_is_refused(tmp_path: Path) -> None:
    rows = ["downfeed [um];volume;Ra", *["5;40;.3"] * 150]
    rows[70] = "5;~40;.3"
    write(tmp_path / "table.csv", "\n".join(rows))
    with pytest.raises(SheetError, match="column 'volume': the cell is not a number: '~40' in row 71"):
        calibrate_table(tmp_path / "table.csv", EXAMPLES / "plate_g82.toml", names=["roughness"])


ROWS = 300
SHORT, LOADS = TIMES[:ROWS], LOW[:ROWS]
HEAD = "Time [s],Power [W]"
PLAIN = text_of(",", HEAD, SHORT, LOADS)
DAYS = [f"{46353.5964814815 + seconds / 86_400.0:.10f}" for seconds in SECONDS[:ROWS]]
MICROSECONDS = [f"{1_795_789_136_000_000 + round(1e6 * seconds)}" for seconds in SECONDS[:ROWS]]


def changed(text: str, **lines: str) -> str:
    """Return a text with some lines replaced, by their numbers: `r17="..."`."""
    rows = text.split("\n")
    for name, line in lines.items():
        rows[int(name[1:]) - 1] = line
    return "\n".join(rows)


#: logs of which every row is read
RIGHT: dict[str, bytes | str] = {
    # from public bug reports about other tools
    "thousands quoted": text_of(",", HEAD, SHORT, (f'"{each}"' for each in grouped(",", LOADS))),
    "thousands with no-break spaces": text_of(";", "Time [s];Power [W]", SHORT, grouped(NBSP, LOADS)),
    "thousands with apostrophes": text_of(";", "Time [s];Power [W]", SHORT, grouped("'", LOADS)),
    "thousands with narrow spaces": text_of(";", "Time [s];Power [W]", comma(SHORT), grouped(NARROW, LOADS)),
    "thousands with points": text_of(";", "Zeit [s];Leistung [W]", comma(SHORT), grouped(".", LOADS)),
    "a heading with a comma": text_of(",", '"Time [s]","Power, spindle [W]"', SHORT, LOADS),
    "a note with a comma": text_of(",", HEAD + ",Note", SHORT, LOADS, ['"idle, warm"'] * ROWS),
    "day numbers": text_of(";", "Time;Power [W]", comma(DAYS), LOADS),
    "mm:ss.s": text_of(",", "time,power (W)", map(minutes, SECONDS[:ROWS]), LOADS),
    "microseconds": text_of(",", "timestamp,power [W]", MICROSECONDS, LOADS),
    # further habits of loggers and spreadsheets
    "semicolons, decimal commas and a thousands point": text_of(
        ";",
        "Zeit [s];Leistung [W]",
        comma(SHORT),
        (f"{int(power):,}.0".translate(str.maketrans(",.", ".,")) for power in LOADS),
    ),
    "UTF-16 with a mark": PLAIN.encode("utf-16"),
    "UTF-16 without a mark": PLAIN.encode("utf-16-le"),
    "UTF-16, big end first": PLAIN.encode("utf-16-be"),
    "UTF-8 with a mark": PLAIN.encode("utf-8-sig"),
    "Latin-1": text_of(";", "Zeit [s];Leistung für Prüfung [W]", comma(SHORT), LOADS).encode("cp1252"),
    "ends of lines of an old Macintosh": PLAIN.replace("\n", "\r"),
    "a note of two lines in quotes": text_of(",", HEAD + ",Note", SHORT, LOADS, ['"idle,\nwarm"'] * ROWS),
    "a quote in a quoted note": text_of(",", HEAD + ",Note", SHORT, LOADS, ['"5"" wheel"'] * ROWS),
    "a row of units": text_of(";", "Zeit;Leistung\ns;W", comma(SHORT), LOADS),
    "a heading twice that is not needed": text_of(",", HEAD + ",X,X", SHORT, LOADS, SHORT, SHORT),
    "empty columns at the end": text_of(",", HEAD + ",,", SHORT, [f"{power},," for power in LOADS]),
    "empty columns at the end of the rows only": text_of(",", HEAD, SHORT, [f"{power},," for power in LOADS]),
    "lines about the export": "sep=,\nMachine,7\nInterval,0.1\nExport,2026-11-03\n\n" + PLAIN,
    "bars between the cells": text_of("|", "t [ms]|P [W]", (f"{100 * k}" for k in range(ROWS)), LOADS),
    "exponents": text_of(",", HEAD, SHORT, (f"{float(power):.3e}" for power in LOADS)),
    "blanks and decimal commas": text_of("   ", "Time[s] Power[W]", comma(SHORT), (f"{power},0" for power in LOADS)),
    "a unit behind every number": text_of(",", HEAD, SHORT, (f"{power} W" for power in LOADS)),
    "a unit behind every thousand": text_of(
        ";", HEAD.replace(",", ";"), comma(SHORT), (f"{p} W" for p in grouped(".", LOADS))
    ),
    "plus signs and points without digits": text_of(",", HEAD, SHORT, (f"+{power}." for power in LOADS)),
    "dates": text_of(
        ",",
        "Date,Power [W]",
        (f"03-Nov-2026 02:10:{float(each):04.1f}" if float(each) < 60 else each for each in SHORT),
        LOADS,
    ),
    "milliseconds since 1970": text_of(
        ",", "t,Power [W]", (f"{1_795_789_136_000 + 100 * k}" for k in range(ROWS)), LOADS
    ),
    "a clock set back once": text_of(
        ",", "Clock,Power [W]", (f"02:{59 if k < 150 else 29}:{k // 10 + 20:02d}.{k % 10}" for k in range(ROWS)), LOADS
    ),
    "minutes and seconds": text_of(
        ",", "t,Power [W]", (f"{k // 600:02d}:{k // 10 % 60:02d}" for k in range(ROWS)), LOADS
    ),
    "the newest row first": text_of(",", HEAD, SHORT[::-1], LOADS[::-1]),
}
#: logs with faulty rows: text, number of rows missing from the result, remark
LESS: dict[str, tuple[str, int, str]] = {
    "a last line of words": (
        PLAIN + "End of export,\n",
        0,
        "the cell is not a time|number: 'End of export' in row 302",
    ),
    "a mean at the end": (PLAIN + "Mean,800\n", 0, "'Mean' in row 302; left out"),
    "a cell of words": (
        changed(PLAIN, r17="1.5,fault"),
        1,
        "column 'Power': the cell is not a number: 'fault' in row 17",
    ),
    "two limits": (
        changed(PLAIN, r17="1.5,<5", r90="8.8,±3"),
        2,
        "2 cells are not a number, the first one '<5' in row 17",
    ),
    "known marks": (
        changed(PLAIN, r9="0.7,OL", r17="1.5,#N/A", r30="2.8,-", r31="2.9,NaN"),
        4,
        "4 rows without time or power",
    ),
    "a comma too many": (
        changed(PLAIN, r17="1.5,787,5"),
        1,
        "row 17 has 3 cells, but the header 2; 1 such rows were left out",
    ),
    "the heading again": (changed(PLAIN, r100=HEAD), 1, "in row 100; left out"),
    "a decimal comma in a column of points": (
        changed(text_of(";", HEAD.replace(",", ";"), SHORT, (f"{power}.5" for power in LOADS)), r50="4.8;7,5"),
        1,
        "'7,5' in row 50",
    ),
}
REFUSED: dict[str, tuple[str, str]] = {
    "decimal commas between commas": (
        text_of(",", HEAD, comma(SHORT), LOADS),
        "row 2 has 3 cells, but the header 2: name every column, and put cells",
    ),
    "words in a row": (
        changed(PLAIN, r17="1.5,x", r18="1.6,x", r19="1.7,x"),
        "3 cells are not a number, the first one 'x' in row 17",
    ),
    "many limits": (
        text_of(",", HEAD, SHORT, (f"<{p}" if k % 40 == 9 else p for k, p in enumerate(LOADS))),
        "the first one '<",
    ),
    "plus or minus": (
        text_of(",", HEAD, SHORT, (f"{power}±5" for power in LOADS)),
        "300 cells are not a number, the first one '787±5'",
    ),
    "an unknown mark of thousands": (
        text_of(",", HEAD, SHORT, grouped("*", POWERS[:ROWS])),
        r"'1\*487' in row 2; correct or empty",
    ),
    "787 beside 1.487": (
        text_of(
            ";",
            "Time;Power [W]",
            map(str, range(ROWS)),
            [*(f"{700 + k % 90}" for k in range(ROWS - 2)), "1.487", "2.034"],
        ),
        "'1.487' in row 300 is 1487 or a number with decimals; write 1487 or 1.4870",
    ),
    "a heading twice": (
        text_of(",", "Time [s],Power [W],Power [W]", SHORT, LOADS, LOADS),
        "may both be the power; say which",
    ),
    "a clock set back twice": (
        text_of(",", HEAD, (f"{k % 100 / 10}" for k in range(ROWS)), LOADS),
        "the clock was set back 2 times, first in row 102",
    ),
    "an open quote": (changed(PLAIN, r17='1.5,"787'), "from row 17 on: a quote is not closed in the row '1.5,"),
    "a spreadsheet": ("PK\x03\x04" + PLAIN, "is no text; export it as CSV"),
    "a stamp that is none": (text_of(",", "Time,Power [W]", (f"{each} s later" for each in SHORT), LOADS), "in row 2"),
    "words": ("Power\n" * ROWS, "has no columns; between them must stand"),
    "one column": ("Power [W]\n" + "\n".join(LOADS), "no column of the time among Power; say which"),
}


def write(path: Path, content: bytes | str) -> Path:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("case", RIGHT)
def test_an_unusual_log_is_read_completely(case: str, tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "log.csv", RIGHT[case]), MACHINE, Map())
    np.testing.assert_allclose(log.time - log.time[0], SECONDS[:ROWS], atol=1e-4)
    np.testing.assert_allclose(log.power, np.array(LOADS, float))


@pytest.mark.parametrize("case", LESS)
def test_faulty_rows_are_left_out_and_named_in_a_remark(case: str, tmp_path: Path) -> None:
    text, fewer, remark = LESS[case]
    log = read_log(write(tmp_path / "log.csv", text), MACHINE, Map())
    assert re.search(remark, "; ".join(log.remarks)), log.remarks
    assert log.time.size == ROWS - fewer and set(log.power) <= set(WATTS[:ROWS] - 700.0) | set(WATTS[:ROWS] - 699.5)


@pytest.mark.parametrize("case", REFUSED)
def test_an_ambiguous_or_damaged_log_is_refused(case: str, tmp_path: Path) -> None:
    text, reason = REFUSED[case]
    with pytest.raises((CalibrationError, SheetError), match=reason) as caught:
        read_log(write(tmp_path / "log.csv", text), MACHINE, Map())
    assert "\n" not in str(caught.value) and "log.csv" in str(caught.value) and len(str(caught.value)) < 400


def test_a_log_without_a_heading_needs_a_map(tmp_path: Path) -> None:
    text = PLAIN.replace(HEAD, "# exported by logger 7\n# channel 3; range 2")
    with pytest.raises(CalibrationError, match="no column of the time among column 1, column 2; say which"):
        read_log(write(tmp_path / "log.csv", text), MACHINE, Map())
    log = read_log(tmp_path / "log.csv", MACHINE, Map(None, {"log": {"time": 1, "power": 2}}))
    np.testing.assert_allclose(log.power, np.array(LOADS, float))


PARTS = "Part no.;Size, deviation [um];Ra [um];Burn\n1;−1,3;0,24;no\n2;-1,0;0,25;no\n3;;0,26;yes\n"


@pytest.mark.parametrize(
    "text",
    [
        PARTS,
        PARTS.replace(";", "\t"),
        '"Part no.","Size, deviation [um]","Ra [um]",Burn\n"1","-1.3","0.24",no\n"2","-1.0",.25,no\n3,-,"0.26",yes\n',
        PARTS.replace("Ra [um]", "Ra [nm]")
        .replace("0,2", "2")
        .replace(";24;", ";240;")
        .replace(";25;", ";250;")
        .replace(";26;", ";260;"),
        PARTS.replace("[um];Ra", "[mm];Ra").replace("−1,3", "−0,0013").replace("-1,0", "-0,001"),
        PARTS + ";;;\n;;;\n",
    ],
)
def test_gauge_files_are_read_in_several_formats(text: str, tmp_path: Path) -> None:
    gauge = read_gauge(write(tmp_path / "gauge.csv", text), Map())
    np.testing.assert_array_equal(gauge.part, [1, 2, 3])
    np.testing.assert_allclose(gauge.size, [-1.3, -1.0, np.nan])
    np.testing.assert_allclose(gauge.Ra, [0.24, 0.25, 0.26])
    np.testing.assert_array_equal(gauge.burn, [0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("0,25", "<0,25", "column 'Ra': the cell is not a number above 0: '<0,25' in row 3"),
        ("0,25", "0", "column 'Ra': the cell is not a number above 0: '0' in row 3"),
        ("yes", "perhaps", "column 'Burn': the cell is not yes or no: 'perhaps' in row 4"),
        ("Ra [um]", "Ra [mu]", "column 'Ra' is in 'mu', but its unit must be one of um"),
        ("3;;", "Mean;;", "column 'Part no.': the cell is not a part: 'Mean' in row 4"),
    ],
)
def test_an_invalid_gauge_cell_or_unit_is_refused(old: str, new: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises((CalibrationError, SheetError), match=re.escape(reason)):
        read_gauge(write(tmp_path / "gauge.csv", PARTS.replace(old, new)), Map())


MEASURED = "block,peak_power,size_error,D\n1,2400.5,,1\n2,,-1.5,0\n"
WANTED = [{"block": 1, "peak_power": 2400.5, "D": 1}, {"block": 2, "size_error": -1.5, "D": 0}]


@pytest.mark.parametrize(
    "text",
    [
        MEASURED,
        MEASURED.replace("peak_power", "peak_power [kW]").replace("2400.5", "2.4005"),
        MEASURED.replace("size_error", "size_error [mm]").replace("-1.5", "−0.0015"),
        MEASURED.replace(",", "\t"),
        MEASURED.replace("2400.5", '"2,400.5"'),
        MEASURED.replace(",", ";").replace("2400.5", f"2{NARROW}400,5").replace("-1.5", "-1,5"),
        MEASURED.replace("2,,", "2,OL,").replace("2400.5,,", "2400.5,#N/A,"),
    ],
)
def test_adviser_readings_are_read_in_several_formats(text: str, tmp_path: Path) -> None:
    assert rows_of(tmp_path / "m.csv", text) == WANTED
    write(tmp_path / "m.csv", text.encode("utf-16"))
    assert [readings_of(row.table, "").given() for row in all_rows(tmp_path / "m.csv")] == WANTED


def all_rows(path: Path) -> list[ReadingsRow]:
    source = CsvSource(path, follow=False)
    return list(iter(lambda: source.next(""), None))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("2400.5", "±2400", "row 2: peak_power is '±2400', but must be a number"),
        ("-1.5", "<1.5", "row 3: size_error is '<1.5', but must be a number"),
        ("peak_power", "peak_power [lux]", "column 'peak_power' is in 'lux', but its unit must be one of w"),
        ("2400.5,,1", "2400.5,,1,7", "row 2 has 5 cells, but the header 4"),
        ("2400.5", '"2400.5', "from row 2 on: a quote is not closed in the row '1,"),
    ],
)
def test_an_invalid_readings_file_is_refused(old: str, new: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(GrindError, match=re.escape(reason)):
        rows_of(tmp_path / "m.csv", MEASURED.replace(old, new))
