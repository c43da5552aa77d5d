"""A report is never written over what it is made from; tests/test_outputs.py asks that of every command."""

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
