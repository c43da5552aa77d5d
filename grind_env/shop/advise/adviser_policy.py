"""The default adviser: a rule on readings, replaced by the model while the model's forecasts hold."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episode_state import Episodes
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.mismatch_alarms import Watch
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.scripted.learned_laws import PowerLaw
from grind_env.shop.advise.model_free_rule import STEP, BlockReadings, Rule

#: blocks in a row whose forecasts must hold before the model leads, and the factor on this number after a failure
PROVED, LONGER = 6, 2


@dataclass
class AdviserPolicy:
    """Adviser for N machines side by side.

    The rule leads from the first block on. The model leads after its forecasts of power, size and Ra have held, and
    loses the lead when they fail. While the model leads, it decides when to dress, and the rule still decides E.
    """

    model: Policy | None  #: policy that uses the model; None for a program that only the control can execute
    step: float = STEP  #: greatest factor on E from block to block of a kind
    residual: float = 0.0  #: logarithmic standard deviation of forces that the model does not follow
    # readings of the last block, one for each machine; from the observation if None
    readings: list[BlockReadings] | None = field(init=False, default=None)
    rules: list[Rule] = field(init=False, repr=False)  #: one for each machine
    watch: Watch | None = field(init=False, repr=False)  #: compares readings with forecasts; None without a model
    leads: NDArray[np.bool_] = field(init=False, repr=False)  #: where the model leads, shape (N,)
    name: ClassVar[str] = "adviser"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        assert isinstance(simulation, JobSimulation)
        self.simulation, self.number = simulation, -1
        self.rules = [Rule(simulation, self.step) for _ in range(episodes)]
        self.watch = None if self.model is None else Watch(simulation, episodes, self.residual)
        if self.model is not None:
            self.model.begin(simulation, episodes)
        self.first: NDArray[np.float32] | None = None
        self.unused = PowerLaw(episodes)
        self.leads, self.needed_blocks = np.zeros(episodes, bool), np.full(episodes, float(PROVED))
        self.held_blocks, self.last_size, self.last_Ra = np.zeros((3, episodes))

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Learn from the last block, then decide on the coming one."""
        number, self.number = self.number, self.number + 1
        seen = self.simulation.read(observation)
        forecast = self._forecast(observation)
        burn = np.zeros(len(self.rules)) if self.watch is None else self.watch.burn_per_watt
        choices = []
        for n, rule in enumerate(self.rules):
            of_n = {name: float(values[n]) for name, values in seen.items()}
            if number >= 0:
                made = JobChoice(of_n["last_speed"], round(of_n.get("last_executions", 0.0)))
                readings = self._observed(number, n, of_n) if self.readings is None else self.readings[n]
                rule.learn(number, made, readings, of_n["volume"], float(burn[n]))
            choices.append(rule.decide(self.number, of_n["volume"]))
        self.readings = None
        speeds, executions = np.array(choices).T
        if forecast is None:
            return Decision(speeds, executions)
        for n in np.flatnonzero(self.leads).tolist():
            rule, D = self.rules[n], float(forecast.executions[n])
            D = max(D, executions[n] if rule.wanted or rule.slows else 0.0)
            volume = float(seen["volume"][n]) + rule.ground(self.number) / (D + 1.0)
            bound, why = rule.fastest(self.number, volume)
            speeds[n], executions[n] = bound, D
            rule.reason = "dress: it pays, by the model" if D else why
        return Decision(nearest_speed(self.simulation.task, speeds), executions)

    def compare(self, observation: NDArray[np.float32]) -> None:
        """Compare the readings of the last block with the forecast."""
        if self.watch is not None:
            self.watch.update(observation, self.unused)

    def _forecast(self, observation: NDArray[np.float32]) -> Decision | None:
        """Update the model and return its decision; None without a model or before the first readings."""
        self.compare(observation)
        if self.watch is None or self.model is None:
            return None
        if self.first is None:
            self.first = observation.copy()  # the first advice does not wait for the model, which does not lead yet
            return None
        if self.number == 1:
            self.model.act(self.first, None)
        failed = self.watch.alarm | self.watch.doubt
        read = self.watch.seen.new.any(axis=1)
        self.held_blocks = np.where(failed, 0, self.held_blocks + read)
        self.needed_blocks = np.where(failed & self.leads, LONGER * self.needed_blocks, self.needed_blocks)
        self.leads = ~failed & (self.held_blocks >= self.needed_blocks)
        return self.model.act(observation, None)

    def details(self, machine: int) -> list[str]:
        """Return sentences that say whether the rule or the model leads, and why."""
        if self.watch is None:
            return ["the rule decides: only the control can execute this program, so there is no model of it"]
        if self.leads[machine]:
            return [f"the model decides: its forecasts have held on the last {self.held_blocks[machine]:.0f} blocks"]
        off = self.watch.said(machine) or [f"its forecasts have held on {self.held_blocks[machine]:.0f} blocks"]
        until = f"the rule decides until the model forecasts well {self.needed_blocks[machine]:.0f} blocks in a row"
        return [f"{until}: {off[0]}", *off[1:]]

    def _observed(self, number: int, n: int, seen: dict[str, float]) -> BlockReadings:
        """Return the readings of the last block from an observation; Ra is of the part before."""
        row, block = self.rules[n].rows[number], self.simulation.blocks[number]
        size, Ra = seen["size_error"], seen["roughness"]
        new_size, new_Ra = size != self.last_size[n] or abs(size) > row.size, Ra not in (0.0, self.last_Ra[n])
        self.last_size[n], self.last_Ra[n] = size, Ra
        ended = bool(block.finished)
        return BlockReadings(
            peak=seen["peak_power"],
            size=size / row.size if ended and new_size and row.size > 0.0 else None,
            Ra_before=Ra if ended and new_Ra else None,
        )
