"""Turns of the parts: processes try the cases of one part, one by one, until the time of its turn is over."""

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

ROUND = 600.0  #: longest duration of a round, in which every part has one turn, s
START = 600.0  #: duration after which the preparation of a process counts as a hang, s
LOGGED = 20_000  #: number of characters of a process's output that are logged
PREPARED = -1  #: seed in the log if a process dies before its first case
DIES_WITH_PARENT = 1  #: PR_SET_PDEATHSIG
#: start method: the first process imports the package once for all; it calls no compiled code itself
FORK = multiprocessing.get_context("fork")


class Turn:
    """Process that tries every `jobs`th case of a part from `slot` on, until a time of the monotonic clock."""

    def __init__(self, part: Part, log: Log, until: float, slot: int, jobs: int) -> None:
        self.part, self.log, self.until, self.slot, self.jobs = part, log, until, slot, jobs
        self.folder = Path(tempfile.mkdtemp(prefix="soak-"))
        self.output = self.folder / "said.log"
        self.output.touch()
        self.process = FORK.Process(target=self._serve)
        self.process.start()

    def _serve(self) -> None:
        """Try cases; a case that hangs ends the process, with a traceback in its output."""
        os.setsid()  # Ctrl-C is for the parent process
        ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL)
        tempfile.tempdir = str(self.folder)  # removed at the end of the turn
        output = os.open(self.output, os.O_WRONLY | os.O_APPEND)
        for descriptor in (1, 2):
            os.dup2(output, descriptor)
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
            os.ftruncate(output, 0)
            self.log.write(part.name, seed, tried)
            if not first and time.monotonic() > began + 0.25 * (self.until - began):
                first = memory()  # memory grows in the first quarter
        if part.growth is not None and first and memory() - first > part.growth:
            self.log.write(part.name, seed, broken("memory grows", f"{memory() - first:.1f} MB, up to this seed"))

    def end(self) -> None:
        """Kill the process with its children, and remove its files."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid or 0, signal.SIGKILL)  # with its children
        self.process.join()
        for path, _, _ in os.walk(self.folder):  # some are read-only
            Path(path).chmod(0o700)
        shutil.rmtree(self.folder)

    def restarted(self) -> "Turn | None":
        """Log the failure of a process that ended itself; return a new turn for the remaining time, or None."""
        output, code = self.output.read_text("utf-8", "replace")[-LOGGED:], self.process.exitcode
        seed = next(iter(self.log.cut_off(self.part.name, self.slot, self.jobs)), PREPARED)
        kind = "hang" if "Timeout (" in output else f"its process ended with {code}"
        self.log.write(self.part.name, seed, broken(kind, output))
        if seed == PREPARED or time.monotonic() > self.until:
            return None
        return Turn(self.part, self.log, self.until, self.slot, self.jobs)


def run(parts: Sequence[Part], log: Log, seconds: float, jobs: int = 2) -> None:
    """Try cases for `seconds` in parallel processes; interrupted cases come first."""
    rounds, shares = max(1, round(seconds / ROUND)), sum(part.share for part in parts)
    for part in [*parts] * rounds:
        until = time.monotonic() + part.share / shares * seconds / rounds
        turns = [Turn(part, log, until, slot, jobs) for slot in range(jobs)]
        try:
            while turns:
                wait([turn.process.sentinel for turn in turns])
                for turn in [each for each in turns if each.process.exitcode is not None]:
                    turns.remove(turn)
                    if turn.process.exitcode and (another := turn.restarted()):
                        turns.append(another)
                    turn.end()
        finally:
            for turn in turns:
                turn.end()
