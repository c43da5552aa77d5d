"""Policies in a separate process, which receives measurements only.

The policy's code cannot find episodes, seeds or the machine in arguments, frames or objects, because its process does
not hold them. The process reads environment, model and policy, then the calls of the policy, each a line of JSON. It
answers an observation with E and D in double precision.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.dataclass_json import FormError
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.message_text import reason, shortened
from grind_env.policies.choices import Decision
from grind_env.policies.nominal_model import model_of
from grind_env.policies.policy import Sees
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.track import TrackShift

LONGEST = 300  #: largest number of characters that a message quotes from the error of an ended process


@dataclass
class Apart:
    """Policy that runs in another process."""

    name: str
    process: Any
    sees: Sees = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self._answer(["begin", episodes], 0)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        answer = self._answer(["act", observation.tolist()], 16 * len(observation))
        return Decision(*np.frombuffer(answer).reshape(2, -1))

    def learn(self, shift: TrackShift) -> None:
        self._answer(["learn", {name: values.tolist() for name, values in asdict(shift).items()}], 0)

    def _answer(self, told: list[Any], count: int) -> bytes:
        """Send a line of JSON and return the answer of `count` bytes; raise FormError if the process has ended."""
        with suppress(OSError):  # the missing answer is reported below
            self.process.stdin.write(f"{json.dumps(told)}\n".encode())
            self.process.stdin.flush()
        answer: bytes = self.process.stdout.read(count)
        if len(answer) < count:
            said = self.process.stderr.read().decode("utf-8", "replace").strip() or "it says nothing"
            raise FormError(f"its policy has ended ({shortened(said, LONGEST)}): mend it, and submit it again")
        return answer


@contextmanager
def apart(env_id: str, model: str, name: str) -> Iterator[Apart]:
    """Yield the policy of a name in a process that ends with the `with` block; the policy computes with `model`."""
    pipe = subprocess.PIPE
    process = subprocess.Popen([sys.executable, "-m", __name__], stdin=pipe, stdout=pipe, stderr=pipe)
    policy = Apart(name, process)
    try:
        policy._answer([env_id, model, name], 0)
        yield policy
    finally:
        process.kill()
        with suppress(OSError):
            process.communicate()


def answer(answers: Any) -> None:
    """Answer the calls of the policy until standard input ends."""
    asked = sys.stdin.buffer
    env_id, model, name = json.loads(asked.readline())
    problem = find_problem(env_id)
    simulation = model_of(problem, model) if model else problem.simulation()
    policy: Any = named_policy(name, simulation, modules=True)
    for line in asked:
        call, told = json.loads(line)
        if call == "begin":
            episodes = told
            policy.begin(simulation, episodes)
        elif call == "act":
            decided = np.array([*policy.act(np.array(told, np.float32), None)], np.float64)
            if decided.shape != (2, episodes):
                raise FormError(f"E and D are of shape {decided.shape}, but must be of shape {(2, episodes)}")
            answers.write(decided.tobytes())
        elif hasattr(policy, "learn"):
            told["observations"] = np.array(told["observations"], np.float32)
            policy.learn(TrackShift(**{key: np.array(values) for key, values in told.items()}))


if __name__ == "__main__":
    answers, said = (os.fdopen(os.dup(number), "wb", buffering=0) for number in (1, 2))
    for number in (1, 2):  # nobody reads what the policy prints
        os.dup2(os.open(os.devnull, os.O_WRONLY), number)
    try:
        answer(answers)
    except (Exception, SystemExit) as error:  # the policy's code may raise anything
        said.write(f"{type(error).__name__}: {reason(error)}".encode())
