"""Processes side by side. Each imports this file, which therefore imports little."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import pytest
from rich.console import Console

from agents import pool
from agents.pool import KILLED, find_all, work_on_all
from grind_env.errors import GrindError
from tests.patience import PATIENCE, wait_until


class Asked(NamedTuple):
    """How cells, which are names here, are worked on."""

    folder: Path = Path()
    size: int = 3


def eventful(cell, request, advance):
    """What may happen to a cell."""
    if cell == "mistake":
        raise GrindError("this is\na mistake")
    if cell == "defect":
        raise ValueError("this is a defect")
    if cell == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    print("a worker prints nothing")
    advance(request.size)
    return [cell]


def lasting(cell, request, advance):
    """Work that lasts, but for a cell that leaves its worker idle; it says who does it."""
    (request.folder / cell).write_text(str(os.getpid()), encoding="utf-8")
    while cell != "idle":
        time.sleep(0.001)
        if cell == "sending":
            advance(0)
    return [cell]


def test_one_cell_that_fails_does_not_stop_the_others(capsys):
    cells = ["mistake", "good", "killed", "defect", "fine", "better"]
    found, failed = work_on_all(cells, Asked(), 2, Console(width=100), eventful)
    assert found == [["good"], ["fine"], ["better"]]
    assert failed == {"mistake": "this is a mistake", "defect": "ValueError: this is a defect", "killed": KILLED}
    printed = capsys.readouterr().out
    assert "mistake: this is a mistake\n" in printed
    assert "a worker prints nothing" not in printed


def test_a_study_that_needs_every_cell_says_how_many_failed_and_why_the_first_did():
    with pytest.raises(GrindError, match=r"2 of 3 cells failed: (mistake: this is a mistake|defect: ValueError)"):
        find_all(["mistake", "good", "defect"], Asked(), 2, Console(quiet=True), eventful)
    assert find_all(["good", "fine"], Asked(), 2, Console(quiet=True), eventful) == [["good"], ["fine"]]


@pytest.mark.parametrize("cell", [None, "idle", "sending"])
def test_a_worker_whose_parent_has_gone_ends_and_says_nothing(tmp_path, capfd, cell):
    worker = pool._start(lasting, Asked(tmp_path))
    if cell is not None:
        worker.pipe.send(cell)
        assert worker.pipe.poll(PATIENCE)
    worker.pipe.close()
    worker.process.join()
    assert worker.process.exitcode == 0
    assert capfd.readouterr() == ("", "")


# a kill, a terminal that is closed, a Ctrl-C; the last two reach the workers, too
@pytest.mark.parametrize(("name", "kill"), [("SIGKILL", os.kill), ("SIGHUP", os.killpg), ("SIGINT", os.killpg)])
def test_workers_end_with_their_parent_and_say_nothing(tmp_path, name, kill):
    program = (
        "import signal; from pathlib import Path; from rich.console import Console\n"
        "from agents.pool import work_on_all; from tests.agents.test_pool import Asked, lasting\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        # nohup leaves it ignored
        "    signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
        f"    request = Asked(Path({str(tmp_path)!r}))\n"
        "    try:\n"
        "        work_on_all(['idle', 'busy', 'sending'], request, 3, Console(quiet=True), lasting)\n"
        "    except KeyboardInterrupt:\n"
        "        raise SystemExit(130) from None\n"
    )
    script = tmp_path / "script.py"
    script.write_text(program, encoding="utf-8")
    root = Path(__file__).parents[2]
    with (tmp_path / "said").open("w+", encoding="utf-8") as said:
        parent = subprocess.Popen(
            [sys.executable, script],
            cwd=root,
            env={**os.environ, "PYTHONPATH": str(root)},
            stdout=said,
            stderr=said,
            start_new_session=True,
        )
        files = [tmp_path / name for name in ("idle", "busy", "sending")]
        wait_until(lambda: parent.poll() is not None or all(map(told, files)))
        workers = [int(file.read_text(encoding="utf-8")) for file in files]
        number = getattr(signal, name)
        kill(parent.pid, number)
        assert parent.wait(PATIENCE) == (130 if name == "SIGINT" else -number)
        wait_until(lambda: not any(Path(f"/proc/{worker}/cmdline").exists() for worker in workers))
        said.seek(0)
        assert said.read() == ""


def told(file):
    return file.exists() and file.read_text(encoding="utf-8")
