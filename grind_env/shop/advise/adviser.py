"""The policy at the machine: advice before each block, from what was said of those before."""

from dataclasses import dataclass

from grind_env.envs.job.measured import MeasuredEpisode
from grind_env.envs.job.outline import INCH, Choice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.program_episode import Words
from grind_env.errors import GrindError
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.policies.tuned import read_tuned, tuned_folder
from grind_env.shop.advise.forecast import Forecast, Forecaster
from grind_env.shop.advise.readings import Readings

DEFAULT = "look_ahead"
USUAL_PRICE, USUAL_GROWTH, USUAL_CAUTION = 1.1, 1.5, 2.7
"""Of `LookAhead`, for a program that it has not been tuned for: the medians over the tasks that it has."""


class AdviceError(GrindError):
    """A policy that cannot advise, or advice for which nothing is left to grind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Advice:
    """E and D of a block.

    Attributes:
        block: number of the block, from 0.
        speed: E, mm/min.
        executions: D, the number of auto-dresses.
        words: both as the program says them, in its units, by letter.
    """

    block: int
    speed: float
    executions: int
    words: Words


def policy_for(text: str | None, simulation: JobSimulation) -> Policy:
    """The policy that a text names; without one `look_ahead`, with usual prices where it has not been tuned.

    Raises:
        GrindError: there is none, it does not fit the program, or it needs to see more than is measured.
    """
    if text is None and not simulation.compiled:
        raise AdviceError(
            f"{simulation.programs.name} cannot be looked ahead in, for the control has to execute it "
            f"({simulation.why}): name another --policy, such as handbook or adaptive_rule"
        )
    kinds = len(simulation.task.kinds)
    if text is None and DEFAULT not in read_tuned(simulation.task.name, tuned_folder(simulation.task)):
        return LookAhead(price=(USUAL_PRICE,) * kinds, growth=(USUAL_GROWTH,) * kinds, caution=USUAL_CAUTION)
    policy = named_policy(text or DEFAULT, simulation)
    if policy.sees != "measurements":
        raise AdviceError(
            f"{policy.name} cannot advise at a machine, where nobody sees the {policy.sees} that it needs: "
            "choose one that sees measurements, such as look_ahead or belief_rule"
        )
    return policy


class Adviser:
    """Advises on one batch, block by block.

    Args:
        simulation: of the program.
        policy: that sees measurements.

    Attributes:
        advice: on the coming block; None after the last one.
    """

    advice: Advice | None

    def __init__(self, simulation: JobSimulation, policy: Policy) -> None:
        self.simulation, self.policy = simulation, policy
        self.episode = MeasuredEpisode(simulation)
        self.forecaster = Forecaster(simulation) if simulation.compiled else None
        policy.begin(simulation, 1)
        self._decide()

    def take(self, readings: Readings) -> None:
        """The block that was advised on has been ground, and this was read.

        Raises:
            GrindError: there was none, or the control refuses it.
        """
        if self.advice is None:
            raise AdviceError("the last block of the batch has been ground: begin a new one with --restart")
        block = self.simulation.blocks[self.advice.block]
        speed = self.advice.speed if readings.E is None else readings.E * (INCH if block.inch else 1.0)
        executions = self.advice.executions if readings.D is None else readings.D
        self.episode.take(
            *self.episode.taken(speed, executions),
            readings.measured(self.episode.simulation.job.setup.machine.meter_scale),
        )
        self._decide()

    def forecast(self) -> Forecast | None:
        """The reason of the advice; None after the last block, and where the control has to execute the program."""
        if self.forecaster is None or self.advice is None:
            return None
        return self.forecaster.forecast(self.advice.block, self.advice.speed, self.advice.executions)

    def _decide(self) -> None:
        self.advice = None
        if self.episode.over:
            return
        observation = self.episode.observation()
        if self.forecaster is not None:
            self.forecaster.update(observation)
        decision = self.policy.act(observation, None)
        number = self.episode.block
        speed, executions = self.episode.taken(float(decision.speeds[0]), float(decision.executions[0]))
        words = self.simulation.blocks[number].words(Choice(speed, executions))
        self.advice = Advice(block=number, speed=speed, executions=executions, words=words)
