"""A policy in a process of its own, to which nothing comes but what is measured.

Whatever its code looks for, in its arguments, in frames or among all objects: episodes, seeds and the machine that
grinds are not there. The process is sent the row and the number of episodes, and then observations in single precision,
which it answers with E and D in double precision; it makes a simulation of its own for what the policy holds.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError, reason, shortened
from grind_env.policies.choices import Decision
from grind_env.policies.held import model_of
from grind_env.policies.policy import Sees
from grind_env.policies.rows.form import RowError
from grind_env.policies.rows.making import policy_of, unpacked
from grind_env.policies.rows.row import Row

LAST, LONGEST = 4000, 300
"""Bytes of the end of what such a process says, and characters of its last line that are quoted."""


@dataclass
class Apart:
    """The policy of a row, for whoever runs one."""

    row: Row
    modules: Sequence[str]
    process: Any
    said: IO[bytes]
    name: str
    sees: Sees = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Send the row, and how many episodes begin."""
        self._send(pickle.dumps((replace(self.row, plant=""), self.modules, episodes)))

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Send what was measured, and wait for E and D; a RowError if the process has ended."""
        self._send(np.ascontiguousarray(observation, np.float32).tobytes())
        answer = self.process.stdout.read(16 * len(observation))
        if len(answer) < 16 * len(observation):
            raise self._ended()
        return Decision(*np.frombuffer(answer).reshape(2, -1))

    def _send(self, data: bytes) -> None:
        try:
            self.process.stdin.write(data)
            self.process.stdin.flush()
        except OSError:
            raise self._ended() from None

    def _ended(self) -> RowError:
        self.process.wait()
        self.said.seek(max(0, self.said.seek(0, os.SEEK_END) - LAST))
        lines = self.said.read().decode("utf-8", "replace").split("\n")
        last = next((each for each in reversed(lines) if each.strip()), "it says nothing")
        return RowError(f"its policy has ended ({shortened(last, LONGEST)}): mend it, and submit it again")


@contextmanager
def apart(row: Row, modules: Sequence[str]) -> Iterator[Apart]:
    """The policy of a row, with modules that it may import, in a process that ends with the block."""
    command = [sys.executable, "-m", __name__]
    with TemporaryFile() as said:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said)
        try:
            yield Apart(row, modules, process, said, row.policy)
        finally:
            process.kill()
            with suppress(OSError):
                process.communicate()


def answer() -> None:
    """Decide until nothing more is measured; what the policy prints goes to standard error."""
    asked, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    row, modules, episodes = pickle.load(asked)  # from the process that has begun this one
    with unpacked(row, modules) as (problem, folder):
        simulation = model_of(problem, row.model) if row.model else problem.simulation()
        policy = policy_of(row, simulation, folder)
        policy.begin(simulation, episodes)
        shape = episodes, len(simulation.entries)
        while data := asked.read(4 * episodes * shape[1]):
            decided = np.array([*policy.act(np.frombuffer(data, np.float32).reshape(shape).copy(), None)], np.float64)
            if decided.shape != (2, episodes):
                raise RowError(f"E and D are of shape {decided.shape}, but must be of shape {(2, episodes)}")
            answers.write(decided.tobytes())


if __name__ == "__main__":
    try:
        answer()
    except GrindError as error:
        sys.exit(f"\n{error}")
    except Exception as error:  # whatever the code of another does
        sys.exit(f"\n{type(error).__name__}: {reason(error)}")
