import json
from pathlib import Path

import pytest

import grind_env
from grind_env.cli import main
from tests.machine.harness import DRESS, HEAD

EXAMPLES = Path(grind_env.__file__).parent / "examples"
PLATE = str(EXAMPLES / "plate_g82.nc")


def grind(*arguments: object) -> int:
    """Exit status of the command."""
    with pytest.raises(SystemExit) as caught:
        main([str(argument) for argument in arguments])
    return int(caught.value.code or 0)


def test_the_table_of_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", PLATE) == 0
    out = capsys.readouterr().out
    assert "plate_g82.nc" in out
    assert "1 part, 1.00 of them good" in out
    assert max(map(len, out.splitlines())) <= 80


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", PLATE, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parts"][0]["strokes"] == 29
    assert found["dresses"][0]["cause"] == "auto"
    assert found["warnings"] == []
    assert found["cost"] == pytest.approx(found["parts"][0]["total_cost"])


def test_scrap_has_exit_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = tmp_path / "strict.toml"
    text = (EXAMPLES / "plate_g82.toml").read_text()
    job.write_text(text.replace("roughness_limit = 0.50", "roughness_limit = 0.10"))
    assert grind("run", PLATE, "--job", job) == 1
    assert "0.00 of them good" in capsys.readouterr().out


def test_warnings_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "short.nc"
    program.write_text(HEAD + "G82 X150. I-30. Y-.02 J-.01 F60. E12000.\nM30\n" + DRESS)
    (tmp_path / "short.toml").write_text((EXAMPLES / "plate_g82.toml").read_text())
    grind("run", program)
    assert "warning: short.nc:3: a stroke turns at X150" in capsys.readouterr().out


def test_plot_and_record(tmp_path: Path) -> None:
    plot, record = tmp_path / "plate.png", tmp_path / "plate.csv"
    assert grind("run", PLATE, "--plot", plot, "--record", record) == 0
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert len(record.read_text().splitlines()) == 1 + 29


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["missing.nc"], "missing.nc"),
        ([PLATE, "--job", "missing.toml"], "missing.toml"),
        ([PLATE, "--plot", "no/such/folder/a.png"], "no/such/folder"),
        ([PLATE, "--plot", "a.gif"], ".png, .svg, .pdf"),
        ([PLATE, "--record", "no/such/folder/a.csv"], "no/such/folder"),
        ([PLATE, "--record", "a.xlsx"], ".csv or .parquet"),
    ],
)
def test_bad_input_is_one_line_and_exit_status_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert grind("run", *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("grind: ")
    assert error.count("\n") == 1
    assert words in error


def test_a_program_without_a_job_beside_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "lonely.nc"
    program.write_text(HEAD + "M30\n")
    assert grind("run", program) == 2
    assert "--job" in capsys.readouterr().err
    (tmp_path / "lonely.toml").write_text("[part]\nstock = -1\n")
    assert grind("run", program) == 2
    assert "lonely.toml" in capsys.readouterr().err


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert grind("run", "--help") == 0
    assert "Example: grind run" in capsys.readouterr().out
