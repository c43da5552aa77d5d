"""Trials in processes and as tasks of Ray: a failed trial stops no other, and workers end with their parent."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

from agents import parallel_trials
from agents.parallel_trials import KILLED, LOST, RETRIES, Failed, attempt, run_all
from agents.provenance import ROOT
from grind_env.errors import GrindError
from grind_env.optional_libraries import MissingExtra
from tests.patience import PATIENCE, wait_until

TRIALS = ["mistake", "good", "killed", "defect", "fine"]
FOUND = {"good": ["good"], "fine": ["fine"]}
FAILED = {"mistake": "this is a mistake", "defect": "ValueError: this is a defect", "killed": KILLED}
QUIET = Console(quiet=True)


def eventful(trial):
    """Return a result, raise an error or kill the process, depending on the trial."""
    if trial == "mistake":
        raise GrindError("this is\na mistake")
    if trial == "defect":
        raise ValueError("this is a defect")
    if trial == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    print("a worker prints nothing")
    return [trial]


def test_a_failed_trial_does_not_stop_the_others(capsys):
    found = {}
    failed = run_all(TRIALS, eventful, 2, Console(width=100), None, found.__setitem__)
    assert (found, failed) == (FOUND, FAILED)
    printed = capsys.readouterr().out
    assert "mistake: this is a mistake\n" in printed and "a worker prints nothing" not in printed


def lasting(file):
    """Write the id of this process to a file, then sleep for long."""
    Path(file).write_text(str(os.getpid()), encoding="utf-8")
    time.sleep(600.0)


def interrupt(folder, name):
    """Send a signal to a run of two long trials; return its exit status once its workers have ended."""
    program = (
        "import signal, sys; from rich.console import Console\n"
        "from agents.parallel_trials import run_all; from tests.agents.test_runner import lasting\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"  # nohup leaves it ignored
        "    try:\n"
        "        run_all(sys.argv[1:], lasting, 2, Console(quiet=True), None, print)\n"
        "    except KeyboardInterrupt:\n"
        "        raise SystemExit(130) from None\n"
    )
    (folder / "script.py").write_text(program, encoding="utf-8")
    files, said = [folder / "one", folder / "other"], folder / "said"
    with said.open("w", encoding="utf-8") as out:
        parent = subprocess.Popen(
            [sys.executable, folder / "script.py", *files],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=out,
            stderr=out,
            start_new_session=True,
        )
        wait_until(lambda: parent.poll() is not None or all(file.exists() and file.read_text() for file in files))
        workers = [int(file.read_text(encoding="utf-8")) for file in files]
        # a kill reaches the parent alone; Ctrl-C and a closed terminal also reach its workers
        (os.kill if name == "SIGKILL" else os.killpg)(parent.pid, getattr(signal, name))
        status = parent.wait(PATIENCE)
    wait_until(lambda: not any(Path(f"/proc/{worker}/cmdline").exists() for worker in workers))
    assert said.read_text() == ""
    return status


@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("SIGINT", 130),
        pytest.param("SIGKILL", -signal.SIGKILL, marks=pytest.mark.nightly),
        pytest.param("SIGHUP", -signal.SIGHUP, marks=pytest.mark.nightly),
    ],
)
def test_workers_end_with_their_parent_and_print_nothing(tmp_path, name, status):
    assert interrupt(tmp_path, name) == status


class FakeRay:
    """Replacement of Ray in this process; trials named in `raises` end with their error."""

    class RayError(Exception):
        pass

    class RayTaskError(RayError):
        cause = ImportError("no such module")

    def __init__(self, **raises):
        self.raises, self.joined, self.options, self.cancelled = raises, [], {}, []
        self.exceptions = SimpleNamespace(RayError=self.RayError, RayTaskError=self.RayTaskError)
        self._private = SimpleNamespace(worker=SimpleNamespace())
        self.shutdown = lambda: None

    def is_initialized(self):
        return False

    def init(self, address, **options):
        self.joined.append(address)

    def remote(self, **options):
        self.options = options
        return lambda run: SimpleNamespace(remote=lambda *given: (run, given))

    def wait(self, tasks, timeout):
        return tasks[:1], tasks[1:]

    def get(self, task):
        run, (work, trial, commit) = task
        if trial in self.raises:
            raise self.raises[trial]
        return run(work, trial, commit)

    def cancel(self, task, force):
        self.cancelled.append(task[1][1])


@pytest.fixture
def ray(monkeypatch):
    """Install a fake Ray and return it."""
    fake = FakeRay(killed=FakeRay.RayError(), strange=FakeRay.RayTaskError())
    monkeypatch.setitem(sys.modules, "ray", fake)
    monkeypatch.setattr(parallel_trials, "ANSWER_SECONDS", 0.2)
    return fake


def test_a_cluster_gives_the_results_of_processes_and_reports_lost_trials(ray):
    found = {}
    failed = run_all([*TRIALS, "strange"], eventful, 2, QUIET, "local", found.__setitem__)
    assert found == FOUND and ray.options == {"num_cpus": 1, "max_retries": RETRIES}
    assert "a node cannot run it: it must have commit" in failed.pop("strange")
    assert failed == FAILED | {"killed": LOST}


def test_an_interrupted_run_cancels_its_tasks(ray):
    def stop(trial, found):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_all(["good", "fine"], eventful, 2, QUIET, "local", stop)
    assert ray.cancelled == ["fine"]


def test_a_node_with_another_commit_fails_with_the_reason():
    answer = attempt(eventful, "good", "0000000")
    assert isinstance(answer, Failed) and "and not 0000000: check out the same" in answer


@pytest.mark.parametrize("address", ["nowhere", "10.0.0.1", ":6379", "host:", "host:six", "host:-1"])
def test_an_address_without_host_or_port_is_refused(ray, address):
    with pytest.raises(GrindError, match=f"^'{address}' is no address of a Ray cluster: give host:port as `ray start"):
        run_all(["good"], eventful, 1, QUIET, address, print)


@pytest.mark.parametrize("address", ["127.0.0.1:1", "127.0.0.1:99999999"])
def test_an_address_without_an_answer_is_refused(ray, address):
    with pytest.raises(GrindError, match=f"^no Ray cluster answers at '{address}' .*: give host:port as `ray start"):
        run_all(["good"], eventful, 1, QUIET, address, print)
    assert ray.joined == []


def test_an_answering_server_is_joined(ray):
    with socket.create_server(("127.0.0.1", 0)) as listening:
        address = f"127.0.0.1:{listening.getsockname()[1]}"
        assert run_all(["good"], eventful, 1, QUIET, address, {}.__setitem__) == {}
    assert ray.joined == [address]


def test_without_ray_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingExtra, match=r"--ray needs Ray: pip install '\.\[ray\]' in the checkout of grind_env"):
        run_all(["good"], eventful, 1, QUIET, "local", print)


@pytest.mark.nightly
def test_a_benchmark_goes_on_when_a_node_is_killed():
    pytest.importorskip("ray")
    # in a separate process, so that its children end with it
    subprocess.run([sys.executable, "-m", "tests.soak.nodes"], cwd=ROOT, check=True)
