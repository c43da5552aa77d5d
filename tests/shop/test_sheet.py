"""Texts as shops export them, read to the numbers that stand in them."""

import numpy as np
import pytest

from grind_env.process.catalogue import load_catalogue
from grind_env.shop.calibrate.columns import Map, find_columns, read_map
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.gauge import read_gauge
from grind_env.shop.calibrate.logs import read_log
from grind_env.shop.calibrate.sheet import read_sheet

POWER = 1000.0 + 37.0 * (np.arange(60) % 7)
MACHINE = load_catalogue().machine("default")


def written(tmp_path, rows, *, before=(), separator=";", encoding="utf-8"):
    path = tmp_path / "log.csv"
    path.write_bytes("\r\n".join([*before, *(separator.join(row) for row in rows)]).encode(encoding))
    return path


@pytest.mark.parametrize(
    ("heading", "separator", "time", "power", "encoding"),
    [
        (("Zeit [s]", "Leistung [kW]"), ";", "{:.1f}", "{:.3f}", "utf-8"),
        (("Zeit [s]", "Leistung [kW]"), ";", "{:.1f}", "{:.3f}", "utf-16"),
        (("temps_ms", "puissance kW [kW]"), "\t", "{:.0f}", "{:.3f}", "cp1252"),
        (("t [s]", "P [W]"), ",", "{:.1f}", "{:.1f}", "utf-8-sig"),
        (("time [s]", "spindle power [W]"), "|", "{:.1f}", "{:.1f}", "utf-8"),
    ],
)
def test_a_log_is_read_whatever_its_layout(tmp_path, heading, separator, time, power, encoding):
    unit = 1.0 if "W]" in heading[1] and "kW" not in heading[1] else 1e-3
    tick = 1000.0 if "ms" in heading[0] else 1.0
    comma = separator == ";"
    rows = [heading]
    for k, each in enumerate(POWER):
        cells = time.format(tick * 0.5 * k), power.format(unit * each)
        rows.append(tuple(cell.replace(".", ",") for cell in cells) if comma else cells)
    log = read_log(written(tmp_path, rows, separator=separator, encoding=encoding), MACHINE, Map())
    np.testing.assert_allclose(log.time, 0.5 * np.arange(60))
    np.testing.assert_allclose(log.power, POWER, atol=0.51)


def test_lines_before_the_heading_and_a_line_of_units_are_no_rows(tmp_path):
    rows = [("Uhrzeit", "Drehzahl", "Leistung"), ("hh:mm:ss", "1/min", "kW")]
    rows[1] = ("hh:mm:ss", "-", "kW")
    rows += [
        (f"23:59:{50 + k:02d}" if k < 10 else f"00:00:{k - 10:02d}", "1910", f"{p / 1000:.3f}")
        for k, p in enumerate(POWER)
    ]
    log = read_log(written(tmp_path, rows, before=("Maschine 7", "Export;;")), MACHINE, Map())
    np.testing.assert_allclose(np.diff(log.time), 1.0)  # over midnight
    np.testing.assert_allclose(log.power, POWER, atol=0.51)


def test_rows_out_of_order_and_rows_twice_are_put_right(tmp_path):
    rows = [(f"{0.1 * k:.1f}", f"{p:.0f}") for k, p in enumerate(POWER)]
    rows[7], rows[8] = rows[8], rows[7]
    rows.insert(20, rows[20])
    rows.insert(30, ("", "1"))
    log = read_log(written(tmp_path, [("time [s]", "power [W]"), *rows]), MACHINE, Map())
    np.testing.assert_allclose(log.time, 0.1 * np.arange(60), atol=1e-9)
    np.testing.assert_allclose(log.power, POWER)
    assert len(log.remarks) == 5


def test_a_clock_coarser_than_the_log_is_spread(tmp_path):
    rows = [(f"10:00:{k // 5:02d}", f"{p:.0f}") for k, p in enumerate(POWER)]
    log = read_log(written(tmp_path, [("clock", "power [W]"), *rows]), MACHINE, Map())
    np.testing.assert_allclose(np.diff(log.time), 0.2)


@pytest.mark.parametrize(
    ("unit", "said", "watts"),
    [
        ("%", "rated_power = 9000", 90.0),
        ("A", "volts = 400\npower_factor = 0.8", 3**0.5 * 400 * 0.8),
        ("hp", "", 745.7),
    ],
)
def test_units_of_power(tmp_path, unit, said, watts):
    path = tmp_path / "map.toml"
    path.write_text(f"[log]\n{said}\n")
    rows = [(f"{k}", f"{20 + k % 5}") for k in range(60)]
    log = read_log(written(tmp_path, [("time [s]", f"load [{unit}]"), *rows]), MACHINE, read_map(path))
    np.testing.assert_allclose(log.power, watts * (20 + np.arange(60) % 5))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([("time", "speed"), *((f"{k}", f"{k}") for k in range(60))], "no column of the power"),
        ([("time", "power"), *((f"{k}", "3.2") for k in range(60))], "does not change"),
        ([("time", "power"), *((f"{k}", f"{k % 5}") for k in range(9))], "9 rows"),
        (
            [("time", "power A", "power B"), *((f"{k}", f"{k % 5}", f"{k % 3}") for k in range(60))],
            "may both be the power",
        ),
        ([("time", "power [lux]"), *((f"{k}", f"{k % 5}") for k in range(60))], "'lux'"),
        ([("nothing",)], "has no columns"),
    ],
)
def test_what_is_hopeless_is_refused_in_one_sentence(tmp_path, rows, message):
    with pytest.raises(CalibrationError, match=message) as caught:
        read_log(written(tmp_path, rows), MACHINE, Map())
    assert "\n" not in str(caught.value)


def test_a_map_says_what_no_heading_does(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[log]\ntime = 1\npower = "kanal 2"\n')
    sheet = read_sheet(written(tmp_path, [("kanal 1", "kanal 2"), ("1", "2"), ("2", "3")]))
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
    gauge = read_gauge(written(tmp_path, rows), Map())
    np.testing.assert_array_equal(gauge.part, [1, 2])
    np.testing.assert_allclose(gauge.Ra, [0.31, np.nan])
    np.testing.assert_allclose(gauge.size, [np.nan, 2.0])
    np.testing.assert_allclose(gauge.burn, [0.0, 1.0])
    np.testing.assert_allclose(gauge.diameter, [299.81, np.nan])
