"""A machine of the track: shifts one after the other, and episodes that judge what was learned in them.

What the machine remembers is carried from the end of a shift into the next one. Lots and wheels are new in each.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from agents.track.adapter import TrackShift
from grind_env.arrays import Array
from grind_env.envs.contexts import Given
from grind_env.envs.cost import Outcome
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.plants import Plant, Plants
from grind_env.policies.evaluation import SEEDS, Evaluation, roll_out, steps
from grind_env.policies.model_view import model_of, on
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem

LEARNING, SHIFTS = 100_000, 1_000
"""First of the evaluation seeds of which shifts are, and how many each seed of the track has."""
COST, GOOD, FINISHED, SCRAP, HANDOVER = (
    Outcome._fields.index(name) for name in ("cost", "good", "finished", "scrap_cost", "handover_cost")
)


class Ground(NamedTuple):
    """A shift as it was: what the shop has of it, and what it came to."""

    shift: TrackShift
    cost: float
    """$, with what the wheel costs that is handed over, and scrap at its expected price."""
    scrap: float
    """Expected number of bad parts."""
    parts: float


@dataclass
class TrackMachine:
    """The machine in one run of the track: its name, and the seed of lots, wheels and chances."""

    problem: Problem
    plant: str
    seed: int

    def __post_init__(self) -> None:
        made: Any = on(self.problem, self.plant).simulation()
        self.simulation: Simulation = made
        self.model = model_of(self.problem)
        self.first: Plant = made.plants.first
        self.remembers, self.shifts = self.first.own, 0

    def grind(self, policy: Policy, *, knows: bool = False) -> Ground:
        """The next shift; a policy that `knows` the machine holds it as its model."""
        number = SEEDS["evaluation"] + LEARNING + SHIFTS * self.seed + self.shifts
        episodes, (seen, chosen, came) = self._begun([number]), (list[Any](), list[Any](), list[Any]())
        for step in steps(policy, self.simulation, episodes, None if knows else self.model):
            seen.append(step.observation[0])
            chosen.append([each[0] for each in step.choice[:2]])
            came.append(step.outcomes[0])
        seen.append(self.simulation.observe(episodes)[0])
        self.remembers, self.shifts = episodes.extra_state(0), self.shifts + 1
        outcomes, (speeds, executions) = np.array(came), np.array(chosen).T
        bad, cost = found(outcomes, np.random.default_rng([number, 1]))
        shift = TrackShift(observations=np.array(seen), speeds=speeds, executions=executions, cost=cost, bad=bad)
        good, parts = outcomes[:, [GOOD, FINISHED]].sum(axis=0)
        return Ground(shift, float(outcomes[:, COST].sum()), float(parts - good), float(parts))

    def judge(self, policy: Policy, count: int, *, knows: bool = False) -> Evaluation:
        """Episodes that begin side by side with what the machine remembers now."""
        first = SEEDS["evaluation"] + count * self.seed
        return roll_out(
            policy, self.simulation, self._begun(range(first, first + count)), None if knows else self.model
        )

    def _begun(self, numbers: Sequence[int]) -> Episodes:
        plants = [self.first.after(self.remembers, number) for number in numbers]
        given = [Given(plant=Plants(plant.name, plant)) for plant in plants]
        return self.simulation.start([np.random.default_rng(number) for number in numbers], given)


def found(outcomes: Array, rng: np.random.Generator) -> tuple[Any, Array]:
    """Which parts are found to be bad, and what blocks cost in the books, $; each shape (blocks,)."""
    bad = outcomes[:, FINISHED] * rng.random(len(outcomes)) > outcomes[:, GOOD]
    # the expected price of scrap over its probability is the price of a part
    chance = outcomes[:, FINISHED] - outcomes[:, GOOD]
    price = np.divide(outcomes[:, SCRAP], chance, out=np.zeros(len(chance)), where=chance > 0.0)
    return bad, outcomes[:, COST] - outcomes[:, HANDOVER] - outcomes[:, SCRAP] + bad * price
