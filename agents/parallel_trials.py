"""Runs of trials in processes or as tasks of a Ray cluster. A failed trial does not stop the others."""

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
from typing import Any

from rich.console import Console
from rich.progress import Progress

from agents.provenance import commit
from grind_env.errors import GrindError
from grind_env.message_text import quoted, reason
from grind_env.optional_libraries import needing

Answers = Generator[tuple[Any, Any], None, None]

#: environment of the workers, whose libraries read it when they are loaded
ENVIRONMENT = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "RAY_USAGE_STATS_ENABLED": "0",
    "PYTHONWARNINGS": "ignore:resource_tracker",  # hides messages on leftovers of a killed parent
}
#: number of times that Ray repeats a trial of a lost worker or node, and time limit of a cluster's answer, s
RETRIES, ANSWER_SECONDS = 3, 5.0
KILLED = "its process was killed; the same command goes on with it"
LOST = f"its worker or node was lost {1 + RETRIES} times; the same command goes on with it"
HEAD = "give host:port as `ray start --head` prints it, and run `ray start --address` on this machine, too"


class Failed(str):
    """Sentence on the failure of a trial."""


def run_all(
    trials: Sequence[Any],
    run: Callable[[Any], Any],
    jobs: int,
    console: Console,
    ray: str | None,
    done: Callable[[Any, Any], object],
) -> dict[Any, str]:
    """Run trials by a function of a module; return a sentence for each failed trial.

    `jobs` processes run the trials, on one thread each, or a Ray cluster: `ray` is `host:port` of its head, or `local`.
    `done` is called in this process with each finished trial and its result.

    Raises:
        GrindError: the cluster does not answer.
    """
    os.environ.update(ENVIRONMENT)
    failed = dict[Any, str]()
    answers = _processes(trials, run, jobs) if ray is None else _tasks(trials, run, ray, jobs)
    with Progress(console=console, transient=True) as progress, closing(answers):
        bar = progress.add_task("trials", total=len(trials))
        for trial, answer in answers:
            if isinstance(answer, Failed):
                failed[trial] = str(answer)
                console.print(f"{trial}: {answer}", highlight=False, markup=False, soft_wrap=True)
            else:
                done(trial, answer)
            progress.update(bar, advance=1, description=str(trial))
    return failed


def attempt(run: Callable[[Any], Any], trial: Any, asked: str = "") -> Any:
    """Return the result of a trial, or `Failed`; `asked` is the commit that a node must have."""
    if asked and commit() != asked:
        return Failed(f"the node {socket.gethostname()} has commit {commit()} and not {asked}: check out the same")
    try:
        return run(trial)
    # whatever goes wrong in one trial must not stop the others
    except Exception as error:
        known = type(error).__module__.partition(".")[0] in ("grind_env", "agents")
        return Failed(" ".join(f"{'' if known else f'{type(error).__name__}: '}{error}".split()))


def _processes(trials: Sequence[Any], run: Callable[[Any], Any], jobs: int) -> Answers:
    # one pool of one process per job, so that a killed process stops no other trial
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

    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # workers inherit it, so that Ctrl-C stops only the parent
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
    """Let a worker print nothing, and end with its parent, even if the parent is killed."""
    sys.stdout = sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    parent: Any = multiprocessing.parent_process()
    threading.Thread(target=lambda: os._exit(parent.join() or 1), daemon=True).start()


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
                except ray.exceptions.RayError as error:
                    known = isinstance(error, ray.exceptions.RayTaskError)
                    yield trial, Failed(f"a node cannot run it: it must have commit {commit()}" if known else LOST)
    finally:
        for task in tasks:
            ray.cancel(task, force=True)


def _joined(address: str, jobs: int) -> Any:
    """Return Ray after joining a cluster or, for the address `local`, starting a cluster on this machine."""
    with needing("ray", "--ray needs"):
        import ray
    if ray.is_initialized():
        return ray
    # Ray has no option against printing the log of a dead node in the middle of a table
    ray._private.worker.print_to_stdstream = lambda *_, **__: None
    own: dict[str, Any] = {"num_cpus": jobs, "include_dashboard": False} if address == "local" else {}
    host, _, port = address.rpartition(":")
    if not own and not (host and port.isdecimal()):
        raise GrindError(f"{quoted(address)} is no address of a Ray cluster: {HEAD}")
    try:
        if not own:  # Ray itself would try for minutes
            socket.create_connection((host, int(port)), ANSWER_SECONDS).close()
        ray.init(address=address, log_to_driver=False, logging_level="ERROR", **own)
    except (OSError, RuntimeError, ValueError, OverflowError) as error:
        raise GrindError(f"no Ray cluster answers at {quoted(address)} ({reason(error)}): {HEAD}") from None
    atexit.register(ray.shutdown)
    return ray
