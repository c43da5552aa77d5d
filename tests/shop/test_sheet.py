"""Tables exported by shops are read to the right numbers, or refused."""

import time

import numpy as np
import pytest

from grind_env.process.catalogue import load_catalogue
from grind_env.shop.calibrate.column_names import Map, find_columns, read_map
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.gauged_parts import read_gauge
from grind_env.shop.calibrate.power_logs import read_log
from grind_env.shop.calibrate.table_calibration import calibrate_table
from grind_env.shop.measurements.measured_sheet import MOST_TIME, SheetError, read_sheet
from tests.shop.coverage import EXAMPLES

POWER = 1000.0 + 37.0 * (np.arange(60) % 7)
MACHINE = load_catalogue().machine("default")


def write_csv(tmp_path, rows, *, before=(), separator=";", encoding="utf-8"):
    path = tmp_path / "log.csv"
    path.write_bytes("\r\n".join([*before, *(separator.join(row) for row in rows)]).encode(encoding))
    return path


def test_swapped_and_repeated_rows_are_corrected(tmp_path):
    rows = [(f"{0.1 * k:.1f}", f"{p:.0f}") for k, p in enumerate(POWER)]
    rows[7], rows[8] = rows[8], rows[7]
    rows.insert(20, rows[20])
    rows.insert(30, ("", "1"))
    log = read_log(write_csv(tmp_path, [("time [s]", "power [W]"), *rows]), MACHINE, Map())
    np.testing.assert_allclose(log.time, 0.1 * np.arange(60), atol=1e-9)
    np.testing.assert_allclose(log.power, POWER)
    assert len(log.remarks) == 5


def test_a_clock_in_whole_seconds_is_spread_over_its_samples(tmp_path):
    rows = [(f"10:00:{k // 5:02d}", f"{p:.0f}") for k, p in enumerate(POWER)]
    log = read_log(write_csv(tmp_path, [("clock", "power [W]"), *rows]), MACHINE, Map())
    np.testing.assert_allclose(np.diff(log.time), 0.2)


@pytest.mark.parametrize(
    ("unit", "said", "watts"),
    [
        ("%", "rated_power = 9000", 90.0),
        ("A", "volts = 400\npower_factor = 0.8", 3**0.5 * 400 * 0.8),
        ("hp", "", 745.7),
    ],
)
def test_power_units_are_converted_to_watts(tmp_path, unit, said, watts):
    path = tmp_path / "map.toml"
    path.write_text(f"[log]\n{said}\n")
    rows = [(f"{k}", f"{20 + k % 5}") for k in range(60)]
    log = read_log(write_csv(tmp_path, [("time [s]", f"load [{unit}]"), *rows]), MACHINE, read_map(path))
    np.testing.assert_allclose(log.power, watts * (20 + np.arange(60) % 5))
    assert log.full == (9000.0 if unit == "%" else None)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([("time", "speed"), *((f"{k}", f"{k}") for k in range(60))], "no column of the power"),
        ([("time", "power"), *((f"{k}", f"{k % 5}") for k in range(9))], "9 rows"),
        ([("time", "power [lux]"), *((f"{k}", f"{k % 5}") for k in range(60))], "'lux'"),
    ],
)
def test_an_unusable_log_is_refused_in_one_sentence(tmp_path, rows, message):
    with pytest.raises((CalibrationError, SheetError), match=message) as caught:
        read_log(write_csv(tmp_path, rows), MACHINE, Map())
    assert "\n" not in str(caught.value)


def test_a_map_names_columns_and_a_misspelt_key_is_refused(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[log]\ntime = 1\npower = "kanal 2"\n')
    sheet = read_sheet(write_csv(tmp_path, [("kanal 1", "kanal 2"), ("1", "2"), ("2", "3")]))
    assert find_columns(sheet, "log", read_map(path)) == {"time": 0, "power": 1}
    path.write_text("[log]\npowr = 1\n")
    with pytest.raises(CalibrationError, match="did you mean power"):
        read_map(path)


def test_cells_of_the_gauge_file_may_be_empty(tmp_path):
    rows = [
        ("Teil", "Ra [µm]", "Abmaß [mm]", "Brand", "Scheibe mm"),
        ("1", "0,31", "", "nein", "299,81"),
        ("2", "", "0,002", "ja", ""),
    ]
    gauge = read_gauge(write_csv(tmp_path, rows), Map())
    np.testing.assert_array_equal(gauge.part, [1, 2])
    np.testing.assert_allclose(gauge.Ra, [0.31, np.nan])
    np.testing.assert_allclose(gauge.size, [np.nan, 2.0])
    np.testing.assert_allclose(gauge.burn, [0.0, 1.0])
    np.testing.assert_allclose(gauge.diameter, [299.81, np.nan])


@pytest.mark.parametrize("text", ["Ra\n0.31\n0.33\n", "Ra [µm]\n0,31\n\n0,33\n"])
def test_a_file_may_have_one_column(tmp_path, text):
    (tmp_path / "gauge.csv").write_text(text, encoding="utf-8")
    np.testing.assert_allclose(read_gauge(tmp_path / "gauge.csv", Map()).Ra, [0.31, 0.33])


@pytest.mark.parametrize(
    ("stamps", "steps"),
    [
        (("2026-11-03T23:59:59.500+01:00", "2026-11-04T00:00:01.000+01:00"), [1.5]),
        (("2026-11-03 14:00:00Z", "2026-11-03 14:00:02Z"), [2.0]),
        (("03.11.2026 17:00:00,5", "04.11.2026 07:00:00,5"), [50_400.0]),  # a night between two parts
        (("11/3/2026 5:00:00 PM", "11/4/2026 7:00:00 AM"), [50_400.0]),
        (("17:00:00", "17:00:01", "07:00:00", "07:00:01"), [1.0, 50_399.0, 1.0]),
        (("23:59:59", "00:00:01", "23:59:59.5", "00:00:02"), [2.0, -1.5, 2.5]),  # out of order at midnight
        (("00:00:01", "23:59:59", "23:59:58"), [-2.0, -1.0]),  # the newest row first
    ],
)
def test_a_clock_continues_over_midnight(tmp_path, stamps, steps):
    rows = [("time;power [W]"), *(f"{stamp};{1000 + k}" for k, stamp in enumerate(stamps))]
    (tmp_path / "log.csv").write_text("\n".join(rows), encoding="utf-8")
    sheet = read_sheet(tmp_path / "log.csv")
    assert sheet.is_clock(0)
    np.testing.assert_allclose(np.diff(sheet.clock(0)), steps)


def test_a_historian_s_export_is_read(tmp_path):
    rows = [("Timestamp", "Spindle power [W]", "Quality")]
    for k, each in enumerate(POWER):
        bad = k in (3, 20)
        second = k + (30 if k >= 40 else 0)
        stamp = f"2026-11-03T14:{second // 60:02d}:{second % 60:02d}.120+01:00"
        rows.append((stamp, ("n/a" if k == 3 else "---") if bad else f"{each:.1f}", "Bad" if bad else "Good"))
    log = read_log(write_csv(tmp_path, rows, before=("Historian export", ""), separator=","), MACHINE, Map())
    np.testing.assert_allclose(log.power, np.delete(POWER, [3, 20]))
    said = "; ".join(log.remarks)
    assert "nothing was taken from column 'Quality'" in said
    assert "2 rows without time or power were left out" in said
    assert "1 gap in the log, the longest of 31.0 s" in said


@pytest.mark.parametrize(
    ("said", "reason"), [('[log]\ntime_unit = "fortnight"', "log.time_unit is 'fortnight'"), ("[log]\nvolts = 400", "")]
)
def test_an_invalid_or_unused_map_entry_is_reported(tmp_path, said, reason):
    path = write_csv(tmp_path, [("time [s]", "power [W]"), *((f"{k}.0", f"{p:.1f}") for k, p in enumerate(POWER))])
    (tmp_path / "map.toml").write_text(said, encoding="utf-8")
    if reason:
        with pytest.raises(CalibrationError, match=reason):
            read_log(path, MACHINE, read_map(tmp_path / "map.toml"))
    else:
        remarks = read_log(path, MACHINE, read_map(tmp_path / "map.toml")).remarks
        assert "volts of the map had no effect on a power in W" in remarks


@pytest.mark.parametrize(
    ("number", "column"),
    [
        *(("99999999999999999999", column) for column in range(5)),
        *(("9" * 400, column) for column in range(5)),
        *((number, column) for number in ("1e308", "-1e308", "1e400") for column in range(1, 5)),
        ("9" * 5000, 0),
    ],
)
def test_an_impossible_number_is_refused_with_its_column(tmp_path, number, column):
    headings = ("part", "Ra [um]", "size [um]", "wheel [mm]", "time [s]")
    rows = [headings, *([str(k), "0.3", "2.0", "299.9", str(k)] for k in range(1, 9))]
    rows[4][column] = number
    path = write_csv(tmp_path, rows)
    with pytest.raises(SheetError, match="cannot have been measured; correct that cell") as caught:
        read_gauge(path, Map())
        read_sheet(path).numbers(4, beyond=MOST_TIME)
    assert repr(headings[column].split()[0]) in str(caught.value)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 400


@pytest.mark.parametrize("number", ["1e-320", "-0", "inf", "-"])
def test_a_setting_that_is_zero_infinite_or_empty_is_refused(tmp_path, number):
    headings = ("wheel_speed [m/s]", "table_speed [mm/min]", "downfeed [mm]", "power [W]")
    rows = [headings, *([f"{20 + k}", "9000", "0.01", f"{1000 + 100 * k}"] for k in range(4))]
    for column, name in ((0, "wheel_speed"), (1, "table_speed"), (2, "downfeed")):
        other = [list(row) for row in rows]
        other[3][column] = number
        with pytest.raises(CalibrationError, match=f"setting 3 has no {name}"):
            calibrate_table(write_csv(tmp_path, other), EXAMPLES / "plate_g82.toml", names=["ploughing_pressure"])


@pytest.mark.parametrize("value", ["inf", "nan", "1" + 400 * "0", "1e308", "0", "true"])
def test_an_impossible_rated_power_in_a_map_is_refused(tmp_path, value):
    path = tmp_path / "map.toml"
    path.write_text(f"[log]\nrated_power = {value}\n", encoding="utf-8")
    with pytest.raises(CalibrationError, match=r"log\.rated_power is .* must be a number above 0") as caught:
        read_map(path).number("log", "rated_power")
    assert len(str(caught.value)) < 400


def test_a_file_with_a_million_columns_is_refused_quickly_and_briefly(tmp_path):
    cells = ["1.5"] * 1_000_000
    began = time.process_time()
    with pytest.raises(SheetError, match="has 1000000 columns between ';'") as caught:
        read_log(write_csv(tmp_path, [[f"c{k}" for k in range(len(cells))], cells, cells]), MACHINE, Map())
    assert time.process_time() - began < 10.0
    assert len(str(caught.value)) < 400


def test_messages_name_a_few_columns_of_many(tmp_path):
    path = write_csv(tmp_path, [[f"column no. {k} {'x' * 200}" for k in range(100)], *([["1.5"] * 100] * 3)])
    with pytest.raises(CalibrationError, match="and 80 more") as caught:
        read_log(path, MACHINE, Map())
    assert len(str(caught.value)) < 2000
    (tmp_path / "map.toml").write_text('[log]\ntime = "t"\n', encoding="utf-8")
    with pytest.raises(CalibrationError, match="and 80 more") as caught:
        read_log(path, MACHINE, read_map(tmp_path / "map.toml"))
    assert len(str(caught.value)) < 2000


def test_an_empty_file_is_called_empty(tmp_path):
    (tmp_path / "log.csv").write_text("\n \n", encoding="utf-8")
    with pytest.raises(SheetError, match="is empty"):
        read_sheet(tmp_path / "log.csv")
