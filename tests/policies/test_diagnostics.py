"""Each diagnostic task tests one skill: a policy with this skill beats a policy without it on the same episodes.

The constants of each policy are the best of a grid on 128 training episodes; the tests use evaluation episodes.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grind_env.envs.cost import Outcome
from grind_env.envs.noise_tape import TapeRow
from grind_env.policies.choices import Decision, all_choices, nearest_speed
from grind_env.policies.evaluation import Evaluation, episode_seeds, run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.score_statistics import Interval
from tests.envs.harness import Array

EPISODES = 512
DIE = 18  #: block of the first of the last two dies
HANDOVER, COST = Outcome._fields.index("handover_cost"), Outcome._fields.index("cost")
FALLS = np.array([1.0, 0.97, 0.94])  #: factors on E from block to block
ROUGHNESS = TapeRow._fields.index("ra_scale")


def judged(policy: Any, task: str, episodes: int = EPISODES) -> Evaluation:
    return run_seeds(policy, find_problem(task).simulation(), episode_seeds("evaluation", episodes))


def mean(cost: Array) -> Interval:
    """Return the mean and its 95 % interval."""
    half = 1.96 * cost.std() / np.sqrt(len(cost))
    return Interval(float(cost.mean()), float(cost.mean() - half), float(cost.mean() + half))


@dataclass
class Dies:
    """Policy that sets E and dress of dies by the roughness of the first die, remembered or as shown."""

    E: float
    exponent: float
    dressed_from: float
    remembers: bool
    name: str = "dies"
    sees: str = "measurements"
    rough: Array = field(init=False, repr=False)

    def begin(self, simulation: Any, episodes: int) -> None:
        self.simulation, self.rough, self.block = simulation, np.zeros(episodes), 0

    def act(self, observation: Array, episodes: Any) -> Decision:
        shown = self.simulation.read(observation)["roughness"]
        self.rough = np.where(shown > 0.0, shown, self.rough) if self.remembers else shown
        rough = np.where(self.rough > 0.0, self.rough / 0.525, 1.0)  # 0.21 um of 0.40 is usual
        die = self.block in (0, DIE, DIE + 1)
        self.block += 1
        speeds = self.E * np.maximum(rough, 0.1) ** -self.exponent if die else np.full(len(rough), 30.0)
        dresses = (die & (rough > self.dressed_from)).astype(float)
        return Decision(nearest_speed(self.simulation.task, 1000.0 * np.clip(speeds, 3.0, 30.0)), dresses)


@dataclass
class Guides:
    """Policy that sets E by the wheel roughness, from all readings or the latest, shrunk to the usual one."""

    E: float
    exponent: float
    averages: bool
    name: str = "guides"
    sees: str = "measurements"

    def begin(self, simulation: Any, episodes: int) -> None:
        self.simulation, self.total, self.count, self.speeds = simulation, np.zeros(episodes), 0, list[Array]()

    def act(self, observation: Array, episodes: Any) -> Decision:
        seen, task, block = self.simulation.read(observation), self.simulation.task, len(self.speeds)
        if block >= 2 and block % 3 == 2:
            # the reading of a usual wheel, which leaves 0.225 um at 12 m/min
            usual = 0.225 / 0.36 * (self.speeds[-2] / 12.0) ** 0.108
            rough = np.log(np.maximum(seen["roughness"], 0.05) / usual)
            self.total = self.total + rough if self.averages else rough
            self.count = self.count + 1 if self.averages else 1
        wheels, reading = task.spread.wheel_roughness**2, (0.06 * task.spread.measurement) ** 2
        believed = self.total * wheels / (self.count * wheels + reading)
        speeds = np.clip(self.E * np.exp(-self.exponent * believed), 3.0, 30.0)
        self.speeds.append(speeds)
        return Decision(nearest_speed(task, 1000.0 * speeds), np.zeros(len(speeds)))


@dataclass
class Ahead:
    """Policy that takes the cheapest choice over a horizon in which E stays or falls."""

    horizon: int
    name: str = "ahead"
    sees: str = "future"

    def begin(self, simulation: Any, episodes: int) -> None:
        self.simulation, self.block = simulation, 0

    def act(self, observation: Array, episodes: Any) -> Decision:
        simulation, n = self.simulation, len(episodes.block)
        choices = Decision(*(np.repeat(values, len(FALLS)) for values in all_choices(simulation.task, 14)))
        branches = episodes.pick(np.repeat(np.arange(n), len(choices.speeds)))
        speeds, executions = (np.tile(values, n) for values in choices)
        falls, cost = np.tile(FALLS, len(speeds) // len(FALLS)), np.zeros(len(speeds))
        for _ in range(min(self.horizon, simulation.task.blocks - self.block)):
            outcome = simulation.step(branches, speeds, executions)[0]
            # without the price of the wheel at handover, which tells the last block about later ones
            cost += outcome[:, COST] - outcome[:, HANDOVER]
            speeds, executions = np.maximum(falls * speeds, 3000.0), np.zeros(len(speeds))
        self.block += 1
        best = cost.reshape(n, -1).argmin(axis=1)
        return Decision(choices.speeds[best], choices.executions[best])


def test_memory_of_the_first_die_pays_at_the_last_ones() -> None:
    remembered, shown = judged(Dies(8.0, 4.0, 1.2, True), "memory"), judged(Dies(6.0, 0.0, 0.5, False), "memory")
    with_it, without = mean(remembered.cost), mean(shown.cost)
    assert with_it.high < 0.85 * without.low
    # from the second block up to the last dies both choose the same E
    np.testing.assert_array_equal(remembered.speeds[:, 1:DIE], shown.speeds[:, 1:DIE])


def test_the_memory_task_shows_the_roughness_early_and_never_again() -> None:
    simulation = find_problem("memory").simulation()
    episodes = simulation.start([np.random.default_rng(seed) for seed in range(300)])
    factors, readings = episodes.tape[:, 0, ROUGHNESS].copy(), []
    while not simulation.over(episodes).all():
        readings.append(simulation.read(simulation.observe(episodes))["roughness"])
        simulation.step(episodes, np.full(300, 12_000.0), np.zeros(300))
    shown = np.array(readings)
    assert [k for k in range(20) if shown[k].any()] == [2, 3, 4]
    assert np.corrcoef(np.log(shown[2]), np.log(factors))[0, 1] > 0.97


def test_averaging_noisy_readings_beats_the_latest_reading() -> None:
    averaged, latest = judged(Guides(13.0, 2.5, True), "noise"), judged(Guides(13.0, 2.5, False), "noise")
    gain = mean(latest.cost - averaged.cost)  # of the same episodes
    assert gain.low > 0.05 * latest.cost.mean()


def test_a_dress_pays_only_over_a_longer_horizon() -> None:
    runs = {horizon: judged(Ahead(horizon), "credit", 32) for horizon in (1, 2, 6)}
    costs = {horizon: mean(each.cost) for horizon, each in runs.items()}
    assert costs[6].high < 0.95 * costs[2].low and costs[2].high < 0.2 * costs[1].low
    # within one block a dress hardly ever pays
    assert runs[1].dresses < 0.02 and runs[6].dresses > 0.08
