"""Works on many cells in processes side by side. One that fails does not stop the others."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console

from agents.progress import Board, CellT, FoundT, RequestT, Work, sentence
from grind_env.errors import GrindError

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
KILLED = "its process was killed; the same command goes on with it"


class Worker(NamedTuple):
    """A process, and the pipe through which it gets cells and sends how far it is and answers."""

    process: SpawnProcess
    pipe: "Connection[object, object]"


def work_on_all(
    cells: Sequence[CellT],
    request: RequestT,
    jobs: int,
    console: Console,
    work: Work[CellT, RequestT, FoundT],
    cluster: str | None = None,
) -> tuple[list[FoundT], dict[CellT, str]]:
    """Work on cells, `jobs` of them at a time, or as many as a cluster has processors.

    Args:
        cells: in the order in which they are begun.
        request: how.
        jobs: number of processes; each calculates on one thread.
        console: shows how far they are, and why a cell failed.
        work: a function of a module, which processes import.
        cluster: of Ray that works on them in place of processes of our own; see `agents.cluster`.

    Returns:
        What was found, in the order of the cells, and one sentence of each cell that failed.

    Raises:
        GrindError: the cluster does not answer, or a node of it is not as this machine is.
    """
    # the libraries of the workers read it when they are loaded
    os.environ.update(dict.fromkeys(THREADS, "1"))
    if cluster is not None:
        from agents.cluster import work_on_cluster

        return work_on_cluster(cells, request, cluster, jobs, console, work)
    waiting = list(cells)
    idle: list[Worker] = []
    busy: dict[Worker, CellT] = {}
    with Board(cells, request.size, console) as board:
        try:
            while waiting or busy:
                while waiting and len(busy) < jobs:
                    idle = [worker for worker in idle if worker.process.is_alive()]
                    worker = idle.pop() if idle else _start(work, request)
                    cell = waiting.pop(0)
                    worker.pipe.send(cell)
                    busy[worker] = cell
                    board.begin(cell)
                ready = wait([worker.pipe for worker in busy])
                for worker in [worker for worker in busy if worker.pipe in ready]:
                    message = _received(worker)
                    if isinstance(message, int):
                        board.advance(busy[worker], message)
                        continue
                    board.end(busy.pop(worker), message)
                    idle.append(worker)
        finally:
            for worker in [*idle, *busy]:
                worker.process.terminate()
                worker.process.join()
    return board.ended()


def find_all(
    cells: Sequence[CellT],
    request: RequestT,
    jobs: int,
    console: Console,
    work: Work[CellT, RequestT, FoundT],
) -> list[FoundT]:
    """What was found in every cell, in their order; arguments as of `work_on_all`.

    Raises:
        GrindError: a cell failed.
    """
    found, failed = work_on_all(cells, request, jobs, console, work)
    if failed:
        cell, why = next(iter(failed.items()))
        raise GrindError(f"{len(failed)} of {len(cells)} cells failed: {cell}: {why}")
    return found


def _start(work: Work[CellT, RequestT, FoundT], request: RequestT) -> Worker:
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=_serve, args=(theirs, work, request))
    # Ctrl-C reaches all processes of a terminal; only the parent answers it, and ends its workers, which inherit this
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process.start()
    finally:
        signal.signal(signal.SIGINT, before)
    # only the worker holds it now: the pipe ends when the worker does
    theirs.close()
    return Worker(process, ours)


def _received(worker: Worker) -> Any:
    """The next message of a worker: a number of what is done, a sentence on what failed, or what was found."""
    try:
        return worker.pipe.recv()
    except (EOFError, OSError):
        worker.process.join()
        return KILLED


def _serve(pipe: "Connection[object, object]", work: Work[Any, RequestT, Any], request: RequestT) -> None:
    """Work on cells, print nothing, and end with the parent, however that ends."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with (
        Path(os.devnull).open("w", encoding="utf-8") as nowhere,
        redirect_stdout(nowhere),
        redirect_stderr(nowhere),
        # the parent has ended, and with it the pipe
        suppress(EOFError, OSError),
    ):
        while True:
            cell = pipe.recv()
            try:
                pipe.send(work(cell, request, pipe.send))
            # whatever goes wrong in one cell must not stop the others
            except Exception as error:
                pipe.send(sentence(error))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
