"""Run trials in processes of this machine, or as tasks of Ray on a cluster. One that fails does not stop the others."""

import atexit
import multiprocessing
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.provenance import commit
from grind_env.errors import GrindError, quoted, reason
from grind_env.extras import needing

TrialT = TypeVar("TrialT")
FoundT = TypeVar("FoundT")
Answers = Generator[tuple[Any, Any], None, None]

ENVIRONMENT = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "RAY_USAGE_STATS_ENABLED": "0",
    "PYTHONWARNINGS": "ignore:resource_tracker",  # of a parent that was killed it prints what was left
}
"""Of the workers, whose libraries read it when they are loaded."""
LOCAL = "local"
RETRIES = 3
"""How often Ray begins a trial again whose worker or node was lost."""
ANSWER_SECONDS = 5.0
"""How long the head of a cluster may take to answer."""
KILLED = "its process was killed; the same command goes on with it"
LOST = f"its worker or node was lost {1 + RETRIES} times; the same command goes on with it"
HEAD = "give host:port as `ray start --head` prints it, and run `ray start --address` on this machine, too"


class Failed(str):
    """A sentence on what failed."""


def run_all(
    trials: Sequence[TrialT],
    run: Callable[[TrialT], FoundT],
    jobs: int,
    console: Console,
    ray: str | None = None,
    done: Callable[[TrialT, FoundT], object] = lambda trial, found: None,
) -> tuple[dict[TrialT, FoundT], dict[TrialT, str]]:
    """Return what was found in trials, and one sentence of each that failed.

    Args:
        trials: in the order in which they begin.
        run: a function of a module, which processes import.
        jobs: number of processes; each calculates on one thread.
        console: shows how many are done, and why one failed.
        ray: `host:port` of the head of a Ray cluster that this machine is a node of, or `local`.
        done: called here with each trial that has ended and what was found.

    Raises:
        GrindError: the cluster does not answer.
    """
    os.environ.update(ENVIRONMENT)
    found: dict[TrialT, FoundT] = {}
    failed: dict[TrialT, str] = {}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    answers = _processes(trials, run, jobs) if ray is None else _tasks(trials, run, ray, jobs)
    with Progress(*columns, console=console, transient=True) as progress, closing(answers):
        bar = progress.add_task("trials", total=len(trials))
        for trial, answer in answers:
            if isinstance(answer, Failed):
                failed[trial] = str(answer)
                console.print(f"{trial}: {answer}", highlight=False, markup=False, soft_wrap=True)
            else:
                done(trial, answer)
                found[trial] = answer
            progress.update(bar, advance=1, description=str(trial))
    return {trial: found[trial] for trial in trials if trial in found}, failed


def attempt(run: Callable[[Any], Any], trial: Any, asked: str = "") -> Any:
    """Return what is found in a trial, or `Failed`; `asked` is the commit that a node must have."""
    if asked and commit() != asked:
        return Failed(f"the node {socket.gethostname()} has commit {commit()} and not {asked}: check out the same")
    try:
        return run(trial)
    # whatever goes wrong in one trial must not stop the others
    except Exception as error:
        known = type(error).__module__.partition(".")[0] in ("grind_env", "agents")
        return Failed(" ".join(f"{'' if known else f'{type(error).__name__}: '}{error}".split()))


def _processes(trials: Sequence[Any], run: Callable[[Any], Any], jobs: int) -> Answers:
    # a pool of one process for each job: a process that is killed takes no other trial with it
    pools = SimpleQueue[ProcessPoolExecutor]()
    begun = list[ProcessPoolExecutor]()

    def begin() -> None:
        begun.append(ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin_worker))
        begun[-1].submit(int)
        pools.put(begun[-1])

    def one(trial: Any) -> tuple[Any, Any]:
        pool = pools.get()
        try:
            answer = pool.submit(attempt, run, trial).result()
        except BrokenProcessPool:
            begin()
            return trial, Failed(KILLED)
        pools.put(pool)
        return trial, answer

    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # workers inherit it: Ctrl-C is for their parent
    for _ in range(min(jobs, len(trials))):
        begin()
    signal.signal(signal.SIGINT, before)
    threads = ThreadPoolExecutor(jobs)
    try:
        yield from (each.result() for each in as_completed([threads.submit(one, trial) for trial in trials]))
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        for process in [process for pool in begun for process in (pool._processes or {}).values()]:
            process.terminate()


def _begin_worker() -> None:
    """Let a worker print nothing, and end with its parent, however that ends."""
    sys.stdout = sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent: Any = multiprocessing.parent_process()
    parent.join()
    os._exit(1)


def _tasks(trials: Sequence[Any], run: Callable[[Any], Any], address: str, jobs: int) -> Answers:
    ray = _joined(address, jobs)
    remote = ray.remote(num_cpus=1, max_retries=RETRIES)(attempt)
    tasks = {remote.remote(run, trial, commit()): trial for trial in trials}
    try:
        while tasks:
            for task in ray.wait(list(tasks), timeout=1.0)[0]:
                trial = tasks.pop(task)
                try:
                    yield trial, ray.get(task)
                except ray.exceptions.RayTaskError as error:
                    yield trial, Failed(f"a node cannot run it ({reason(error.cause)}): it must have commit {commit()}")
                except ray.exceptions.RayError:
                    yield trial, Failed(LOST)
    finally:
        for task in tasks:
            ray.cancel(task, force=True)


def _joined(address: str, jobs: int) -> Any:
    """Return Ray, after joining a cluster or starting one of this machine alone, once in a process."""
    with needing("ray", "--ray needs"):
        import ray
    if ray.is_initialized():
        return ray
    # it has no option against printing the log of a dead node in the middle of a table
    ray._private.worker.print_to_stdstream = lambda *_, **__: None
    host, _, port = address.rpartition(":")
    if address != LOCAL and not (host and port.isdecimal()):
        raise GrindError(f"{quoted(address)} is no address of a Ray cluster: {HEAD}")
    try:
        if address != LOCAL:
            # Ray itself would ask for minutes
            socket.create_connection((host, int(port)), ANSWER_SECONDS).close()
        own: dict[str, Any] = {"num_cpus": jobs, "include_dashboard": False} if address == LOCAL else {}
        ray.init(address=address, log_to_driver=False, logging_level="ERROR", **own)
    except (OSError, RuntimeError, ValueError, OverflowError) as error:
        raise GrindError(f"no Ray cluster answers at {quoted(address)} ({reason(error)}): {HEAD}") from None
    atexit.register(ray.shutdown)
    return ray
