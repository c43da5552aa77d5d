import csv
from pathlib import Path

import pytest

from grind_env.optional_libraries import MissingExtra
from tests.machine.harness import CYCLE, HEAD, job, run


def test_csv_has_every_number_rounded_and_its_unit_in_the_header(tmp_path: Path) -> None:
    record = run(HEAD + CYCLE + "M30\n", job())
    record.write(tmp_path / "strokes.csv")
    with (tmp_path / "strokes.csv").open() as file:
        rows = list(csv.DictReader(file))
    headers = list(rows[0])
    assert [header.partition(" [")[0] for header in headers] == list(record.strokes.dtype.names or ())
    assert {"time [s]", "E [mm/min]", "Fn [N/mm]", "load [W]", "vs [m/s]", "Ra [um]", "A", "line"} <= set(headers)
    for header in headers:
        exact = record.strokes[header.partition(" [")[0]]
        assert [float(row[header]) for row in rows] == pytest.approx(exact, rel=1e-5, abs=5e-4)
        assert all(len(row[header].lstrip("-0.").replace(".", "").partition("e")[0]) <= 8 for row in rows)
    assert [path.name for path in tmp_path.iterdir()] == ["strokes.csv"]


def test_parquet_and_data_frame_return_every_number(tmp_path: Path) -> None:
    import pandas

    record = run(HEAD + CYCLE + "M30\n", job())
    record.write(tmp_path / "strokes.parquet")
    frame = record.to_dataframe()
    written = pandas.read_parquet(tmp_path / "strokes.parquet")
    assert [column.partition(" [")[0] for column in frame] == list(written)
    pandas.testing.assert_frame_equal(written, frame.set_axis(list(written), axis=1))
    assert list(frame["T [K]"]) == list(record.strokes["T"])


def test_csv_needs_no_pandas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for name in ("pandas", "pyarrow"):
        monkeypatch.setitem(sys.modules, name, None)
    record = run(HEAD + CYCLE + "M30\n", job())
    record.write(tmp_path / "strokes.csv")
    with pytest.raises(MissingExtra, match="pandas"):
        record.to_dataframe()
    with pytest.raises(MissingExtra, match="pyarrow"):
        record.write(tmp_path / "strokes.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["strokes.csv"]
