"""Results are never written over what they are made from."""

import shutil
from pathlib import Path

import pytest

import grind_env
from grind_env.files import FileError
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).parent / "examples"


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """The example, with its job beside it."""
    for name in ("plate_g82.nc", "plate_g82.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)
    return tmp_path / "plate_g82.nc"


@pytest.mark.parametrize(
    "words",
    [
        "report part.nc -o part.nc",
        "report part.nc -o part.toml",
        "optimise part.nc --report part.nc",
        "optimise part.nc -o part.toml",
        "calibrate log.csv --job part.toml -o part.toml",
        "calibrate log.csv --job part.toml -o ./log.csv",
        "calibrate log.csv --job part.toml --program part.nc --report part.nc",
    ],
)
def test_no_command_writes_over_what_it_reads(
    words: str, plate: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(plate.parent)
    files = [Path("part.nc"), Path("part.toml"), Path("log.csv")]
    files[0].write_bytes(plate.read_bytes())
    files[1].write_bytes(plate.with_suffix(".toml").read_bytes())
    files[2].write_text("time [s],power [W]\n0,1\n", encoding="utf-8")
    before = [file.read_bytes() for file in files]
    status, _, said = grind(*words.split())
    assert status == 2
    assert "name such a file" in said or "name another file" in said
    assert [file.read_bytes() for file in files] == before


def test_a_report_is_not_written_over_its_program(plate: Path) -> None:
    before = plate.read_bytes()
    with pytest.raises(FileError, match="is read here and would be lost; name another file to write"):
        grind_env.report(plate, output=plate)
    page = plate.with_suffix(".html")
    page.write_text("<title>mine</title>", encoding="utf-8")
    with pytest.raises(FileError, match="is there already and would be lost, for it is no page of `grind report`"):
        grind_env.report(plate)
    assert (plate.read_bytes(), page.read_text("utf-8")) == (before, "<title>mine</title>")


def test_a_report_replaces_the_one_before(plate: Path, grind: Grind) -> None:
    page = plate.with_suffix(".html")
    assert grind("report", plate)[0] == 0
    before = page.read_bytes()
    page.write_bytes(before[:-100])
    assert grind("report", plate)[0] == 0
    assert page.read_bytes() == before
