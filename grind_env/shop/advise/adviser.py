"""The policy at the machine: advice before each block, from what was said of those before."""

import copy
from dataclasses import dataclass, replace
from functools import partial

from grind_env.envs.job.measured import MeasuredEpisode
from grind_env.envs.job.outline import INCH, JobChoice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.program_episode import Words
from grind_env.errors import GrindError
from grind_env.policies.guard import STEP, Guarded
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy
from grind_env.policies.scripted.empirical_rule import INTERVAL, EmpiricalRule
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.policies.tuned import read_tuned, tuned_folder
from grind_env.shop.advise.forecast import Forecast, Forecaster
from grind_env.shop.advise.readings import Readings

DEFAULT = "look_ahead"
MOST_STEP = 100.0
"""No table has a wider range of E."""
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


def policy_for(text: str | None, simulation: JobSimulation, step: float = STEP, *, other_part: bool = False) -> Policy:
    """The policy that a text names; without one `look_ahead` with a guard, with usual prices where it is not tuned.

    A program that the control has to execute cannot be looked ahead in: without a text `empirical_rule` advises on it.

    Args:
        text: as for `named_policy`.
        simulation: of the program.
        step: most that E of a policy with a guard is above the fastest tried in blocks of a kind.
        other_part: as for `load_policy`.

    Raises:
        GrindError: there is none, it does not fit the program, or it needs to see more than is measured, or the step is
            no factor above 1.
    """
    if not 1.0 < step <= MOST_STEP:
        raise AdviceError(f"--step is {step:g}, but must be a factor above 1 and at most {MOST_STEP:g}: try {STEP:g}")
    # readings of every part are at hand: a wheel may last half as long again as it usually does
    rule = EmpiricalRule(step=step, interval=1.5 * INTERVAL)
    if text is None and not simulation.compiled:
        return rule
    kinds, uncertainty = len(simulation.task.kinds), simulation.job.uncertainty
    residual = 0.0 if uncertainty is None else uncertainty.residual
    watched = partial(Guarded, rule=rule, step=step, cautious=True, residual=residual)
    if text is None and DEFAULT not in read_tuned(simulation.task.name, tuned_folder(simulation.task)):
        ahead = LookAhead(price=(USUAL_PRICE,) * kinds, growth=(USUAL_GROWTH,) * kinds, caution=USUAL_CAUTION)
        return watched(ahead)
    policy = named_policy(text or f"{Guarded.PREFIX}{DEFAULT}", simulation, other_part=other_part)
    if policy.sees != "measurements":
        raise AdviceError(
            f"{policy.name} cannot advise at a machine, where nobody sees the {policy.sees} that it needs: "
            "choose one that sees measurements, such as look_ahead or belief_rule"
        )
    if isinstance(policy, Guarded):
        return watched(policy.policy)
    if step != STEP:
        raise AdviceError(
            f"--step is of a policy with the guard, which {policy.name} has not: leave it out, or name "
            f"{Guarded.PREFIX}{text}"
        )
    return policy


def within(simulation: JobSimulation, bounds: tuple[float, float]) -> JobSimulation:
    """The same for a policy that is to choose an E within bounds, m/min.

    Raises:
        AdviceError: these are no bounds within those of a program.
    """
    low, high = bounds
    least, most = simulation.task.action.speed_ends
    if not least <= low < high <= most:
        raise AdviceError(f"--bounds are {low:g} {high:g}, but must lie between {least:g} and {most:g} m/min, in order")
    twin = copy.copy(simulation)
    twin.task = replace(twin.task, action=replace(twin.task.action, speed_range=bounds))
    return twin


class Adviser:
    """Advises on one batch, block by block.

    Args:
        simulation: of the program.
        policy: that sees measurements.
        bounds: lowest and highest E that is advised, m/min; those of a program if None.
        shadow: whether somebody else decides, by default what the program says.

    Attributes:
        advice: on the coming block; None after the last one.
    """

    advice: Advice | None

    def __init__(
        self,
        simulation: JobSimulation,
        policy: Policy,
        *,
        bounds: tuple[float, float] | None = None,
        shadow: bool = False,
    ) -> None:
        self.simulation, self.policy, self.shadow = simulation, policy, shadow
        self.episode = MeasuredEpisode(simulation)
        self.forecaster = Forecaster(simulation) if simulation.compiled else None
        policy.begin(simulation if bounds is None else within(simulation, bounds), 1)
        self._decide()

    def take(self, readings: Readings) -> None:
        """The block that was advised on has been ground, and this was read.

        Raises:
            GrindError: there was none, or the control refuses it.
        """
        if self.advice is None:
            raise AdviceError("the last block of the batch has been ground: begin a new one with --restart")
        block = self.simulation.blocks[self.advice.block]
        usual = (
            (block.plan.feed, int(block.plan.dresses)) if self.shadow else (self.advice.speed, self.advice.executions)
        )
        speed = usual[0] if readings.E is None else readings.E * (INCH if block.inch else 1.0)
        executions = usual[1] if readings.D is None else readings.D
        meter_scale = self.simulation.job.setup.machine.meter_scale
        self.episode.take(*self.episode.taken(speed, executions), readings.measured(meter_scale))
        self._decide()

    def forecast(self) -> Forecast | None:
        """The reason of the advice; None after the last block, and where the control has to execute the program."""
        if self.forecaster is None or self.advice is None:
            return None
        return self.forecaster.forecast(self.advice.block, self.advice.speed, self.advice.executions)

    @property
    def guard(self) -> Guarded | None:
        """That of the policy, if it has one."""
        return self.policy if isinstance(self.policy, Guarded) else None

    def _decide(self) -> None:
        self.advice = None
        observation = self.episode.observation()
        if self.episode.over:
            if self.guard is not None:  # the last readings are compared, too
                self.guard.watch.update(observation, self.guard.rule.power)
            return
        if self.forecaster is not None:
            self.forecaster.update(observation)
        decision = self.policy.act(observation, None)
        number = self.episode.block
        speed, executions = self.episode.taken(float(decision.speeds[0]), float(decision.executions[0]))
        words = self.simulation.blocks[number].words(JobChoice(speed, executions))
        self.advice = Advice(block=number, speed=speed, executions=executions, words=words)
