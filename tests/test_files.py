"""Paths that users may read or write; every other path is refused at once, in one sentence."""

import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from agents.benchmark.agent_files import from_file
from agents.benchmark.results import PARQUET, read_results
from agents.dressing.table import read_study
from grind_env import files
from grind_env.control import read_file
from grind_env.control.program_reader import called_files
from grind_env.errors import GrindError
from grind_env.files import FileError, ReadError, check_target, open_file, read_bytes, read_text, write_atomically
from grind_env.machine.job.job_file import load_job
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.tuned_parameters import read_tuned
from grind_env.process.catalogue import load_catalogue
from grind_env.score_scale import read_references
from grind_env.toml import TomlError, read_toml
from tests.patience import PATIENCE

SIMULATION = find_problem("oracle6").simulation()


def catalogue_of_a_job(path: Path) -> object:
    job = path.with_name("job.toml")
    job.write_text(f'[catalogue]\nfiles = ["{path}"]\n[part]\nmaterial = "aisi_52100"\n')
    return load_job(job)


#: every reader of a user's file, by the name of a file that it reads
READERS: dict[str, Callable[[Path], object]] = {
    "part.nc": read_file,
    "part.toml": load_job,
    "shop.toml": load_catalogue,
    "called.toml": catalogue_of_a_job,
    "scores.toml": read_references,
    "tuned.toml": lambda path: read_tuned("tuned", path.parent),
    "policy.safetensors": load_policy,
    "measured.safetensors": lambda path: from_file(path, SIMULATION, "ppo"),
    "study.csv": read_study,
    PARQUET: lambda path: read_results(path.parent),
}
ENDLESS = {
    "/dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "/dev/random": lambda path: path.symlink_to("/dev/random"),
    "a pipe that nobody writes to": os.mkfifo,
    "a folder": Path.mkdir,
    "a terabyte": lambda path: (path.touch(), os.truncate(path, 10**12)),
}


@pytest.mark.parametrize("kind", ENDLESS)
@pytest.mark.parametrize("name", READERS)
def test_readers_refuse_endless_files_pipes_and_folders_in_one_sentence(
    name: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "PATIENCE", 0.01)
    path = tmp_path / name
    ENDLESS[kind](path)
    assert_refused(path)


def assert_refused(path: Path) -> None:
    """Assert that the reader refuses the file in one short sentence that names it."""
    with pytest.raises(GrindError) as caught:
        READERS[path.name](path)
    message = str(caught.value)
    assert path.name in message and "\n" not in message and len(message) < 400 + 3 * len(str(path.parent))


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
def test_deep_toml_is_refused_in_one_sentence(name: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text)
    assert_refused(path)


def test_a_file_beyond_the_size_limit_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(ReadError, match=r"file cannot be read \(it has more than 4e-06 MB\)$"):
        read_bytes(path, 4)


def test_a_pipe_beyond_the_size_limit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MOST_BYTES", 100_000)
    monkeypatch.setattr(files, "PATIENCE", PATIENCE)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writers = []
    for size in (100_000, 100_001):
        # the reader closes the second pipe before it has read all
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


def test_an_open_pipe_is_read_even_if_its_writer_is_slow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "PATIENCE", 0.01)
    path = tmp_path / "pipe"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR)
    late = threading.Timer(0.1, lambda: (os.write(writer, b"M30"), os.close(writer)))
    late.start()
    assert [source.text for source in read_file(path).main.blocks] == ["M30"]
    late.join()


def test_a_pipe_closed_without_data_reads_as_empty() -> None:
    reading, writing = os.pipe()
    os.close(writing)
    assert read_bytes(Path(f"/dev/fd/{reading}")) == b""
    os.close(reading)


def test_impossible_file_names_are_shortened_in_messages(tmp_path: Path) -> None:
    for name in ("a\0b", "a" * 100_000):
        with pytest.raises(ReadError, match="cannot be read") as caught:
            read_bytes(tmp_path / name)
        assert len(str(caught.value)) < 400 and str(caught.value).isprintable()


def test_a_missing_file_suggests_a_similar_name(tmp_path: Path) -> None:
    for name in ("part.nc", "part.toml", "shop.toml"):
        (tmp_path / name).touch()
    names = {"prat.nc": "part.nc", "part.tml": "part.toml", "Shop.toml": "shop.toml", "other.nc": "", "no/part.nc": ""}
    for name, meant in names.items():
        with pytest.raises(ReadError, match="cannot be read") as caught:
            read_bytes(tmp_path / name)
        expected = f"; did you mean {meant}?)" if meant else "directory)"
        assert str(caught.value).endswith(expected)


def test_only_utf_8_text_is_read(tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_bytes(b'\xef\xbb\xbfx = "\xc3\xbc"')
    assert (read_text(path), read_toml(path)) == ('x = "ü"', {"x": "ü"})
    for data, said in (
        ('a = 1\r\n# Stück\nx = "ü"'.encode("latin-1"), "line 2 is not in UTF-8, but in a code such as Latin-1; save"),
        (b'\xfcx = ""', "line 1 is not in UTF-8"),
        ('x = "ü"'.encode("utf-16"), "it is in UTF-16, or no text at all; save it as text in UTF-8"),
        ('x = "ü"'.encode("utf-16-le"), "it is in UTF-16"),
        ('x = "ü"'.encode("utf-16-be"), "it is in UTF-16"),
    ):
        path.write_bytes(data)
        with pytest.raises(ReadError, match=said):
            read_text(path)
        with pytest.raises(TomlError, match=said):
            read_toml(path)


def test_dots_in_toml_strings_and_comments_are_no_keys(tmp_path: Path) -> None:
    path = tmp_path / "part.toml"
    numbers = [1.5] * 600
    path.write_text(f'name = "{"." * 600}"  # {"." * 600}\n# {"." * 600}\nnumbers = {numbers}\n', encoding="utf-8")
    assert read_toml(path) == {"name": "." * 600, "numbers": numbers}


# --- writing ----------------------------------------------------------------------------------------------------


def write(path: Path, text: str) -> None:
    write_atomically(path, lambda partial: partial.write_text(text))


def test_writing_to_a_link_replaces_its_target_and_keeps_the_link(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "there.csv").symlink_to("far/data.csv")
    (tmp_path / "link.csv").symlink_to("there.csv")
    for text in ("first", "second"):
        write(tmp_path / "link.csv", text)
        assert (tmp_path / "far" / "data.csv").read_text() == text
    assert (tmp_path / "link.csv").is_symlink() and (tmp_path / "there.csv").is_symlink()
    assert [path.name for path in (tmp_path / "far").iterdir()] == ["data.csv"]


@pytest.mark.parametrize("through", ["itself", "a link"])
def test_devices_pipes_and_standard_output_are_refused_as_targets(through: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for name in ("/dev/null", str(tmp_path / "pipe")):
        path = Path(name)
        if through == "a link":
            path = tmp_path / f"{Path(name).name}.csv"
            path.symlink_to(name)
        for call in (check_target, lambda path: write(path, "text")):
            with pytest.raises(FileError, match=r" is a device, a pipe or the output of this command; name a file$"):
                call(path)
    code = "import sys; from pathlib import Path; from grind_env import files; files.check_target(Path(sys.argv[1]))"
    with (tmp_path / "out").open("w") as out:
        for name in ("/dev/stdout", str(tmp_path / "out")):
            words = [sys.executable, "-c", code, name]
            done = subprocess.run(words, stdout=out, stderr=subprocess.PIPE, text=True, check=False)
            assert "the output of this command; name a file" in done.stderr


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("none/a.csv", "there is no folder"),
        ("folder", "is a folder; name a file"),
        ("circle.csv", "Too many levels of symbolic links; name another file"),
        ("astray.csv", "there is no folder"),
        ("a" * 300, "File name too long; name another file"),
        ("a\0b", "no file can have this name; name another file"),
        ("file/a.csv", "Not a directory; name another file"),
    ],
)
def test_impossible_target_paths_are_refused_with_the_reason(name: str, what: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "circle.csv").symlink_to("circle.csv")
    (tmp_path / "astray.csv").symlink_to("none/astray.csv")
    with pytest.raises(FileError, match=what) as caught:
        check_target(tmp_path / name)
    assert str(caught.value).isprintable()
    with pytest.raises(FileError, match=what):
        write(tmp_path / name, "text")


def test_a_full_disk_keeps_the_previous_file(tmp_path: Path) -> None:
    path = tmp_path / "file"
    write(path, "before")

    def fill(partial: Path) -> None:
        shutil.copyfile("/dev/zero", "/dev/full")

    with pytest.raises(FileError, match="No space left on device"):
        write_atomically(path, fill)
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("file", "before")]


# --- called programs --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "called"),
    [
        ("M98 P7", [7, 8]),
        ("m98p0007 l3", [7, 8]),
        ("G82 Y-.2 P 9100", [9100]),
        ("G65 P7.", [7, 8]),
        ("G65 P#101", [7, 8, 9100]),
        ("M98 P[#1 + 6]", [7, 8, 9100]),
        ("M98 P70 (O7 IS OLD)", []),
        ("G01 X7.", []),
    ],
)
def test_called_files_finds_every_possible_subprogram(text: str, called: list[int], tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text(text)
    for number, own in ((7, "M98 P8"), (8, "M98 P7"), (9100, "M99")):
        (tmp_path / f"O{number}.nc").write_text(own)
    (tmp_path / "O7.txt").touch()
    assert called_files(tmp_path / "part.nc") == [tmp_path / f"O{number}.nc" for number in called]
    assert tmp_path / "O9100.nc" in called_files(tmp_path / "part.nc", [9100])
