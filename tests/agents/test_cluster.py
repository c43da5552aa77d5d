"""Cells on a Ray cluster: what is said where there is none, files on the way, and a cluster of this machine alone.

A node that dies in the middle: `python -m tests.soak.nodes`.
"""

import importlib.util
import os
import pickle
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import NamedTuple

import optuna
import pytest
from rich.console import Console

from agents import likeness, node
from agents.benchmark.measure import measure
from agents.benchmark.plan import Cell, Request
from agents.dressing.cells import cells
from agents.dressing.cells import find as find_finding
from agents.parcel import Outbox, packed, unpack
from agents.progress import Board
from agents.tuning import rules
from agents.tuning.away import add_missing, read_trials, write_trials
from agents.tuning.rules import Budget, Run, Tuner, do_run_away, search_name
from agents.tuning.studies import sqlite_url
from grind_env.errors import GrindError
from grind_env.extras import MissingExtra
from grind_env.files import FileError
from grind_env.policies.problem import Problem, find_problem

ROOT = Path(__file__).parents[2]
ORACLE = find_problem("oracle6")


class Lost(Exception):
    """A node is lost, as Ray says it."""


class TaskError(Lost):
    """Something goes wrong before a node can say so."""

    cause = ValueError("no such module")


class Task:
    """A generator that stands for a task, which may be lost after some messages."""

    def __init__(self, messages, most):
        self.messages, self.most = messages, most

    def __next__(self):
        if self.most == 0:
            return Lost()
        self.most -= 1
        return next(self.messages)


class FakeRay:
    """What `agents.cluster` asks of Ray, in this process; the first tasks are lost after so many messages."""

    exceptions = SimpleNamespace(RayError=Lost, RayTaskError=TaskError)

    def __init__(self, lost_after=()):
        self.lost_after, self.begun, self.cancelled = list(lost_after), 0, 0
        self._private = SimpleNamespace(worker=SimpleNamespace())

    def remote(self, **_):
        def begin(machine, order):
            self.begun += 1
            most = self.lost_after.pop(0) if self.lost_after else -1
            return Task(self.serve(machine, order), most)

        return lambda serve: setattr(self, "serve", serve) or SimpleNamespace(remote=begin)

    def get(self, answer):
        if isinstance(answer, Lost):
            raise answer
        return answer

    def wait(self, tasks, **_):
        return tasks[:1], tasks[1:]

    def cancel(self, task, force):
        self.cancelled += 1

    def is_initialized(self):
        return True

    def cluster_resources(self):
        return {"CPU": 2.0}


@pytest.fixture
def cluster(monkeypatch):
    """The module, whether Ray is installed or not; what it asks of Ray is set by `use`."""
    fake = FakeRay()
    monkeypatch.setitem(sys.modules, "ray", fake)
    spec = importlib.util.find_spec("agents.cluster")
    module = importlib.util.module_from_spec(spec)
    # what is pickled finds itself there
    monkeypatch.setitem(sys.modules, "agents.cluster", module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(node, "LOOK_SECONDS", 0.01)
    return module


class Named(NamedTuple):
    """A cell of a test."""

    problem: Problem
    name: str
    trains: bool = False

    @property
    def files(self):
        return (f"{self.name}/*",)


@dataclass(frozen=True)
class Asked:
    """How it is worked on."""

    runs: Path
    fresh: bool = False
    size: int = 3


def counting(cell, request, advance):
    """Three files, one after the other; those that are there are not made again."""
    made = 0
    for number in range(3):
        path = request.runs / cell.name / str(number)
        if not path.exists():
            unpack({f"{cell.name}/{number}": cell.name.encode()}, request.runs)
            made += 1
        advance(1)
        # until it has been looked for what is new
        time.sleep(0.05)
    if cell.name == "bad":
        raise GrindError(f"{request.runs / cell.name} is bad")
    return [cell.name, made]


def work(cluster, monkeypatch, fake, request, names=("a", "b")):
    monkeypatch.setattr(cluster, "ray", fake)
    asked = [Named(ORACLE, name) for name in names]
    return cluster.work_on_cluster(asked, request, "local", 2, Console(quiet=True), counting)


def test_what_is_found_far_away_is_kept_here(cluster, monkeypatch, tmp_path):
    found, failed = work(cluster, monkeypatch, FakeRay(), Asked(tmp_path), ["a", "bad", "b"])
    assert found == [["a", 3], ["b", 3]]
    # as the folder is named here, and not on the node
    assert list(failed.values()) == [f"{tmp_path / 'bad'} is bad"]
    assert sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()) == [
        f"{name}/{number}" for name in ("a", "b", "bad") for number in range(3)
    ]
    again, _ = work(cluster, monkeypatch, FakeRay(), Asked(tmp_path))
    assert again == [["a", 0], ["b", 0]]
    fresh, _ = work(cluster, monkeypatch, FakeRay(), Asked(tmp_path, fresh=True))
    assert fresh == [["a", 3], ["b", 3]]


@pytest.mark.parametrize("fresh", [False, True])
def test_a_cell_that_is_lost_begins_again_with_what_has_come_back(cluster, monkeypatch, tmp_path, fresh):
    # it says where it is, then a file and that it is done, and is lost
    fake = FakeRay([3])
    found, failed = work(cluster, monkeypatch, fake, Asked(tmp_path, fresh), ["a"])
    assert fake.begun == 2 and not failed
    assert found[0][0] == "a" and found[0][1] < 3


def test_a_cell_that_is_lost_again_and_again_is_given_up(cluster, monkeypatch, tmp_path):
    fake = FakeRay([1] * 100)
    found, failed = work(cluster, monkeypatch, fake, Asked(tmp_path))
    assert found == [] and set(failed.values()) == {cluster.GIVEN_UP}
    assert fake.begun == 2 * cluster.ATTEMPTS


def test_a_node_that_is_not_as_this_machine_is_is_refused(cluster, monkeypatch, tmp_path):
    ours = dict(likeness.of_machine())
    answers = [ours, ours | {"numpy": "1.0"}]
    monkeypatch.setattr(cluster.likeness, "of_machine", lambda: answers.pop(0))
    fake = FakeRay()
    with pytest.raises(GrindError, match=r"the node .* has numpy 1\.0 where this machine has .*commit"):
        work(cluster, monkeypatch, fake, Asked(tmp_path), ["a"])
    assert fake.cancelled == 1


def test_a_node_with_other_files_of_a_task_is_refused(cluster, monkeypatch, tmp_path):
    answers = [{"oracle6": "of here"}, {"oracle6": "of there"}]
    monkeypatch.setattr(cluster.likeness, "of_problem", lambda problem, trains: answers.pop(0))
    with pytest.raises(GrindError, match="has oracle6 of there where this machine has of here"):
        work(cluster, monkeypatch, FakeRay(), Asked(tmp_path), ["a"])


def test_a_node_that_cannot_begin_is_told_in_a_sentence(cluster, monkeypatch, tmp_path):
    fake = FakeRay()
    monkeypatch.setattr(fake, "get", lambda answer: (_ for _ in ()).throw(TaskError()))
    with pytest.raises(GrindError, match=r"cannot work on cells \(ValueError: no such module\): it must have commit"):
        work(cluster, monkeypatch, fake, Asked(tmp_path))


@pytest.fixture
def outside(cluster, monkeypatch):
    """The module while it belongs to no cluster; Ray joins whatever it is told to."""
    fake = FakeRay()
    fake.joined = []
    monkeypatch.setattr(fake, "is_initialized", lambda: False)
    monkeypatch.setattr(fake, "init", lambda address, **_: fake.joined.append(address), raising=False)
    monkeypatch.setattr(cluster, "atexit", SimpleNamespace(register=lambda leave: None))
    monkeypatch.setattr(cluster, "ray", fake)
    monkeypatch.setattr(cluster, "ANSWER_SECONDS", 0.2)
    return cluster


@pytest.mark.parametrize("address", ["nowhere", "10.0.0.1", ":6379", "host:", "host:six", "host:-1"])
def test_an_address_without_host_or_port(outside, address):
    with pytest.raises(GrindError, match=f"^'{address}' is no address of a Ray cluster: give host:port as `ray start"):
        outside.connect(address, 1)


@pytest.mark.parametrize("address", ["127.0.0.1:1", "127.0.0.1:99999999"])
def test_an_address_at_which_nobody_answers(outside, address):
    with pytest.raises(GrindError, match=f"^no Ray cluster answers at '{address}' .*: give host:port as `ray start"):
        outside.connect(address, 1)


@contextmanager
def server(answer):
    """The address of a server that says one thing to one client."""
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def serve():
            connection, _ = listening.accept()
            # who has read enough may leave the rest
            with connection, suppress(ConnectionResetError):
                connection.sendall(answer)
                # until the client has gone
                while connection.recv(1000):
                    pass

        Thread(target=serve, daemon=True).start()
        yield f"127.0.0.1:{listening.getsockname()[1]}"


@pytest.mark.parametrize("answer", [b"", b"220 mail.example ESMTP\r\n", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_a_server_that_is_not_of_ray_is_not_waited_for(outside, answer):
    with server(answer) as address, pytest.raises(GrindError, match=rf"answers at '{address}' \((timed out|what list)"):
        outside.connect(address, 1)
    assert outside.ray.joined == []


def test_a_server_that_greets_as_ray_does_is_joined(outside):
    # a frame of settings with one of them, as gRPC sends it
    with server(bytes.fromhex("000006040000000000000500004000")) as address:
        outside.connect(address, 1)
    assert outside.ray.joined == [address]


def test_a_head_of_another_version_is_told_with_both_versions(outside, monkeypatch):
    said = "Version mismatch: The cluster was started with:\n    Ray: 2.1.0\nThis process on me:\n    Ray: 2.60\n"

    def init(address, **_):
        raise RuntimeError(said)

    monkeypatch.setattr(outside.ray, "init", init)
    with server(bytes.fromhex("000000040000000000")) as address, pytest.raises(GrindError) as raised:
        outside.connect(address, 1)
    assert str(raised.value) == (
        "Version mismatch: The cluster was started with: Ray: 2.1.0 This process on me: Ray: 2.60:"
        " install the same versions on all machines"
    )


def test_without_ray_the_extra_is_named(monkeypatch):
    monkeypatch.delitem(sys.modules, "agents.cluster", raising=False)
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingExtra, match=r"--ray needs Ray: pip install '\.\[ray\]' in the checkout of grind_env"):
        importlib.import_module("agents.cluster")


def test_parcels_hold_whole_files_and_tell_what_is_gone(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    unpack({"a/x": b"1", "a/y": b"2", "b/x": b"3"}, here)
    (here / "a" / ".unfinished").write_bytes(b"4")
    unpack(packed(here, ["a/*"]), there)
    assert packed(there, ["**/*"]) == {"a/x": b"1", "a/y": b"2"}
    outbox = Outbox(there, ["a/*"])
    assert outbox.changes() == {}
    (there / "a" / "x").unlink()
    unpack({"a/y": b"5", "a/z": b"6"}, there)
    changes = outbox.changes()
    assert changes == {"a/x": None, "a/y": b"5", "a/z": b"6"} and outbox.changes() == {}
    unpack(changes, here)
    assert packed(here, ["**/*"]) == {"a/y": b"5", "a/z": b"6", "b/x": b"3"}


@pytest.mark.parametrize("name", ["../x", "a/../../x", "/tmp/x", "a/..", ".."])
@pytest.mark.parametrize("content", [b"1", None])
def test_no_name_leads_out_of_the_folder(tmp_path, name, content):
    folder, beside = tmp_path / "folder", tmp_path / "x"
    folder.mkdir()
    beside.write_bytes(b"of before")
    with pytest.raises(FileError, match=f"^'{name}', which a cell sends, leads out of {folder}: it is not written$"):
        unpack({name: content}, folder)
    assert beside.read_bytes() == b"of before" and not list(folder.iterdir())


def test_a_run_of_a_tuning_far_from_its_database_goes_on_in_its_file(tmp_path, monkeypatch):
    run, runs = Run(ORACLE, "power_threshold", 1), tmp_path / "away"
    budget = Budget(storage="", evaluations=12, episodes=1, runs=runs, fresh=False)
    done = []
    do_run_away(run, budget, done.append)
    here = Tuner(ORACLE.simulation(), sqlite_url(tmp_path / "here.db"), 1)
    alone = here.run(run.policy, 12, run.seed)
    kept = here.study(search_name(run.policy, run.seed))
    assert sum(done) == alone.evaluations
    found = read_trials(runs / run.file, kept.study_name)
    assert [trial.user_attrs for trial in found] == [trial.user_attrs for trial in kept.get_trials()]
    assert read_trials(runs / run.file, "another") == []

    there = Tuner(ORACLE.simulation(), sqlite_url(tmp_path / "there.db"), 1)
    study = there.study(search_name(run.policy, run.seed))
    add_missing(study, found[:1])
    add_missing(study, found)
    assert len(study.get_trials(states=[optuna.trial.TrialState.COMPLETE])) == len(found)
    # nothing is evaluated again
    monkeypatch.setattr(rules.Tuner, "costs", None)
    assert there.run(run.policy, 12, run.seed)[1:] == alone[1:]
    (runs / "tune.db").unlink()
    do_run_away(run, budget, done.append)
    before = (runs / run.file).stat().st_mtime_ns
    write_trials(runs / run.file, study)
    assert (runs / run.file).stat().st_mtime_ns == before


def test_cells_name_all_that_is_kept_of_them(tmp_path, monkeypatch):
    request = Request(episodes=3, interpolation_episodes=2, runs=tmp_path)
    cell = Cell(ORACLE, "handbook")
    measure(cell, request)
    assert len(packed(tmp_path, cell.files)) == 4 == len(packed(tmp_path, ["**/*"]))
    for variant in (Cell(ORACLE, "hindsight@1"), Cell(ORACLE, "power_threshold@1M")):
        monkeypatch.setattr("agents.benchmark.measure.LIMIT", 48 * 6 * 20)
        before = packed(tmp_path, ["**/*"]).keys()
        measure(variant, request)
        found = packed(tmp_path, ["**/*"]).keys() - before
        assert len(found) >= 2 and found == packed(tmp_path, variant.files).keys()
    study = SimpleNamespace(episodes=2, runs=tmp_path / "study", configs=None)
    listed = cells(ORACLE)
    assert len({str(each) for each in listed}) == len(listed)
    for each in (listed[-1], next(each for each in listed if each.policy == "adaptive_rule")):
        before = packed(study.runs, ["**/*"])
        find_finding(each, study, lambda done: None)
        after = packed(study.runs, ["**/*"])
        assert after.keys() - before.keys() and after.keys() - before.keys() <= packed(study.runs, each.files).keys()


def test_cells_requests_and_facts_can_be_sent(tmp_path):
    for each in (Cell(ORACLE, "ppo", 1), Run(ORACLE, "power_threshold", 0), *cells(ORACLE)[:1]):
        assert pickle.loads(pickle.dumps(each)) == each
    facts = likeness.of_machine()
    assert likeness.difference("node", pickle.loads(pickle.dumps(facts)), facts) is None


def test_a_lost_cell_is_told_and_has_one_bar(capsys):
    console = Console(width=100, force_terminal=False)
    with Board(["a"], 3, console) as board:
        board.begin("a", "on here")
        board.lose("a", "lost")
        board.begin("a", "on there")
        board.end("a", 1)
    assert board.ended() == ([1], {}) and "a: lost" in capsys.readouterr().out


def test_a_cluster_of_this_machine_alone_has_the_table_of_processes(tmp_path):
    pytest.importorskip("ray", reason="needs Ray: pip install '.[ray]'")
    token = tmp_path / "token"
    token.write_text("0123456789abcdef" * 4)
    environment = os.environ | {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN_PATH": str(token), "PYTHONPATH": str(ROOT)}
    words = ["benchmark", "--tasks=oracle6", "--kinds=", "--policies=handbook", "--episodes=70", "--jobs=1"]
    tables = []
    for name, where in (("alone", []), ("ray", ["--ray", "local"])):
        folder = tmp_path / name
        command = [sys.executable, "-m", "agents", *words, "--interpolation-episodes=2", "--plants-episodes=0"]
        command += ["--runs", str(folder), *where]
        subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True)
        tables.append((folder / "benchmark.csv").read_text())
        assert len(list(folder.rglob("*.npz"))) == 3 * 5
    assert tables[0] == tables[1]
