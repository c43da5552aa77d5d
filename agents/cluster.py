"""Works on cells as tasks of Ray: on the nodes of a cluster, or in workers of this machine alone.

A task works in a folder of its own. It gets the files that are kept of its cell, and whatever it writes there comes
back at once: this machine alone writes what is kept, and nodes need no folder in common. A task that is lost with its
node begins anew with what has come back of it.
"""

import atexit
import os
import pickle
import queue
import socket
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol

from rich.console import Console

from agents import likeness
from agents.parcel import Outbox, Parcel, packed, unpack
from agents.progress import Board, FoundT, RequestT, Work, sentence
from agents.provenance import commit
from grind_env.errors import GrindError, quoted, reason
from grind_env.extras import needing
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import tuned_folder

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
LOOK_SECONDS = 0.5
"""Between two looks for what a cell has written."""
ATTEMPTS = 4
"""How often a cell is begun before it is given up; a node that dies is rarely its fault."""
STORE_BYTES = 200_000_000
"""Shared memory of a cluster of this machine alone; messages are small."""
LOST = "its worker or its node was lost; it begins again with what has come back"
GIVEN_UP = f"its worker or its node was lost {ATTEMPTS} times; the same command goes on with it"


class Cell(Protocol):
    """What can be worked on far away."""

    @property
    def problem(self) -> Problem:
        """What is ground."""

    @property
    def files(self) -> Sequence[str]:
        """Patterns of what is kept of it, below the folder of what is kept."""

    @property
    def trains(self) -> bool:
        """Whether an agent is trained."""


class Unlike(NamedTuple):
    """A node is not as this machine is; the sentence says in what."""

    said: str


class Ended(NamedTuple):
    """What was found, or the sentence on what failed."""

    answer: Any


@dataclass(frozen=True, slots=True)
class Order:
    """What a node needs to work on a cell.

    Attributes:
        cell: to be worked on.
        request: how.
        work: by what function.
        problem: what it must have as the machine that asks, to grind the problem.
        here: working folder of the machine that asks, in which relative names are meant.
        kept: files of the cell.
        parameters: files of the tuned parameters.
    """

    cell: Any
    request: Any
    work: Work[Any, Any, Any]
    problem: likeness.Facts
    here: str
    kept: Parcel
    parameters: Parcel


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
    serve = ray.remote(num_cpus=1, max_retries=0, num_returns="streaming")(_serve)
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
                    order = pickle.dumps(_order(cell, request, work, kept))
                    busy[serve.remote(likeness.of_machine(), order)] = cell
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
        remedy = (
            "give host:port as `ray start --head` prints it, run `ray start --address` on this machine, too,"
            " and set RAY_AUTH_MODE=token if the cluster asks for a token"
        )
        try:
            with socket.create_connection((host, int(port)), ANSWER_SECONDS):
                pass
            ray.init(address=address, **quiet)
        except (OSError, RuntimeError, ValueError, OverflowError) as error:
            raise GrindError(f"no Ray cluster answers at {quoted(address)} ({reason(error)}): {remedy}") from None
    atexit.register(ray.shutdown)


def _processors() -> int:
    """Of all nodes that are there now; one, if there is none, so that a task waits for it."""
    return max(1, int(ray.cluster_resources().get("CPU", 0)))


def _order(cell: Cell, request: Any, work: Any, kept: Parcel) -> Order:
    folder = _configs(cell, request)
    return Order(
        cell=cell,
        request=request,
        work=work,
        problem=likeness.of_problem(cell.problem, cell.trains),
        here=str(Path.cwd()),
        kept=kept,
        parameters=packed(folder, [f"{cell.problem.name}.toml"]),
    )


def _configs(cell: Cell, request: Any) -> Path:
    return tuned_folder(cell.problem.simulation().task, getattr(request, "configs", None))


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


def _serve(machine: likeness.Facts, pickled: bytes) -> Iterator[Any]:
    """Work on a cell on a node: yields where, how far it is, files, and at last what has come of it.

    Args:
        machine: what the node must have as the machine that asks; with other code it might not read the order.
        pickled: an `Order`.
    """
    node = socket.gethostname()
    if said := likeness.difference(node, likeness.of_machine(), machine):
        yield Unlike(said)
        return
    order: Order = pickle.loads(pickled)
    cell, request = order.cell, order.request
    # a node that has no such folder has no files of one's own there either, and says so
    with suppress(OSError):
        os.chdir(order.here)
    yield f"on {node}"
    try:
        problem = likeness.of_problem(cell.problem, cell.trains)
    except Exception as error:
        yield Ended(sentence(error))
        return
    if said := likeness.difference(node, problem, order.problem):
        yield Unlike(said)
        return
    with TemporaryDirectory(prefix="grind-") as place:
        runs, configs = Path(place, "runs"), Path(place, "parameters")
        unpack(order.kept, runs)
        unpack(order.parameters, configs)
        outbox, told = Outbox(runs, cell.files), queue.SimpleQueue[Any]()
        there = {"runs": runs, "fresh": False, **({"configs": configs} if order.parameters else {})}
        moved = replace(request, **{each.name: there[each.name] for each in fields(request) if each.name in there})
        threading.Thread(target=_work, args=(cell, moved, order.work, told), daemon=True).start()
        ended: Ended | None = None
        while ended is None:
            done, ended = _told(told)
            if changed := outbox.changes():
                yield changed
            if done:
                yield done
        said_there = partial(_here, {configs: _configs(cell, request), runs: request.runs})
        yield Ended(said_there(ended.answer))


def _work(cell: Any, request: Any, work: Any, told: "queue.SimpleQueue[Any]") -> None:
    try:
        told.put(Ended(work(cell, request, told.put)))
    # whatever goes wrong in one cell must not stop the others
    except Exception as error:
        told.put(Ended(sentence(error)))


def _told(told: "queue.SimpleQueue[Any]") -> tuple[int, Ended | None]:
    """How much more is done, and the end if it has come, at the latest after `LOOK_SECONDS`."""
    done = 0
    with suppress(queue.Empty):
        message = told.get(timeout=LOOK_SECONDS)
        while not isinstance(message, Ended):
            done += message
            message = told.get_nowait()
        return done, message
    return done, None


def _here(folders: dict[Path, Path], answer: Any) -> Any:
    """An answer in which the folders of a node have the names that they have on the machine that asks."""
    if isinstance(answer, str):
        for there, here in folders.items():
            answer = answer.replace(str(there), str(here))
    return answer
