"""A comparison with a record names every change, its first row and its size."""

import math
from pathlib import Path

import pytest

from tests.behaviour import record, tables
from tests.behaviour.tables import Table, additions, changes, differences, load, save, table

ROWS = [{"step": k, "text": f"N{k}", "power": 100.0 + k, "wear": 0.0 if k else None} for k in range(5)]
RECORDED = table(ROWS)


def changed(row: int, **values: object) -> Table:
    return table([{**each, **values} if k == row else each for k, each in enumerate(ROWS)])


def test_equal_tables_have_no_differences() -> None:
    assert differences(RECORDED, table(ROWS)) == []
    assert changes({"a": RECORDED}, {"a": table(ROWS)}) == []


def test_a_changed_column_is_reported_with_its_first_row_and_largest_relative_difference() -> None:
    found = changed(3, power=103.0 * (1.0 + 1e-9))
    found["power"][4] = 208.0
    (said,) = differences(RECORDED, found)
    assert said == (
        "power differs in 2 of 5 rows, first at step 3: was 103.0, is 103.000000103; "
        "the largest relative difference is 0.5"
    )


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"text": "N9"}, "text differs in 1 of 5 rows, first at step 1: was 'N1', is 'N9'"),
        ({"power": math.nextafter(101.0, 200.0)}, "the largest relative difference is 1.4e-16"),
        ({"power": None}, "was 101.0, is nan"),
        ({"power": math.inf}, "was 101.0, is inf"),
        ({"power": "much"}, "power differs in 5 of 5 rows, first at step 0: was 100.0, is '100.0'"),
        ({"wear": -0.0}, "was 0.0, is -0.0"),
    ],
)
def test_a_changed_cell_is_reported_down_to_the_last_bit_and_sign_of_zero(values: dict[str, object], said: str) -> None:
    (found,) = differences(RECORDED, changed(1, **values))
    assert said in found


def test_missing_rows_missing_columns_and_another_order_are_reported() -> None:
    assert differences(RECORDED, RECORDED[:4]) == ["5 rows are recorded, 4 are found"]
    assert differences(RECORDED, RECORDED[["step", "text", "wear"]]) == ["power is no longer there"]
    assert differences(RECORDED, RECORDED[["step", "power", "text", "wear"]]) == ["the columns are in another order"]
    assert changes({"a": RECORDED}, {"b": RECORDED}) == ["a: is recorded, but no longer there", "b: is not recorded"]


def test_new_columns_are_additions_and_not_differences() -> None:
    hotter = changed(1, heat=1.0)
    assert differences(RECORDED, hotter) == []
    assert additions({"a": RECORDED}, {"a": hotter, "b": hotter}) == ["a: heat is new"]
    assert differences(RECORDED, changed(1, heat=1.0, power=0.0)) and additions({"a": hotter}, {"a": RECORDED}) == []


def test_differences_are_sorted_by_their_first_row() -> None:
    names = [f"column {k}" for k in range(10)]
    was = table([dict.fromkeys(names, float(row)) for row in range(1, 4)])
    now = was.copy()
    for k, name in enumerate(names):
        now[name][2 if k < 5 else 1] *= 1.0 + 0.01 * k  # column 0 does not change
    said = differences(was, now)
    assert [sentence.partition(" differs")[0] for sentence in said[:5]] == names[5:]


def test_a_tolerance_hides_only_smaller_differences() -> None:
    near = changed(1, power=101.0 * (1.0 + 1e-10))
    assert differences(RECORDED, near, 1e-9) == [] and differences(RECORDED, near, 1e-12)
    assert differences(RECORDED, changed(1, power=None), 1e-9)


def test_the_record_command_saves_changes_and_prints_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tables, "RECORDS", tmp_path)
    assert load("keyway_g81") == {} and record.main(["keyway_g81"]) == 0
    assert "recorded anew" in capsys.readouterr().out
    first = (tmp_path / "keyway_g81.npz").read_bytes()
    was = load("keyway_g81")
    was["as it is: strokes"]["power"] *= 2.0
    save("keyway_g81", was)
    capsys.readouterr()
    assert record.main(["keyway_g81"]) == 0
    assert "as it is: strokes: power differs in" in capsys.readouterr().out
    assert (tmp_path / "keyway_g81.npz").read_bytes() == first
    was = load("keyway_g81")
    was["as it is: strokes"] = was["as it is: strokes"][
        [name for name in was["as it is: strokes"].dtype.names if name != "power"]
    ]
    save("keyway_g81", was)
    assert record.main(["keyway_g81"]) == 0
    told = capsys.readouterr().out
    assert "as recorded, with more columns" in told and "as it is: strokes: power is new" in told
    assert record.main(["keyway_g82"]) == 2 and "there is no keyway_g82" in capsys.readouterr().err


def test_every_environment_and_program_has_a_record_and_there_are_no_others() -> None:
    assert sorted(path.stem for path in tables.RECORDS.glob("*.npz")) == sorted(record.subjects())
