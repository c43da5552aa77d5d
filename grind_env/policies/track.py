"""The track: a policy grinds ten shifts on one machine, and may learn from the log of each shift.

The machine's memory at the end of a shift carries over into the next shift. Lots and wheels are new in each shift.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.cost import Outcome
from grind_env.envs.reset_options import Given
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.kernel.random import WORD
from grind_env.plants import Plant, Plants
from grind_env.policies.evaluation import COST, FINISHED, GOOD, SEEDS, Step, steps
from grind_env.policies.nominal_model import model_of, on
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scoring import check_policy

TASK, SHIFTS, BASELINE = "power_limited", 10, "robust"
#: machines of the track: half differ by families of deviations, half by other laws of grinding
MACHINES = tuple(f"{name}:{number}" for name in ("held-out", "held-out-laws") for number in range(1, 11))
SCRAP, HANDOVER = Outcome._fields.index("scrap_cost"), Outcome._fields.index("handover_cost")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackShift:
    """Log of a shift on a machine, with the values that a shop can record."""

    # measurements before every block and after the last block, shape (blocks + 1, entries)
    observations: NDArray[np.float32]
    speeds: Array  #: E of every block, mm/min, shape (blocks,)
    executions: Array  #: D of every block, shape (blocks,)
    # cost of every block, $: time, wheel, dresses, late orders, wheel changes, and the price of a part found to be bad;
    # without the cost of handing over a dull wheel, because nobody measures this cost
    cost: Array
    bad: NDArray[np.bool_]  #: whether the part that the block finished was found to be bad


class Learner(Policy, Protocol):
    """Policy that learns on a machine; every run makes a new object.

    `begin` is called before every shift, with the simulation of the model. The policy may keep what it has learned.
    """

    def learn(self, shift: TrackShift) -> None:
        """Learn from the log of the shift that has ended."""


class TrackRuns(NamedTuple):
    """Costs and parts of runs on a machine, arrays of shape (runs, shifts)."""

    cost: Array  #: cost per block, $, with scrap at its expected price
    scrap: Array  #: expected number of bad parts
    parts: Array  #: number of finished parts


class TrackMachine:
    """Machine in parallel runs, one run for each seed of lots, wheels and random events.

    Args:
        plant: name of the machine.
        seeds: seeds of the runs. With equal seeds, all policies grind the same lots.
    """

    def __init__(self, plant: str, seeds: Sequence[int]) -> None:
        problem = find_problem(TASK)
        made: Any = on(problem, plant).simulation()
        self.simulation: Simulation = made
        self.model = model_of(problem)
        self.first: Plant = made.plants.first
        self.seeds, self.shift = seeds, 0
        self.remembers = [self.first.own for _ in seeds]

    def grind(self, policy: Policy, *, knows: bool = False) -> tuple[list[TrackShift], TrackRuns]:
        """Return the log of the next shift of every run, with costs and parts.

        A policy that `knows` the machine begins with the machine's simulation in place of the model.
        """
        place = SEEDS["evaluation"], crc32(self.first.name.encode()), self.shift
        lots, events = ([np.random.default_rng([*place, seed, k]) for seed in self.seeds] for k in range(2))
        plants = [
            self.first.after(own, int(rng.integers(WORD))) for own, rng in zip(self.remembers, events, strict=True)
        ]
        given = [Given(plant=Plants(plant.name, plant)) for plant in plants]
        episodes = self.simulation.start(lots, given)
        ground: list[Step] = list(steps(policy, self.simulation, episodes, None if knows else self.model))
        last = self.simulation.observe(episodes)
        self.remembers = [episodes.extra_state(run) for run in range(len(self.seeds))]
        self.shift += 1
        outcomes = np.stack([step.outcomes for step in ground], axis=1)
        shifts = []
        for run, rng in enumerate(events):
            bad, cost = books(outcomes[run], rng)
            seen = np.array([*(step.observation[run] for step in ground), last[run]])
            speeds, executions = np.array([[each[run] for each in step.choice[:2]] for step in ground]).T
            shifts.append(TrackShift(observations=seen, speeds=speeds, executions=executions, cost=cost, bad=bad))
        cost, good, parts = outcomes[..., [COST, GOOD, FINISHED]].sum(axis=1).T[..., None]
        return shifts, TrackRuns(cost=cost / len(ground), scrap=parts - good, parts=parts)


def books(outcomes: Array, rng: np.random.Generator) -> tuple[NDArray[np.bool_], Array]:
    """Return which parts are found to be bad, and the recorded cost of the blocks, $; each shape (blocks,)."""
    bad = outcomes[:, FINISHED] * rng.random(len(outcomes)) > outcomes[:, GOOD]
    # the expected price of scrap over its probability is the price of a part
    chance = outcomes[:, FINISHED] - outcomes[:, GOOD]
    price = np.divide(outcomes[:, SCRAP], chance, out=np.zeros(len(chance)), where=chance > 0.0)
    return bad, outcomes[:, COST] - outcomes[:, HANDOVER] - outcomes[:, SCRAP] + bad * price


def run_shifts(policy: Policy, plant: str, seeds: Sequence[int], *, knows: bool = False) -> TrackRuns:
    """Return costs and parts of a policy in ten shifts on a machine, in parallel runs.

    Args:
        policy: new policy, without memory of other machines. A policy with a method `learn` gets the log after every
            shift, and has one run.
        plant: name of the machine.
        seeds: seeds of the runs.
        knows: whether the policy may compute with the simulation of the machine and see its state.

    Raises:
        GrindError: `policy` is no policy, or sees more than measurements.
    """
    check_policy(policy)
    if policy.sees != "measurements" and not knows:
        raise GrindError(f"{policy.name} sees the {policy.sees}, but on the track there are measurements alone")
    machine, learn = TrackMachine(plant, seeds), getattr(policy, "learn", None)
    assert learn is None or len(seeds) == 1
    done = []
    for _ in range(SHIFTS):
        shifts, came = machine.grind(policy, knows=knows)
        done.append(came)
        if learn is not None:
            learn(shifts[0])
    return TrackRuns(*(np.hstack(each) for each in zip(*done, strict=True)))
