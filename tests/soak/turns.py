"""Parts take turns: processes of their own try their cases, one after the other, until the time of the turn is over."""

import ctypes
import faulthandler
import multiprocessing
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import wait
from pathlib import Path

from tests.soak.log import Log
from tests.soak.part import Part, attempted, broken, memory

ROUND = 600.0
"""s at most in which every part has a turn."""
START = 600.0
"""s after which a process that is being prepared hangs."""
SAID = 20_000
"""Characters that are kept of what a process said."""
PREPARED = -1
"""Stands for the seed where a process has died before its first case."""
DIES_WITH_PARENT = 1
"""PR_SET_PDEATHSIG."""
FORK = multiprocessing.get_context("fork")
"""What is imported is so once, by the process that begins the others; it calls nothing compiled itself."""


class Turn:
    """A process that tries every `jobs`th case of a part from `slot` on, until a moment of the monotonic clock."""

    def __init__(self, part: Part, log: Log, until: float, slot: int, jobs: int) -> None:
        self.part, self.log, self.until, self.slot, self.jobs = part, log, until, slot, jobs
        self.folder = Path(tempfile.mkdtemp(prefix="soak-"))
        self.said = self.folder / "said.log"
        self.said.touch()
        self.process = FORK.Process(target=self._serve)
        self.process.start()

    def _serve(self) -> None:
        """Try cases; one that hangs ends the process, and what it has said tells where."""
        os.setsid()  # Ctrl-C is for who began it
        ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL)
        tempfile.tempdir = str(self.folder)  # what it leaves there is removed with it
        said = os.open(self.said, os.O_WRONLY | os.O_APPEND)
        for descriptor in (1, 2):
            os.dup2(said, descriptor)
        faulthandler.enable(file=2)
        faulthandler.dump_traceback_later(START, exit=True, file=2)
        part, began, first = self.part, time.monotonic(), 0.0
        part.prepare()
        for seed in self.log.seeds(part.name, self.slot, self.jobs):
            if time.monotonic() > self.until:
                break
            self.log.write(part.name, seed)
            faulthandler.dump_traceback_later(part.seconds, exit=True, file=2)
            tried = attempted(part, seed)
            faulthandler.cancel_dump_traceback_later()
            os.ftruncate(said, 0)
            self.log.write(part.name, seed, tried)
            if not first and time.monotonic() > began + 0.25 * (self.until - began):
                first = memory()  # in the first quarter everything is new
        if part.growth is not None and first and memory() - first > part.growth:
            self.log.write(part.name, seed, broken("memory grows", f"{memory() - first:.1f} MB, up to this seed"))

    def end(self) -> None:
        """Let the process go; the case has fallen by which it has ended itself."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid or 0, signal.SIGKILL)  # what it has begun goes with it
        self.process.join()
        for path, _, _ in os.walk(self.folder):  # some may only be read
            Path(path).chmod(0o700)
        shutil.rmtree(self.folder)

    def followed(self) -> "Turn | None":
        """Note how the case of a process that has ended itself has fallen; return another for the rest of the time."""
        said, code = self.said.read_text("utf-8", "replace")[-SAID:], self.process.exitcode
        seed = next(iter(self.log.cut_off(self.part.name, self.slot, self.jobs)), PREPARED)
        kind = "hang" if "Timeout (" in said else f"its process ended with {code}"
        self.log.write(self.part.name, seed, broken(kind, said))
        if seed == PREPARED or time.monotonic() > self.until:
            return None
        return Turn(self.part, self.log, self.until, self.slot, self.jobs)


def run(parts: Sequence[Part], log: Log, seconds: float, jobs: int = 2) -> None:
    """Try cases for so many seconds in processes side by side; those that were cut off before are tried first."""
    rounds, shares = max(1, round(seconds / ROUND)), sum(part.share for part in parts)
    for part in [*parts] * rounds:
        until = time.monotonic() + part.share / shares * seconds / rounds
        turns = [Turn(part, log, until, slot, jobs) for slot in range(jobs)]
        try:
            while turns:
                wait([turn.process.sentinel for turn in turns])
                for turn in [each for each in turns if each.process.exitcode is not None]:
                    turns.remove(turn)
                    if turn.process.exitcode and (another := turn.followed()):
                        turns.append(another)
                    turn.end()
        finally:
            for turn in turns:
                turn.end()
