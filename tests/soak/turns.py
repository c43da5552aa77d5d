"""Parts take turns: processes of their own try their cases, one after the other, until the time of the turn is over."""

import faulthandler
import multiprocessing
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from tests.soak.counts import Counts
from tests.soak.part import Part, Tried, attempted, broken, memory

ROUND = 600.0
"""s at most in which every part has a turn."""
START = 600.0
"""s after which a process that is being prepared hangs."""
SAVED = 2.0
"""s between two savings of the counts."""
PREPARED = -1
LOG = 20_000
"""Characters that are kept of what a process said."""
FORK = multiprocessing.get_context("fork")
"""What is imported is so once, by the process that begins the others; it calls nothing compiled itself."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A turn: a part, and how long it has, s."""

    part: Part
    seconds: float


def plan(parts: Sequence[Part], seconds: float, jobs: int) -> list[list[Planned]]:
    """The turns of each of the processes that run side by side, which all end after so many s.

    All turns are laid on one line, which is cut where a process has no more time.
    """
    rounds = max(1, round(seconds / ROUND))
    whole, shares = seconds / rounds, sum(part.share for part in parts)
    lines: list[list[Planned]] = [[] for _ in range(jobs)]
    for _ in range(rounds):
        place = 0.0
        for part in parts:
            left = part.share / shares * whole * jobs
            while left > 1e-6 * whole and place < jobs * whole * (1.0 - 1e-9):
                line = min(int(place / whole + 1e-9), jobs - 1)
                piece = min(left, (line + 1) * whole - place)
                lines[line].append(Planned(part, piece))
                place, left = place + piece, left - piece
    return lines


class Turn:
    """A process that tries cases of a part.

    Attributes:
        part: whose cases.
        until: when it is given no more of them, s of the monotonic clock.
        pipe: where seeds go in and what became of them comes out.
        seed: of the case that it tries; `PREPARED` before the first.
    """

    def __init__(self, part: Part, seconds: float) -> None:
        self.part, self.seconds, self.seed = part, seconds, PREPARED
        self.began = time.monotonic()
        self.until = self.began + seconds
        self.memory: list[tuple[float, float]] = []
        self.folder = Path(tempfile.mkdtemp(prefix="soak-"))
        self.log = self.folder / "said.log"
        self.log.touch()
        self.pipe, other = FORK.Pipe()
        self.process: BaseProcess = FORK.Process(target=_serve, args=(part, self.pipe, other, self.log))
        self.process.start()
        other.close()

    def give(self, seed: int) -> None:
        """Have a case tried."""
        self.seed = seed
        self.pipe.send(seed)

    def died(self) -> Tried:
        """What the case has come to whose process has ended with it."""
        self.process.join()
        said = self.log.read_text("utf-8", "replace")[-LOG:]
        hung = "Timeout (" in said
        return broken("hang" if hung else f"its process ended with {self.process.exitcode}", said)

    def grown(self) -> float:
        """MB since the first quarter of the turn."""
        first = next((mb for moment, mb in self.memory if moment > self.began + 0.25 * self.seconds), 0.0)
        return self.memory[-1][1] - first if first else 0.0

    def end(self) -> None:
        """Let the process go."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid or 0, signal.SIGKILL)  # what it has begun goes with it
        self.process.join()
        self.pipe.close()
        for path, _, _ in os.walk(self.folder):  # some may only be read
            Path(path).chmod(0o700)
        shutil.rmtree(self.folder)


def run(
    parts: Sequence[Part],
    counts: Counts,
    seconds: float,
    jobs: int = 2,
    told: Callable[[str, int, Tried], object] = lambda name, seed, tried: None,
) -> None:
    """Try cases for so many seconds; what had been given out before and not ended is tried first.

    Args:
        parts: that take turns.
        counts: are added to, and saved.
        seconds: after which nothing is begun any more.
        jobs: processes side by side.
        told: is given the part, the seed and the end of each case.
    """
    again = {part.name: list(counts.of(part.name).open) for part in parts}
    lines, turns, saved = plan(parts, seconds, jobs), dict[Connection, tuple[Turn, list[Planned]]](), time.monotonic()
    try:
        for line in lines:
            _begin_next(line, turns)
        while turns:
            for pipe in wait(list(turns)):
                assert isinstance(pipe, Connection)
                _hear(pipe, turns, counts, again, told)
            if time.monotonic() > saved + SAVED:
                counts.save()
                saved = time.monotonic()
    finally:
        counts.save()
        for turn, _ in turns.values():
            turn.end()


def _hear(
    pipe: Connection,
    turns: dict[Connection, tuple[Turn, list[Planned]]],
    counts: Counts,
    again: Mapping[str, list[int]],
    told: Callable[[str, int, Tried], object],
) -> None:
    """Take what a process says, and give it the next case, or its place to the next turn."""
    turn, line = turns[pipe]
    count = counts.of(turn.part.name)
    try:
        tried, mb = pipe.recv()
        alive = True
    except EOFError:
        tried, mb, alive = turn.died(), 0.0, False
    if tried is not None:
        count.add(turn.seed, tried)
        told(turn.part.name, turn.seed, tried)
    if alive:
        turn.memory.append((time.monotonic(), mb))
        if time.monotonic() < turn.until or tried is None:
            turn.give(again[turn.part.name].pop(0) if again[turn.part.name] else count.take())
            return
        if (judged := _judged(turn)) is not None:
            count.add(turn.seed, judged)
            told(turn.part.name, turn.seed, judged)
    count.seconds += time.monotonic() - turn.began
    del turns[pipe]
    turn.end()
    left = turn.until - time.monotonic()
    if not alive and left > 0.0 and turn.seed != PREPARED:
        line.insert(0, Planned(turn.part, left))
    _begin_next(line, turns)


def _judged(turn: Turn) -> Tried | None:
    """What the memory of a process says at its end."""
    grown = turn.grown()
    if turn.part.growth is not None and grown > turn.part.growth:
        return broken("memory grows", f"{grown:.1f} MB in {turn.seconds:.0f} s, up to this seed")
    return None


def _begin_next(line: list[Planned], turns: dict[Connection, tuple[Turn, list[Planned]]]) -> None:
    if line:
        planned = line.pop(0)
        turn = Turn(planned.part, planned.seconds)
        turns[turn.pipe] = turn, line


def _serve(part: Part, theirs: Connection, pipe: Connection, log: Path) -> None:
    """Try the cases that come in until no more do; a case that hangs ends the process, and the log says where."""
    os.setsid()  # Ctrl-C is for who began it
    theirs.close()
    tempfile.tempdir = str(log.parent)  # what it leaves there is removed with it
    said = os.open(log, os.O_WRONLY | os.O_APPEND)
    for descriptor in (1, 2):
        os.dup2(said, descriptor)
    faulthandler.enable(file=2)
    faulthandler.dump_traceback_later(START, exit=True, file=2)
    part.prepare()
    pipe.send((None, memory()))
    while True:
        try:
            seed = pipe.recv()
        except EOFError:
            return
        faulthandler.dump_traceback_later(part.seconds, exit=True, file=2)
        tried = attempted(part, seed)
        faulthandler.cancel_dump_traceback_later()
        os.ftruncate(said, 0)
        pipe.send((tried, memory()))
