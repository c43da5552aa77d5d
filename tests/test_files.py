"""What a user's path may be: a file, or a pipe that someone writes to; all else is refused at once, in one sentence."""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from agents.benchmark.results import PARQUET, read_results
from agents.benchmark.trained import from_file
from agents.dressing.table import read_study
from agents.learning.curve import read_curve
from agents.learning.settings import settings_for
from grind_env import files
from grind_env.control import read_file
from grind_env.errors import GrindError
from grind_env.files import ReadError, open_file, read_bytes, read_text
from grind_env.machine.job_file import load_job
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.problem import find_problem
from grind_env.policies.tuned import read_tuned
from grind_env.process.catalogue import load_catalogue
from grind_env.scores import read_references
from grind_env.toml import TomlError, read_toml
from tests.patience import PATIENCE

SIMULATION = find_problem("oracle6").simulation()


def catalogue_of_a_job(path: Path) -> object:
    job = path.with_name("job.toml")
    job.write_text(f'[catalogue]\nfiles = ["{path}"]\n[part]\nmaterial = "aisi_52100"\n')
    return load_job(job)


READERS: dict[str, Callable[[Path], object]] = {
    "part.nc": read_file,
    "part.toml": load_job,
    "shop.toml": load_catalogue,
    "called.toml": catalogue_of_a_job,
    "scores.toml": read_references,
    "tuned.toml": lambda path: read_tuned("tuned", path.parent),
    "oracle6.toml": lambda path: settings_for("ppo", "oracle6", path.parent),
    "policy.safetensors": load_policy,
    "measured.safetensors": lambda path: from_file(path, SIMULATION, "ppo"),
    "curve.csv": read_curve,
    "study.csv": read_study,
    PARQUET: lambda path: read_results(path.parent),
}
"""Every reader of a user's file, by the name of a file that it reads."""
ENDLESS = {
    "/dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "/dev/random": lambda path: path.symlink_to("/dev/random"),
    "a pipe that nobody writes to": os.mkfifo,
    "a folder": Path.mkdir,
    "a terabyte": lambda path: (path.touch(), os.truncate(path, 10**12)),
}


@pytest.mark.parametrize("kind", ENDLESS)
@pytest.mark.parametrize("name", READERS)
def test_what_has_no_end_is_refused_in_a_sentence(
    name: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "PATIENCE", 0.01)
    path = tmp_path / name
    ENDLESS[kind](path)
    with pytest.raises(GrindError) as caught:
        READERS[name](path)
    message = str(caught.value)
    assert name in message and "\n" not in message and len(message) < 400 + 3 * len(str(tmp_path))


DEEP = {
    "arrays": "x = " + "[" * 100_000,
    "inline tables": "x = " + "{a=" * 100_000,
    "a dotted key": "a" + ".a" * 100_000 + " = 1",
    "a dotted key in a table": "x = {a" + ".a" * 100_000 + " = 1}",
    "quoted names": "'a'" + ".'a'" * 100_000 + " = 1",
    "a dotted heading": "[a" + ".a" * 100_000 + "]",
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
@pytest.mark.parametrize("name", [name for name in READERS if name.endswith(".toml")])
def test_deep_toml_is_refused_in_a_sentence(name: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(GrindError) as caught:
        READERS[name](path)
    message = str(caught.value)
    assert name in message and "\n" not in message and len(message) < 400 + 3 * len(str(tmp_path))


def test_a_file_is_read_up_to_its_limit_and_not_beyond(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(ReadError, match=r"file cannot be read \(it has more than 4e-06 MB\)$"):
        read_bytes(path, 4)


def test_a_pipe_is_read_as_far_as_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MOST_BYTES", 100_000)
    monkeypatch.setattr(files, "PATIENCE", PATIENCE)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writers = []
    for size in (100_000, 100_001):
        # the reader goes away before it has taken all of the second one
        writers.append(threading.Thread(target=lambda size=size: _write(path, b"a" * size)))
        writers[-1].start()
        if size <= files.MOST_BYTES:
            assert read_bytes(path) == b"a" * size
        else:
            with pytest.raises(ReadError, match=r"it has more than 0\.1 MB"):
                open_file(path)
        writers[-1].join()


def _write(path: Path, data: bytes) -> None:
    with suppress(BrokenPipeError):
        path.write_bytes(data)


def test_a_writer_may_take_its_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "PATIENCE", 0.01)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR)
    late = threading.Timer(0.1, lambda: (os.write(writer, b"M30"), os.close(writer)))
    late.start()
    assert [source.text for source in read_file(path).main.blocks] == ["M30"]
    late.join()


def test_a_pipe_whose_writer_had_nothing_to_say_is_empty() -> None:
    reading, writing = os.pipe()
    os.close(writing)
    assert read_bytes(Path(f"/dev/fd/{reading}")) == b""
    os.close(reading)


def test_names_that_no_file_has_are_shortened(tmp_path: Path) -> None:
    for name in ("a\0b", "a" * 100_000):
        with pytest.raises(ReadError, match="cannot be read") as caught:
            read_bytes(tmp_path / name)
        assert len(str(caught.value)) < 400 and str(caught.value).isprintable()


def test_texts_are_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_bytes(b'\xef\xbb\xbfx = "\xc3\xbc"')
    assert (read_text(path), read_toml(path)) == ('x = "ü"', {"x": "ü"})
    path.write_bytes(b'x = "\xfc"')
    with pytest.raises(ReadError, match="its byte 6 is not text in UTF-8"):
        read_text(path)
    with pytest.raises(TomlError, match="utf-8"):
        read_toml(path)


def test_points_in_texts_and_remarks_of_toml_are_no_keys(tmp_path: Path) -> None:
    path = tmp_path / "part.toml"
    numbers = [1.5] * 600
    path.write_text(f'name = "{"." * 600}"  # {"." * 600}\n# {"." * 600}\nnumbers = {numbers}\n', encoding="utf-8")
    assert read_toml(path) == {"name": "." * 600, "numbers": numbers}
