"""Kill a node of a Ray cluster during a benchmark: `python -m tests.soak.nodes [EPISODES]`.

The script starts two nodes of one processor each on this machine. It checks that every trial ends exactly once, and
that the table equals the table without a cluster, apart from times. Needs `pip install '.[ray]'`.
"""

import os
import secrets
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

from agents.benchmark.results import COLUMNS, EPISODES, read_results
from agents.command_line import app
from agents.parallel_trials import _joined
from agents.study import Study
from tests.patience import wait_until

ROOT = Path(__file__).parents[2]
WORK = ["benchmark", "--tasks", "oracle6", "--kinds=", "--policies", "constant,interval,handbook,random,hindsight"]
TIMES = ("train_seconds", "decision_ms")
STARTS = 10  #: attempts to start a node: on a busy machine, a node gives up if its agent takes 15 s to start
STARTED = "Ray runtime started"
ENDED = 2  #: trials that end before the node is killed


def with_token(folder):
    """Protect the cluster with a new token; call this before the import of Ray, which reads these variables."""
    token = folder / "token"
    token.write_text(secrets.token_hex(32), encoding="utf-8")
    os.environ.update(RAY_AUTH_MODE="token", RAY_AUTH_TOKEN_PATH=str(token), RAY_USAGE_STATS_ENABLED="0")


def free_port():
    """Return a free port."""
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


@contextmanager
def node(output, *arguments):
    """Start a node of one processor, whose output goes to the file `output`; yield its process."""
    start = [sys.executable, "-m", "ray.scripts.scripts", "start", "--block", "--num-cpus=1"]
    command = [*start, "--object-store-memory=100000000", *arguments]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    for _ in range(STARTS):
        with output.open("w") as file:
            process = subprocess.Popen(command, env=environment, stdout=file, stderr=file, start_new_session=True)
        try:
            wait_until(lambda child=process: child.poll() is not None or STARTED in output.read_text())
            if process.poll() is None:
                yield process
                return
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    raise TimeoutError(output.read_text())


@contextmanager
def two_nodes(folder):
    """Start a cluster of two nodes; yield its address and a function that kills the second node."""
    address = f"127.0.0.1:{free_port()}"
    head = ["--head", f"--port={address.rpartition(':')[2]}", "--node-ip-address=127.0.0.1"]
    with node(folder / "head", *head, "--include-dashboard=false", "--no-monitor"):
        # join before the second node exists, or this process could join the second node
        ray = _joined(address, 1)
        with node(folder / "second", f"--address={address}") as second:
            wait_until(lambda: ray.cluster_resources().get("CPU") == 2)
            yield address, lambda: os.kill(raylet(second.pid), signal.SIGKILL)
        ray.shutdown()


def raylet(parent):
    """Return the id of the raylet process whose parent is `parent`."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            name, _, rest = (folder / "stat").read_text().partition("(")[2].rpartition(")")
            if name == "raylet" and int(rest.split()[1]) == parent:
                return int(folder.name)
        except OSError:
            continue
    raise ProcessLookupError(f"no raylet of {parent}")


def rows(folder):
    """Return the results in a folder without times, and the costs of every episode."""
    found = [[getattr(each, name) for name in COLUMNS if name not in TIMES] for each in read_results(folder)]
    costs = [[getattr(each, name).tobytes() for name in EPISODES] for each in read_results(folder)]
    return found, costs


def main(episodes):
    """Run the benchmark on a cluster that loses a node, and without a cluster; compare the results."""
    ended, cache = Counter(), Study.cache

    def counted(study, trial, found, runs):
        ended[str(trial)] += 1
        cache(study, trial, found, runs)

    with TemporaryDirectory() as place:
        with_token(Path(place))
        Study.cache = counted
        folders = {name: Path(place, name) for name in ("cluster", "alone")}
        size = ["--episodes", str(episodes), "--interpolation-episodes", "64"]
        with two_nodes(Path(place)) as (address, kill):
            began = time.monotonic()

            def kill_in_the_middle():
                wait_until(lambda: ended.total() >= ENDED)
                kill()
                print(f"second node killed after {time.monotonic() - began:.1f} s", flush=True)

            Thread(target=kill_in_the_middle, daemon=True).start()
            app([*WORK, *size, "--cache", str(folders["cluster"]), "--ray", address], standalone_mode=False)
            print(f"{len(ended)} trials after {time.monotonic() - began:.1f} s")
        Study.cache = cache
        assert set(ended.values()) == {1}, ended
        app([*WORK, *size, "--cache", str(folders["alone"]), "--jobs", "1"], standalone_mode=False)
        assert rows(folders["cluster"]) == rows(folders["alone"])
    print(f"each of {len(ended)} trials ended once, the tables are equal")


if __name__ == "__main__":
    # SIGTERM ends the nodes, too
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 640)
