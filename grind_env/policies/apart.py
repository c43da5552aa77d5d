"""A policy in a process of its own, which receives measurements only.

Whatever its code looks for, in its arguments, in frames or among all objects: episodes, seeds and the machine that
grinds are not there. The process is told environment, model, policy and number of episodes, and then sent observations
in single precision, which it answers with E and D in double precision.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import reason, shortened
from grind_env.json_form import FormError
from grind_env.policies.choices import Decision
from grind_env.policies.model_view import model_of
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Sees
from grind_env.policies.problem import find_problem

LONGEST = 300
"""Characters that are quoted of what such a process says in the end."""


@dataclass
class Apart:
    """A policy in another process, for whoever runs one."""

    env_id: str
    model: str
    name: str
    process: Any
    sees: Sees = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        told = json.dumps([self.env_id, self.model, self.name, episodes])
        self._answer(f"{told}\n".encode(), 0)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        answer = self._answer(np.ascontiguousarray(observation, np.float32).tobytes(), 16 * len(observation))
        return Decision(*np.frombuffer(answer).reshape(2, -1))

    def _answer(self, data: bytes, count: int) -> bytes:
        """Send data, and wait for so many bytes; a FormError if the process has ended."""
        with suppress(OSError):  # then there is no answer, either
            self.process.stdin.write(data)
            self.process.stdin.flush()
        answer: bytes = self.process.stdout.read(count)
        if len(answer) < count:
            said = self.process.stderr.read().decode("utf-8", "replace").strip() or "it says nothing"
            raise FormError(f"its policy has ended ({shortened(said, LONGEST)}): mend it, and submit it again")
        return answer


@contextmanager
def apart(env_id: str, model: str, name: str) -> Iterator[Apart]:
    """Yield a policy by its name for an environment, in a process that ends with the block; it holds a `model`."""
    pipe = subprocess.PIPE
    process = subprocess.Popen([sys.executable, "-m", __name__], stdin=pipe, stdout=pipe, stderr=pipe)
    try:
        yield Apart(env_id, model, name, process)
    finally:
        process.kill()
        with suppress(OSError):
            process.communicate()


def answer(answers: Any) -> None:
    """Decide until nothing more is measured."""
    asked = sys.stdin.buffer
    env_id, model, name, episodes = json.loads(asked.readline())
    problem = find_problem(env_id)
    simulation = model_of(problem, model) if model else problem.simulation()
    policy = named_policy(name, simulation, modules=True)
    policy.begin(simulation, episodes)
    shape = episodes, len(simulation.entries)
    while data := asked.read(4 * episodes * shape[1]):
        decided = np.array([*policy.act(np.frombuffer(data, np.float32).reshape(shape).copy(), None)], np.float64)
        if decided.shape != (2, episodes):
            raise FormError(f"E and D are of shape {decided.shape}, but must be of shape {(2, episodes)}")
        answers.write(decided.tobytes())


if __name__ == "__main__":
    answers, said = (os.fdopen(os.dup(number), "wb", buffering=0) for number in (1, 2))
    for number in (1, 2):  # nobody reads what the policy prints
        os.dup2(os.open(os.devnull, os.O_WRONLY), number)
    try:
        answer(answers)
    except (Exception, SystemExit) as error:  # whatever the code of another does
        said.write(f"{type(error).__name__}: {reason(error)}".encode())
