"""Batches, sessions and rows shared by the tests of the adviser."""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.examples import FOLDER
from grind_env.policies.learned.agent_spaces import LearnerForm
from grind_env.policies.learned.network import Actor
from grind_env.policies.learned.saved import write_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.operator_readings import check_readings, readings_of
from grind_env.shop.advise.reading_sources import CsvSource, ReadingsRow
from grind_env.shop.advise.session import Files, Session
from grind_env.shop.advise.state import origin_of
from tests.policies.harness import network_of

PLATE, RAIL = FOLDER / "plate_g82.nc", FOLDER / "rail_g83.nc"
EXECUTED = """G71 G94 G90 G19 S1910 M03 M08
G00 X-30. Y0 Z0
G82 X230. I-30. Y-.03 J-.01 F1. E12000. P9100
G80
G00 Y20.
M30
"""
INCHES = """G70 G94 G90 G19 S1910 M03 M08
G00 Y.1 Z-.1
G00 X-1.2
G01 Y0 F20.
G82 X9. I-1.2 Y-.006 J-.0004 F2.4 E500. P9100 D1
G80
G00 Y1. M09 M05
M30
"""
DRESS = PLATE.read_text()[PLATE.read_text().index("O9100") :].rstrip("%\n")
SEED = 12


def batch(program: Path, parts: int) -> Problem:
    return find_problem(str(program), None, parts)


def saved_agent(path: Path, problem: Problem, **description: Any) -> Path:
    """Save a small agent with random weights as `python -m agents train` does and return its path."""
    simulation, form, rng = problem.simulation(), LearnerForm("belief"), np.random.default_rng(17)
    network = network_of(simulation, form, hidden=(8,))
    tensors = {name: rng.normal(0.0, 0.7, shape).astype(np.float32) for name, shape in network.shapes().items()}
    write_policy(path, Actor(network, tensors), simulation, "ppo", form, description)
    return path


def rollout(problem: Problem, policy: Policy, seed: int) -> Iterator[tuple[np.ndarray, float, int]]:
    """Yield each observation of an episode with the E and D that the policy chooses."""
    env: Any = problem.make().unwrapped
    policy.begin(env.simulation, 1)
    observation, _ = env.reset(seed=seed)
    over = False
    while not over:
        decision = policy.act(observation[None], None)
        after, _, over, _, info = env.step(env.codec.encode(*decision)[0])
        yield observation, info["E"], info["D"]
        observation = after


class Rows:
    """Source of given rows that raises KeyboardInterrupt after the last one."""

    repeats_rows, accepts_corrections = False, False

    def __init__(self, rows: list[dict[str, Any]]) -> None:
        self.rows = rows

    def next(self, asked: str) -> ReadingsRow:
        if not self.rows:
            raise KeyboardInterrupt
        return ReadingsRow(self.rows.pop(0), "here")


def session_of(folder: Path, rows: list[dict[str, Any]], said: list[str], **arguments: Any) -> Session:
    simulation: Any = batch(PLATE, 4).simulation()
    policy = policy_for(None, simulation)
    files = Files(state=folder / "state.json", log=folder / "state.csv", values=folder / "values.nc")
    origin = origin_of(simulation, policy, None)
    return Session(
        adviser=Adviser(simulation, policy), origin=origin, files=files, source=Rows(rows), say=said.append, **arguments
    )


ROWS: list[dict[str, Any]] = [
    {"mean_power": 3500.0, "peak_power": 3700.0},
    {"mean_power": 2100.0, "size_error": 2.0, "Ra": 0.4},
    {"mean_power": 5200.0, "E": 20_000.0},
    {"size_error": 4.0, "new_lot": 1},
    {"mean_power": 6100.0},
    {},
    {"mean_power": 4100.0, "D": 1},
    {"size_error": 1.0},
]


def advised(said: list[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in said if line.startswith("{")]


def session_steps(folder: Path) -> list[Any]:
    path = folder / "state.json"
    return [step["readings"] for step in json.loads(path.read_text())["steps"]] if path.exists() else []


def plate_in(folder: Path) -> Path:
    """Copy the plate program and its job into a folder and return the program's path."""
    for path in (PLATE, PLATE.with_suffix(".toml")):
        (folder / path.name).write_bytes(path.read_bytes())
    return folder / PLATE.name


def rows_of(path: Path, text: str, *, follow: bool = False) -> list[dict[str, Any]]:
    def stop(seconds: float) -> None:
        raise TimeoutError

    path.write_text(text)
    source, rows = CsvSource(path, follow=follow, wait=stop), []
    try:
        while (row := source.next("")) is not None:
            rows.append(readings_of(row.table, row.place).given())
    except TimeoutError:
        pass
    return rows


def adviser_after(rows: Iterable[dict[str, Any]], **arguments: Any) -> tuple[Adviser, list[tuple[float, int]]]:
    """Return an adviser of plates after these rows of blocks, and the E and D it advised for each."""
    simulation: Any = batch(PLATE, 6).simulation()
    adviser = Adviser(simulation, policy_for(None, simulation, arguments.pop("step", 1.25)), **arguments)
    advice = []
    for number, row in enumerate(rows):
        assert adviser.advice is not None
        advice.append((adviser.advice.speed, adviser.advice.executions))
        readings = readings_of(row, "here")
        check_readings(readings, simulation, number, "here")
        adviser.take(readings)
    return adviser, advice
