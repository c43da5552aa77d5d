"""Planners that know the true state, which a machine cannot measure.

Their scores are no upper bound for an agent: one planner is a tuned rule; the other looks some blocks ahead and leaves
later blocks to this rule.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.observations import LEAST_SLACK
from grind_env.envs.simulation import Simulation, advance
from grind_env.policies import episode_columns as columns
from grind_env.policies.choices import Decision, all_choices, check_speeds, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.rules import LOADED_AREA, SharpnessRule
from grind_env.policies.scripted.sharpness_estimator import Estimate, thrift


@dataclass(kw_only=True)
class FullStateRule(SharpnessRule):
    """Rule on the true sharpness, (A + 0.02 lam) pm, and the true factors of lot and wheel.

    ln E has the further terms gK ln kA + gR ln(Ra factor), and the dress criterion the further term wK ln kA.
    """

    gK: float
    gR: float
    wK: float
    name: str = "full_state_rule"
    sees: ClassVar[Sees] = "state"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        check_speeds(self.name, self.E, simulation.task)
        self.task, self.simulation = simulation.task, simulation

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        assert episodes is not None
        return self.read(episodes, self.task.blocks - episodes.block)

    def read(self, episodes: Episodes, blocks_left: ArrayLike) -> Decision:
        """Return the decision for episodes with known states and `blocks_left` blocks still to grind."""
        coming = episodes.coming()
        wheels, task = episodes.wheels, self.task
        rows = self.simulation.branches.rows_of(coming)
        nominal = self.simulation.kinds[rows, columns.NOMINAL_STOCK]
        changed = episodes.memory[:, columns.CHANGES] > 0.0
        ln_kA, ln_roughness = (
            np.log(np.where(changed, coming[:, new], coming[:, old])) for old, new in columns.OF_WHEEL
        )
        nothing = np.zeros(len(coming))
        pressed, left = nothing, nothing
        if task.due is not None:
            time = (coming[:, columns.DUE] - episodes.memory[:, columns.CLOCK]) / coming[:, columns.WORK]
            pressed = -np.log(np.maximum(time, LEAST_SLACK))
        if task.wheel_change is not None:
            executions = (wheels[:, columns.DIAMETER] - task.wheel.minimum_diameter) / task.execution_depth
            left = thrift(executions, blocks_left)
        seen = Estimate(
            wear_flat=(wheels[:, columns.AREA] + LOADED_AREA * wheels[:, columns.LOADING])
            * coming[:, columns.PRESSURE],
            volume=wheels[:, columns.VOLUME],
            severity=nothing,
            stock=coming[:, columns.GAUGED] / nominal,
            kind=self.simulation.branches.kind_of_row[rows].astype(np.float64),
            pressed=pressed,
            thrift=left,
        )
        return self.decide(seen, self.gK * ln_kA + self.gR * ln_roughness, self.wK * ln_kA)


@dataclass
class ModelPredictive:
    """Planner that tries every E and D in the coming block, with a rule up to a horizon.

    Args:
        rule: rule for the blocks after the coming block.
        horizon: number of blocks after the coming block, extended to the end of a part and to a due date. Lateness
            carries over from date to date: a horizon that ends with the very next date cost 4 % more in
            Rush. The wheel at the horizon is charged like the wheel at the end of an episode.
        speeds: number of E tried first, geometrically spaced, if the task has a range of E; then `speeds` + 1 from
            neighbour to neighbour of the best E.
    """

    rule: FullStateRule
    horizon: int = 10
    speeds: int = 14
    name: ClassVar[str] = "mpc"
    sees: ClassVar[Sees] = "state"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.rule.begin(simulation, episodes)
        self.simulation, self.block = simulation, 0

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        assert episodes is not None
        task, n = self.simulation.task, len(episodes.block)
        choices = all_choices(task, self.speeds)
        best = self._cheapest(episodes, Decision(*(np.tile(values, (n, 1)) for values in choices)))
        if task.action.speed_levels is None:
            low, high = task.action.speed_ends
            ratio = (high / low) ** (1.0 / (self.speeds - 1))
            between = best.speeds[:, None] * np.geomspace(1.0 / ratio, ratio, self.speeds + 1)
            same = np.repeat(best.executions[:, None], self.speeds + 1, axis=1)
            best = self._cheapest(episodes, Decision(nearest_speed(task, between), same))
        self.block += 1
        return best

    def _cheapest(self, episodes: Episodes, choices: Decision) -> Decision:
        """Return the cheapest of each episode's choices, given as shape (N, choices)."""
        task, (n, count) = self.simulation.task, choices.speeds.shape
        last = self._last_block()
        # the branches end with the horizon, and so the simulation charges the wheel left behind
        here = episodes.window(episodes.tape, np.arange(n), self.block, last + 1 - self.block)
        branches = here.pick(np.repeat(np.arange(n), count))
        cost = self._step(branches, Decision(choices.speeds.ravel(), choices.executions.ravel()))
        for block in range(self.block + 1, last + 1):
            cost += self._step(branches, self.rule.read(branches, task.blocks - block))
        best = cost.reshape(n, count).argmin(axis=1)
        return Decision(choices.speeds[np.arange(n), best], choices.executions[np.arange(n), best])

    def _step(self, branches: Episodes, decision: Decision) -> Array:
        return np.asarray(advance(self.simulation, branches, *decision)[0][:, columns.COST])

    def _last_block(self) -> int:
        task = self.simulation.task
        last = self.block + self.horizon
        if task.due is not None:
            last += task.due.blocks - 1 - last % task.due.blocks
        last = min(last, task.blocks - 1)
        return min(self.simulation.branches.part_from(last)[-1], task.blocks - 1)
