"""Works on cells as tasks of Ray: on the nodes of a cluster, or in workers of this machine alone.

A task gets the files that are kept of its cell, and whatever it writes comes back at once: this machine alone writes
what is kept. A task that is lost with its node begins anew with what has come back of it.
"""

import atexit
import os
import pickle
import signal
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from agents import likeness
from agents.node import Ended, Unlike, ordered, serve
from agents.parcel import packed, unpack
from agents.progress import Board, FoundT, RequestT, Work, sentence
from agents.provenance import commit
from grind_env.errors import GrindError, quoted, reason, shortened
from grind_env.extras import needing

# before Ray is imported: nobody is told of what is run here
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
with needing("ray", "--ray needs"):
    import ray

# of a node that has died it prints the log, in the middle of bars and tables, and has no option against it
ray._private.worker.print_to_stdstream = lambda *_, **__: None

LOCAL = "local"
"""Stands for workers of this machine alone."""
ANSWER_SECONDS = 5.0
"""How long the head of a cluster may take to answer."""
SETTINGS = b"\x04"
"""Type of the frame that each side of HTTP/2 sends first, after the length of three bytes (RFC 9113, 4.1 and 3.4)."""
FRAME_HEAD = 9
"""Bytes before what a frame carries."""
GREETING = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes(3) + SETTINGS + bytes(5)
"""What a client says first: the preface, and no settings."""
HEAD = (
    "give host:port as `ray start --head` prints it, run `ray start --address` on this machine, too,"
    " and set RAY_AUTH_MODE=token if the cluster asks for a token"
)
LONGEST_REASON = 300
"""Characters that a message shows of what Ray says; of another version it says both."""
ATTEMPTS = 4
"""How often a cell is begun before it is given up; a node that dies is rarely its fault."""
STORE_BYTES = 200_000_000
"""Shared memory of a cluster of this machine alone; messages are small."""
LOST = "its worker or its node was lost; it begins again with what has come back"
GIVEN_UP = f"its worker or its node was lost {ATTEMPTS} times; the same command goes on with it"


def work_on_cluster(
    cells: Sequence[Any],
    request: RequestT,
    address: str,
    jobs: int,
    console: Console,
    work: Work[Any, RequestT, FoundT],
) -> tuple[list[FoundT], dict[Any, str]]:
    """As `pool.work_on_all`.

    Args:
        cells: each a `Cell`.
        request: a dataclass with a folder `runs`; if it has them, its `configs` are sent, too, and its `fresh` leaves
            out what was kept before.
        address: `host:port` of the head of a cluster that this machine is a node of, or `local`.
        jobs: number of workers, if they are of this machine alone.
        console: as there.
        work: as there.

    Raises:
        GrindError: Ray is not installed, the cluster does not answer, or a node is not as this machine is.
    """
    connect(address, jobs)
    remote = ray.remote(num_cpus=1, max_retries=0, num_returns="streaming")(serve)
    attempts = dict.fromkeys(cells, 0)
    waiting = list(cells)
    busy: dict[Any, Any] = {}
    kept_before = not getattr(request, "fresh", False)
    runs: Path = request.runs  # type: ignore[attr-defined]
    with Board(cells, request.size, console) as board:
        try:
            while waiting or busy:
                while waiting and len(busy) < _processors():
                    cell = waiting.pop(0)
                    kept = packed(runs, cell.files) if kept_before or attempts[cell] else {}
                    attempts[cell] += 1
                    order = pickle.dumps(ordered(cell, request, work, kept))
                    busy[remote.remote(likeness.of_machine(), order)] = cell
                ready, _ = ray.wait(list(busy), timeout=1.0, fetch_local=False)
                for task in ready:
                    cell, message = busy[task], _received(task)
                    if isinstance(message, Unlike):
                        raise GrindError(message.said)
                    if isinstance(message, str):
                        board.begin(cell, message)
                    elif isinstance(message, int):
                        board.advance(cell, message)
                    elif isinstance(message, dict):
                        unpack(message, runs)
                    elif isinstance(message, Ended):
                        del busy[task]
                        board.end(cell, message.answer)
                    else:
                        del busy[task]
                        if attempts[cell] < ATTEMPTS:
                            board.lose(cell, LOST)
                            waiting.insert(0, cell)
                        else:
                            board.end(cell, GIVEN_UP)
        finally:
            for task in busy:
                ray.cancel(task, force=True)
    return board.ended()


def connect(address: str, jobs: int) -> None:
    """Join a cluster, or start one of this machine alone, once in a process.

    Raises:
        GrindError: it does not answer, or is of another version of Ray or Python.
    """
    if ray.is_initialized():
        return
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
    if address == LOCAL:
        try:
            ray.init(address=LOCAL, num_cpus=jobs, include_dashboard=False, object_store_memory=STORE_BYTES, **quiet)
        # it has no type for it
        except Exception as error:
            raise GrindError(f"Ray does not start on this machine ({reason(error)}): leave out --ray") from None
    else:
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal():
            raise GrindError(f"{quoted(address)} is no address of a Ray cluster: {HEAD}")
        try:
            _greet(host, int(port))
            ray.init(address=address, **quiet)
        except (OSError, RuntimeError, ValueError, OverflowError) as error:
            said = shortened(" ".join(str(error).split()), LONGEST_REASON)
            if said.startswith("Version mismatch"):
                raise GrindError(f"{said}: install the same versions on all machines") from None
            raise GrindError(f"no Ray cluster answers at {quoted(address)} ({said}): {HEAD}") from None
    atexit.register(_leave)


def _leave() -> None:
    # it takes seconds, and another Ctrl-C would leave processes behind
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    ray.shutdown()


def _greet(host: str, port: int) -> None:
    """Look for a server at an address that speaks HTTP/2, as each of Ray does: others it asks again for minutes.

    Raises:
        OSError: there is none.
    """
    with socket.create_connection((host, port), ANSWER_SECONDS) as connection:
        # through TLS only Ray can ask
        if os.environ.get("RAY_USE_TLS", "0").lower() in ("1", "true"):
            return
        connection.sendall(GREETING)
        answer = connection.recv(FRAME_HEAD)
    if answer[3:4] != SETTINGS:
        raise ConnectionError("what listens there is not Ray")


def _processors() -> int:
    """Of all nodes that are there now; one, if there is none, so that a task waits for it."""
    return max(1, int(ray.cluster_resources().get("CPU", 0)))


def _received(task: Any) -> Any:
    """The next message of a task; None if there will be none, because its worker or its node has gone."""
    try:
        return ray.get(next(task))
    except StopIteration:
        return None
    except ray.exceptions.RayTaskError as error:
        # what goes wrong in a cell the node says itself
        raise GrindError(
            f"a node cannot work on cells ({sentence(error.cause)}): it must have commit {commit()} and its libraries"
        ) from None
    except ray.exceptions.RayError:
        return None
