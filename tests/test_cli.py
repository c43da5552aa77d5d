import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grind_env.cli import main
from grind_env.control import ControlError, read
from grind_env.control.program_check import MOST_ERRORS

DRESSED = """G71 G94 G90 G19
N10 G00 X-30.
N20 G82.1 X230. I-30. Y-.02 J-.01 L1 F6. E12000. P9100
N30 M30
O9100
G00 Y50.
G18 G02 X-20. R5. F100.
G04 P.5
M99
"""


@pytest.fixture
def grind(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Return a function that runs `grind COMMAND` on a program and returns exit status, output and errors."""

    def call(command: str, text: str | bytes | None, *options: str) -> tuple[int, str, str]:
        path = tmp_path / "part.nc"
        if text is not None:
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(SystemExit) as exit_:
            main([command, str(path), *options])
        captured = capsys.readouterr()
        return int(exit_.value.code or 0), captured.out, captured.err

    return call


def test_trace_prints_one_object_a_motion(grind) -> None:
    status, out, _ = grind("trace", DRESSED, "--acceleration", "2000")
    records = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert [(record["kind"], record["source"]) for record in records] == [
        ("rapid", "program"),
        ("rapid", "dress"),
        ("arc", "dress"),
        ("dwell", "dress"),
        ("line", "retrace"),
        ("rapid", "retrace"),
        *[("line", "cycle")] * 6,
    ]
    assert records[2] == {
        "kind": "arc",
        "end": [-20.0, 50.0, 0.0],
        "center": [-25.0, 50.0, 0.0],
        "rotation": -1,
        "plane": "G18",
        "feed": 100.0,
        "start": pytest.approx(records[1]["start"] + records[1]["seconds"]),
        "seconds": pytest.approx(5 * 3.14159265 / (100 / 60) + (100 / 60) / 2000),
        "block": 7,
        "line": 7,
        "source": "dress",
    }
    assert records[6] == {
        "kind": "line",
        "end": [230.0, 0.0, 0.0],
        "feed": 12000.0,
        "start": pytest.approx(records[5]["start"] + records[5]["seconds"]),
        "seconds": 1.4,
        "block": 20,
        "line": 3,
        "source": "cycle",
    }
    assert "feed" not in records[0] and "feed" not in records[3]


def test_trace_gives_the_start_times_of_concurrent_motions(grind) -> None:
    text = "G71 G94 G19 G00 X-25.\nG81 X75. I-25. E6000.\nG01 Y-3. F60.\nG04 P2.\nG80\nG00 Y20.\nM30"
    _, out, _ = grind("trace", text, "--acceleration", "1000")
    records = [json.loads(line) for line in out.splitlines()]
    way, feed, dwell, out_of_it = (record for record in records if record["source"] == "program")
    strokes = [record for record in records if record["source"] == "cycle"]
    turn = feed["start"]  # the table starts with the first motion beside it
    assert turn == way["seconds"]
    for k, stroke in enumerate(strokes):  # of 100 mm at 100 mm/s, with 0.1 s for the ramps
        assert (stroke["start"], stroke["seconds"]) == pytest.approx((turn + 1.1 * k, 1.1))
    # Y falls by 1 mm/s during the feed move, so the end time of a stroke gives its depth
    during = [stroke for stroke in strokes if stroke["start"] + stroke["seconds"] < turn + 3.0]
    assert len(during) == 2
    for stroke in during:
        depth = stroke["start"] + stroke["seconds"] - feed["start"] - 0.5 * 1.0 / 1000.0
        assert stroke["end"][1] == pytest.approx(-depth, abs=1e-6)
    assert dwell["start"] == pytest.approx(feed["start"] + feed["seconds"])
    assert out_of_it["start"] == pytest.approx(strokes[-1]["start"] + 1.1)  # the table stops at a reversal point
    _, found, _ = grind("check", text, "--acceleration", "1000", "--json")
    last = max(record["start"] + record["seconds"] for record in records)
    assert json.loads(found)["seconds"] == pytest.approx(last)
    assert sum(record["seconds"] for record in records) > last + 4.0


def test_trace_gives_the_start_times_of_picks(grind) -> None:
    text = "G71 G94 G19 G00 X-30.\nG82 X230. I-30. Y-.02 J-.01 L1 F6. E12000.\nM30"
    _, out, _ = grind("trace", text, "--acceleration", "1000")
    _, *cycle = (json.loads(line) for line in out.splitlines())
    picks = [record for record in cycle if record["feed"] == 6.0]
    strokes = [record for record in cycle if record["feed"] == 12_000.0]
    ends = [stroke["start"] + stroke["seconds"] for stroke in strokes]
    assert len(picks) == 2
    for pick in picks:  # a pick begins as the table brakes, 0.2 s from 200 mm/s
        assert min(abs(pick["start"] + 0.2 - end) for end in ends) < 1e-9
    assert [stroke["start"] for stroke in strokes[1:]] == pytest.approx(ends[:-1])


def test_trace_uses_the_units_in_force(grind) -> None:
    _, out, _ = grind("trace", "G70 G01 X.1 F7.\nX.3\nG71 X25.4\n")
    records = [json.loads(line) for line in out.splitlines()]
    assert [record["end"][0] for record in records] == [0.1, 0.3, 25.4]
    assert [record["feed"] for record in records] == [7.0, 7.0, 177.8]


def test_trace_limits_strokes_and_skips_deleted_blocks(grind) -> None:
    text = "/ G00 X1\nG81 X9. I0 E600.\n"
    assert len(grind("trace", text)[1].splitlines()) == 11
    assert len(grind("trace", text, "--strokes", "3", "--block-delete")[1].splitlines()) == 3


def test_trace_ends_with_an_error_line(grind) -> None:
    status, out, err = grind("trace", "G00 X1\nN30 X2 Y--1\nX3")
    first, last = (json.loads(line) for line in out.splitlines())
    assert (status, err) == (2, "")
    assert first["end"] == [1.0, 0.0, 0.0]
    assert last == {
        "kind": "error",
        "error": "number-format",
        "block": 30,
        "line": 2,
        "column": 8,
        "message": "Y- has no digits; a number must follow",
    }


@pytest.mark.parametrize(("text", "line"), [(None, None), (b"\xff\xfe\x00G", 1)])
def test_trace_and_check_report_an_unreadable_file(grind, text, line) -> None:
    status, out, err = grind("trace", text)
    assert (status, err) == (2, "")
    record = json.loads(out)
    assert (record["error"], record["line"]) == ("file", line)
    status, out, err = grind("check", text)
    assert (status, out) == (2, "")
    assert err.startswith("grind: ") and err.count("\n") == 1


def test_an_error_in_a_called_program_names_its_file(grind, tmp_path: Path) -> None:
    (tmp_path / "O7.nc").write_text("G00 X-\nM99")
    _, out, _ = grind("trace", "M98 P7\nM30")
    record = json.loads(out)
    assert record["message"].startswith("O7.nc: ")
    assert (record["line"], record["column"]) == (1, 5)


def test_bad_options_end_with_status_2(grind) -> None:
    status, out, _ = grind("trace", "M30", "--acceleration", "0")
    assert (status, json.loads(out)["error"]) == (2, "setting")
    assert grind("check", "M30", "--strokes", "0")[0] == 2
    assert grind("check", "M30", "--nonsense")[0] == 2


def test_an_unreadable_job_is_reported_like_an_error_of_the_program(grind, tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("[part]\nstock = 1")
    for name, words in (("missing.toml", "cannot be read"), ("bad.toml", "part.material is missing")):
        job = str(tmp_path / name)
        status, out, err = grind("check", "M30", "--json", "--job", job)
        (error,) = json.loads(out)["errors"]
        assert (status, error["error"], err.count("\n")) == (2, "job", 1)
        assert name in error["message"] and words in error["message"]
        status, out, err = grind("trace", "M30", "--job", job)
        assert (status, err, json.loads(out)) == (2, "", error)


def test_check_summarises_a_program_and_suggests_its_job(grind, tmp_path: Path) -> None:
    status, out, err = grind("check", DRESSED)
    assert (status, err) == (0, "")
    assert out.splitlines()[0].startswith("2 programs, 8 blocks, 12 motions, ")
    assert out.splitlines()[1:] == ["line 3: G82.1, 4 strokes, 1 dress"]
    (tmp_path / "part.toml").touch()
    assert grind("check", DRESSED)[1].endswith(f"--job {tmp_path / 'part.toml'}\n")


def test_check_prints_its_report_as_json(grind) -> None:
    status, out, _ = grind("check", DRESSED, "--json")
    report = json.loads(out)
    assert status == 0
    assert report["cycles"] == [{"code": "G82.1", "block": 20, "line": 3, "strokes": 4, "dresses": 1}]
    assert (report["programs"], report["blocks"], report["errors"]) == (2, 8, [])


@pytest.mark.parametrize("text", ["", "%\n", "O7 (NOTHING)\n%\n"])
def test_check_refuses_a_file_without_blocks(grind, text: str) -> None:
    status, out, err = grind("check", text)
    assert (status, out) == (2, "")
    assert "part.nc has no blocks; name a part program" in err
    status, out, _ = grind("check", text, "--json")
    assert (status, json.loads(out)["errors"][0]["error"]) == (2, "file")


def test_check_counts_the_strokes_between_cycles(grind) -> None:
    text = "G71 G19 G94 G00 X-30.\nG82 X230. I-30. Y-.01 J-.01 F60. E12000.\nG04 P5.\nG82 Y-.02 J-.01\nM30"
    _, out, _ = grind("check", text)
    between = [line for line in out.splitlines() if "between cycles" in line]
    cycles = [int(line.split(", ")[1].split()[0]) for line in out.splitlines() if line.startswith("line ")]
    _, out, _ = grind("trace", text)
    strokes = [json.loads(line) for line in out.splitlines()]
    made = sum(record.get("feed") == 12000.0 for record in strokes)
    assert made == sum(cycles) + (int(between[0].split()[0]) if between else 0)
    assert len(between) == 1


def test_check_lists_every_faulty_block_and_where_execution_stopped(grind, tmp_path: Path) -> None:
    (tmp_path / "O9.nc").write_text("G999\nM99\n")
    text = "G71 G90\nM98 P9\nG00 X- Y1\nG82 X1.\nX#[\nM30\nO5\nY1 Q\nM99\n"
    status, out, err = grind("check", text)
    *errors, remark = err.splitlines()
    found = [line.removeprefix("grind: ").partition(" ")[0] for line in errors]
    assert (status, out) == (2, "")
    assert found == ["part.nc:3:5:", "part.nc:5:3:", "part.nc:8:4:", "O9.nc:1:1:"]
    assert remark.startswith("grind: the program was not executed further than O9.nc:1;")
    said = json.loads(grind("check", text, "--json")[1])
    assert [error["line"] for error in said["errors"]] == [3, 5, 8, 1]
    assert said["stopped"] == said["errors"][3]


def test_check_goes_on_after_faulty_program_names_and_does_not_execute(grind) -> None:
    text = "G01 X1\nO5\nX-\nM99\nO5\nM99\nO6 G00\nY-\nM99\n"
    status, _, err = grind("check", text)
    *errors, remark = err.splitlines()
    assert (status, [int(line.split(":")[2]) for line in errors]) == (2, [3, 5, 7, 8])
    assert "O5 is named twice; every program needs its own number" in err
    assert "no-feedrate" not in err
    assert remark == "grind: the program was not executed; check it again once its program names are mended"
    with pytest.raises(ControlError, match="named twice"):
        read(text)


def test_check_limits_the_number_of_errors(grind) -> None:
    _, _, err = grind("check", "X-\n" * 3000)
    assert err.count("\n") == MOST_ERRORS + 1


def test_a_letter_missing_in_the_encoding_is_shown_as_its_code(tmp_path: Path) -> None:
    path = tmp_path / "grün.nc"
    path.write_text("G00 X")
    command = [sys.executable, "-c", "from grind_env.cli import main; main()", "check", str(path)]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    result = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)
    assert r"gr\xfcn.nc:1:5" in result.stderr


def test_trace_takes_radii_for_all_or_single_wheels(grind) -> None:
    text = "G41 G01 Z10. X10. T0101 F100.\nZ30.\nX20.\nG40 Z50.\n"

    def first(*options: str) -> list[float]:
        return json.loads(grind("trace", text, *options)[1].splitlines()[0])["end"]

    assert first() == [10.0, 0.0, 10.0]
    assert first("--radius", "2") == first("--radius", "1=2") == [12.0, 0.0, 10.0]
    assert first("--radius", "2", "--radius", "1=3.5") == [13.5, 0.0, 10.0]
    status, out, _ = grind("trace", text, "--radius", "two")
    assert (status, json.loads(out)["error"]) == (2, "setting")
