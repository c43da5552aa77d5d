import dataclasses
from pathlib import Path

import pytest

from grind_env.errors import GrindError
from grind_env.files import ReadError
from grind_env.machine.job import Job, JobError, Setup, Stage, Times, WheelStart
from grind_env.machine.job.job_file import job_beside, load_job
from tests.machine.harness import job

SHORTEST = """
[part]
material = "aisi_52100"
length = 200
width = 20
stock = 0.3
scrap_cost = 40
"""
OVERRIDES = "setup.machine_overrides"


def write(folder: Path, text: str) -> Path:
    path = folder / "job.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_shortest_job_has_the_defaults(tmp_path: Path) -> None:
    found = load_job(write(tmp_path, SHORTEST))
    assert (found.part.length, found.part.width, found.part.stock) == (200.0, 20.0, 0.3)
    assert (found.part.start, found.part.across, found.part.surface) == (0.0, 0.0, 0.0)
    assert (found.part.roughness_limit, found.part.tolerance, found.part.rise_allowance) == (0.0, 0.0, 0.0)
    names = [entry.name for entry in (found.setup.wheel, found.setup.dresser, found.setup.fluid)]
    assert names == ["a60j", "single_point", "emulsion"]
    assert found.setup.wheel_speed == 30.0
    assert found.times == Times(load=20.0, dress_setup=8.0)
    assert found.wheel == WheelStart()
    assert (found.part.height, found.diamond) == (None, None)
    assert (found.setup.spindle, found.setup.coolant) == ("by program", "by program")


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("stock = 0.3", "stock = -0.3", "part.stock", ["-0.3", "0.0001 to 20 mm"]),
        ("stock = 0.3", 'stock = "thick"', "part.stock", ["thick", "number"]),
        ("stock = 0.3", "", "part.stock", ["missing"]),
        ("stock = 0.3", "stck = 0.3", "part.stck", ["did you mean stock?", "roughness_limit"]),
        ("aisi_52100", "aisi_52000", "part.material", ["did you mean aisi_52100?", "inconel_718"]),
        ("[part]", "[prat]", "prat", ["did you mean part?"]),
        ("", "[setup]\nwheel = 5", "setup.wheel", ["wheel 5", "a60j"]),
        ("", '[setup]\nspindle = "on"', "setup.spindle", ["'on'", "one of by program, always on"]),
        ("", "[diamond]\nx = 0\ny = 1", "diamond.z", ["missing"]),
        ("", "[setup]\nconstant_surface_speed = 1", "setup.constant_surface_speed", ["true or false"]),
        ("", f"[{OVERRIDES}]\nstifness = 1e4", f"{OVERRIDES}.stifness", ["did you mean stiffness?"]),
        ("", f"[{OVERRIDES}]\nstiffness = 1", OVERRIDES, ["stiffness is 1", "1000 to 500000 N/mm"]),
        ("", "[wheel]\ndiameter = 210", "wheel.diameter", ["210", "220 to 300 mm"]),
        ("", '[catalogue]\nfiles = ["none.toml"]', "catalogue.files", ["none.toml", "cannot be read"]),
        ("", '[catalogue]\nfiles = "a"', "catalogue.files", ["list"]),
        ("[part]", "times = 3\n[part]", "times", ["3", "table"]),
        ("", "tolerance = 9", "part.height", ["tolerance", "add height"]),
        ("", "[[part.stages]]\nstock = 0.2\ntolerance = 9", "part.height", ["tolerance", "add height"]),
    ],
)
def test_mistakes_name_file_key_value_and_remedy(
    tmp_path: Path, old: str, new: str, key: str, words: list[str]
) -> None:
    assert old in SHORTEST
    path = write(tmp_path, SHORTEST.replace(old, new) if old else SHORTEST + new)
    with pytest.raises(JobError) as caught:
        load_job(path)
    assert isinstance(caught.value, GrindError)
    assert caught.value.key == key
    assert caught.value.file == str(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    for word in words:
        assert word in message


def test_the_error_carries_value_and_legal_range(tmp_path: Path) -> None:
    with pytest.raises(JobError) as caught:
        load_job(write(tmp_path, SHORTEST.replace("0.3", "-0.3")))
    assert caught.value.found == -0.3
    assert caught.value.legal == "a number from 0.0001 to 20 mm"


@pytest.mark.parametrize("content", [b"[part", b"\xff\xfe", None])
def test_unreadable_job_files_are_reported(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "job.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(JobError, match=r"job\.toml"):
        load_job(path)


def test_a_job_made_in_python_is_checked_too() -> None:
    with pytest.raises(JobError, match=r"part\.width is 0"):
        job(width=0.0)
    with pytest.raises(JobError, match=r"wheel\.diameter is 310"):
        job(wheel_start=WheelStart(diameter=310.0))
    assert isinstance(dataclasses.replace(job(), times=Times(load=1)), Job)
    assert isinstance(job().setup, Setup)


def test_a_byte_order_mark_is_accepted(tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SHORTEST.encode())
    assert load_job(path) == load_job(write(tmp_path, SHORTEST))


def test_stages_are_read_in_order(tmp_path: Path) -> None:
    text = (
        SHORTEST
        + """
    height = 20
    [[part.stages]]
    stock = 0.2
    rise_allowance = 150
    [[part.stages]]
    stock = 0.25
    roughness_limit = 0.8
    tolerance = 12
    """
    )
    found = load_job(write(tmp_path, text))
    first, second = Stage(stock=0.2, rise_allowance=150.0), Stage(stock=0.25, roughness_limit=0.8, tolerance=12.0)
    assert found.part.stages == (first, second)
    assert found.limits_at(second) == (*found.limits[:2], 0.8, 12.0)
    assert found.limits_at(first).rise == found.limits.rise + 150.0


@pytest.mark.parametrize(
    ("stages", "key", "words"),
    [
        ("stages = 3", "part.stages", ["3", "[[part.stages]]"]),
        ("stages = [3]", "part.stages", ["3", "a table"]),
        ("[[part.stages]]\ntolerance = 9", "part.stages.stock", ["missing"]),
        ("[[part.stages]]\nstock = 0.2\ntolerence = 9", "part.stages.tolerence", ["did you mean tolerance?"]),
        ("[[part.stages]]\nstock = -0.2", "part.stages.stock", ["stage 1: ", "-0.2", "0.0001 to 20 mm"]),
        (
            "[[part.stages]]\nstock = 0.2\n[[part.stages]]\nstock = 0.1",
            "part.stages.stock",
            ["stage 2: ", "0.1, ", "0.2 mm, to part.stock, 0.3 mm"],
        ),
        ("[[part.stages]]\nstock = 0.31", "part.stages.stock", ["stage 1: ", "0.31"]),
    ],
)
def test_errors_in_stages_name_the_key(tmp_path: Path, stages: str, key: str, words: list[str]) -> None:
    with pytest.raises(JobError) as caught:
        load_job(write(tmp_path, SHORTEST + stages))
    assert caught.value.key == key
    for word in words:
        assert word in str(caught.value)


def test_the_error_of_a_missing_job_says_how_to_write_one(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text("M30", encoding="utf-8")
    told = "write one: `grind job --template` prints a job, and `grind init FOLDER` makes a program with its job"
    with pytest.raises(JobError, match=f"there is no job .*part.toml beside the program; .*{told}"):
        job_beside(program)
    with pytest.raises(JobError, match=f"other.toml: the job cannot be read .*{told}"):
        load_job(tmp_path / "other.toml")
    (tmp_path / "part.toml").write_text("", encoding="utf-8")
    with pytest.raises(JobError, match=r"No such file or directory; did you mean part\.toml\?"):
        load_job(tmp_path / "prat.toml")
    with pytest.raises(
        ReadError, match=r"prat\.nc cannot be read \(No such file or directory; did you mean part\.nc\?"
    ):
        job_beside(tmp_path / "prat.nc")
