"""Invalid input of `grind advise`: one sentence names place and remedy, and the exit status is 2."""

import json
from pathlib import Path

import pytest

from tests.command import Grind
from tests.examples import nightly
from tests.shop.advising import DRESS, EXECUTED, plate_in

LOG = "mean_power,size_error\n2500,\n"


def refusal(grind: Grind, folder: Path, *words: object, log: str | bytes = LOG) -> str:
    """Return the sentence with which `grind advise` refuses these options or this log."""
    measured = folder / "m.csv"
    measured.write_bytes(log if isinstance(log, bytes) else log.encode())
    program = plate_in(folder)
    status, _, err = grind("advise", program, "--parts", 2, "--restart", "--measurements", measured, *words)
    assert status == 2 and "Traceback" not in err
    assert err.startswith("grind: ") and err.count("\n") == 1, err
    return err


@pytest.mark.parametrize(
    "bounds", [("nan", "20"), ("inf", "inf"), ("-5", "20"), ("10", "10"), ("20", "10"), ("1e400", "2")]
)
def test_invalid_bounds_are_refused(bounds: tuple[str, str], grind: Grind, tmp_path: Path) -> None:
    said = refusal(grind, tmp_path, "--bounds", *bounds)
    assert "--bounds are" in said and "must lie between 3000 and 30000 mm/min, in order" in said


@pytest.mark.parametrize("step", ["nan", "inf", "-inf", "0", "-1", "1", "101", "1e308", "9" * 400])
def test_an_invalid_step_is_refused(step: str, grind: Grind, tmp_path: Path) -> None:
    assert "must be a factor above 1 and at most 100: try 1.25" in refusal(grind, tmp_path, "--max-step", step)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--max-step", "2", "--policy", "handbook"), "--max-step is of the default adviser: leave out"),
        (("--shadow", "--policy", "handbook"), "handbook has none: leave out --policy"),
        (("--shadow", "--write", "v.nc"), "--shadow looks on while others decide, and --write decides: leave one"),
    ],
)
def test_incompatible_options_are_refused(
    words: tuple[str, ...], said: str, grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert said in refusal(grind, tmp_path, *words)
    assert not (tmp_path / "v.nc").exists()


def test_a_shadow_is_refused_for_a_program_without_forecasts(grind: Grind, tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    program.write_text(EXECUTED + DRESS)
    assert "compares forecasts, and adviser has none" in grind("advise", program, "--parts", 2, "--shadow")[2]


@pytest.mark.parametrize("shadow", [(), nightly(("--shadow",))])
@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("2500,3\n2600,4\n", "row 2: there is no reading '2500': the readings are block"),
        ("mean_power\n" + "9" * 5000 + "\n", "(5002 characters), but must be a number"),
        ("mean_power\n" + "x" * 200_000 + "\n", "m.csv is no table"),
        (",".join(["mean_power"] * 50_000) + "\n", "has more than one column 'mean_power': leave one of them"),
        ("mean_power\n25\x0000\n", "m.csv is no text; export it as CSV"),
        ("mean_power,Ra\n,\n,-1\n", "row 3: Ra is -1, but must lie between 0 and 50 um"),
        (b"\xff\xfe\x00mean", "m.csv is no text; export it as CSV"),
    ],
)
def test_invalid_logs_are_refused(
    log: str | bytes, said: str, shadow: tuple[str, ...], grind: Grind, tmp_path: Path
) -> None:
    assert said in refusal(grind, tmp_path, *shadow, log=log)


@pytest.mark.parametrize("log", ["", "\n", "mean_power\n", "\n" * 10_000])
def test_a_log_without_rows_gives_only_the_first_advice(log: str, grind: Grind, tmp_path: Path) -> None:
    program, measured = plate_in(tmp_path), tmp_path / "m.csv"
    measured.write_text(log)
    words = ("advise", program, "--parts", 2, "--restart", "--measurements", measured)
    status, out, err = grind(*words)
    assert (status, err) == (0, "") and out.count("part 1, N50: E15000.") == 1 and "N70" not in out
    assert grind(*words, "--shadow")[1].endswith("nothing was read that could be compared with a forecast\n")


def test_rows_beyond_the_batch_are_reported(grind: Grind, tmp_path: Path) -> None:
    program, measured = plate_in(tmp_path), tmp_path / "m.csv"
    measured.write_text("mean_power\n" + "2500\n" * 9)
    words = ("advise", program, "--parts", 2, "--restart", "--measurements", measured)
    status, out, _ = grind(*words)
    assert status == 0 and "m.csv, row 6 is of no block of this batch, which is over" in out
    assert "row 6 is of no block" in json.loads(grind(*words, "--json")[1].splitlines()[-1])["ignored"]
    measured.write_text("mean_power\n" + "2500\n" * 4)
    assert "of no block" not in grind(*words)[1]


def test_a_shadow_writes_its_comparison_as_json(grind: Grind, tmp_path: Path) -> None:
    program, measured = plate_in(tmp_path), tmp_path / "m.csv"
    measured.write_text("mean_power\n" + "2500\n" * 4)
    words = ("advise", program, "--parts", 2, "--restart", "--measurements", measured, "--shadow")
    lines = [json.loads(line) for line in grind(*words, "--json")[1].splitlines()]
    compared = lines[-1]["compared"]
    assert [(row["part"], row["name"], row["read"]) for row in compared] == [
        (part, "mean power", pytest.approx(2.5)) for part in (1, 1, 2, 2)
    ]
    assert all(row["holds"] == (abs(row["read"] - row["forecast"]) <= 2.0 * row["spread"]) for row in compared)
    assert lines[-1]["right_from"] in (None, 1, 2)
