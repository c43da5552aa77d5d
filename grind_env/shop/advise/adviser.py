"""The adviser: E and D before each block, from the readings so far."""

import copy
from dataclasses import dataclass, replace

from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import INCH, JobChoice
from grind_env.envs.job.real_machine_episode import MeasuredEpisode
from grind_env.envs.program_episode import Words
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.policies.mismatch_alarms import Watch
from grind_env.policies.policy import Policy
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.policies.tuned_parameters import read_tuned, tuned_folder
from grind_env.shop.advise.adviser_policy import AdviserPolicy
from grind_env.shop.advise.model_free_rule import STEP, BlockReadings
from grind_env.shop.advise.operator_readings import MachineReadings

MOST_STEP = 100.0  #: greatest legal step factor of E; no table has a wider range of E
#: parameters of `LookAhead` for a program without tuned ones: the medians over the tuned tasks
USUAL_PRICE, USUAL_GROWTH, USUAL_CAUTION = 1.1, 1.5, 2.7


class AdviceError(GrindError):
    """Policy that cannot advise, advice without a block left to grind, or arguments that exclude each other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Advice:
    """E and D of a block."""

    block: int  #: number of the block, from 0
    speed: float  #: E, mm/min
    executions: int  #: D, the number of auto-dresses
    words: Words  #: E and D by letter, in the units of the program


def policy_for(text: str | None, simulation: JobSimulation, step: float = STEP, *, other_part: bool = False) -> Policy:
    """Return the policy that a text names, or the default adviser.

    Raises:
        GrindError: the policy does not exist, does not fit the program or needs more than measurements, or the step is
            no factor above 1.
    """
    if not 1.0 < step <= MOST_STEP:
        raise AdviceError(
            f"--max-step is {step:g}, but must be a factor above 1 and at most {MOST_STEP:g}: try {STEP:g}"
        )
    if text is None:
        uncertainty = simulation.job.uncertainty
        residual = 0.0 if uncertainty is None else uncertainty.residual
        return AdviserPolicy(_model(simulation) if simulation.compiled else None, step, residual)
    if step != STEP:
        raise AdviceError("--max-step is of the default adviser: leave out --max-step, or --policy")
    policy = named_policy(text, simulation, other_part=other_part)
    if policy.sees != "measurements":
        raise AdviceError(
            f"{policy.name} cannot advise at a machine, where nobody sees the {policy.sees} that it needs: "
            "choose one that sees measurements, such as look_ahead or belief_rule"
        )
    return policy


def _model(simulation: JobSimulation) -> Policy:
    """Return a look-ahead on the model, tuned for the program or with usual prices."""
    if LookAhead.name in read_tuned(simulation.task.name, tuned_folder(simulation.task)):
        return named_policy(LookAhead.name, simulation)
    kinds = len(simulation.task.kinds)
    return LookAhead(price=(USUAL_PRICE,) * kinds, growth=(USUAL_GROWTH,) * kinds, caution=USUAL_CAUTION)


def within(simulation: JobSimulation, bounds: tuple[float, float]) -> JobSimulation:
    """Return a copy of the simulation with E limited to bounds, mm/min.

    Raises:
        AdviceError: the bounds are not in order, or not within those of the program.
    """
    low, high = bounds
    least, most = simulation.task.action.speed_ends
    if not least <= low < high <= most:
        raise AdviceError(
            f"--bounds are {low:g} {high:g}, but must lie between {least:g} and {most:g} mm/min, in order"
        )
    twin = copy.copy(simulation)
    twin.task = replace(twin.task, action=replace(twin.task.action, speed_range=bounds))
    return twin


class Adviser:
    """Adviser for one batch, block by block.

    Args:
        simulation: simulation of the program.
        policy: policy on measurements.
        bounds: lowest and highest advised E, mm/min; the program's range if None. The table's maximum holds, too.
        shadow: whether somebody else decides; E and D without a reading are then the program's.
    """

    advice: Advice | None  #: advice for the coming block; None after the last

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
        policy.begin(simulation if bounds is None else within(simulation, bounds), 1)
        self._decide()

    def take(self, readings: MachineReadings) -> None:
        """Take the readings of the block that the last advice was for.

        Raises:
            GrindError: there was no advice, or the control refuses E or D.
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
        if isinstance(self.policy, AdviserPolicy):
            self.policy.readings = [_ratios(readings, self.simulation.job.of_part(block.part + 1), meter_scale)]
        self._decide()

    @property
    def power(self) -> float | None:
        """Return the expected highest load of the coming block, W above idle; None if unknown."""
        if self.advice is None or not isinstance(self.policy, AdviserPolicy):
            return None
        return self.policy.rules[0].power_at(self.advice.block, JobChoice(self.advice.speed, self.advice.executions))

    @property
    def watch(self) -> Watch | None:
        """Return the comparison of the model's forecasts with readings; None without forecasts."""
        return self.policy.watch if isinstance(self.policy, AdviserPolicy) else None

    @property
    def reason(self) -> str:
        """Return the reason of the advice in a few words."""
        return self.policy.rules[0].reason if isinstance(self.policy, AdviserPolicy) else f"by {self.policy.name}"

    def details(self) -> list[str]:
        """Return sentences that explain the reason."""
        return self.policy.details(0) if isinstance(self.policy, AdviserPolicy) else []

    def _decide(self) -> None:
        self.advice = None
        observation = self.episode.observation()
        if self.episode.over:
            if isinstance(self.policy, AdviserPolicy):  # the last readings are compared, too
                self.policy.compare(observation)
            return
        decision = self.policy.act(observation, None)
        number = self.episode.block
        speed, executions = self.episode.taken(float(decision.speeds[0]), float(decision.executions[0]))
        words = self.simulation.blocks[number].words(JobChoice(speed, executions))
        self.advice = Advice(block=number, speed=speed, executions=executions, words=words)


def _ratios(readings: MachineReadings, job: Job, meter_scale: float) -> BlockReadings:
    """Return readings as ratios to the limits of a part."""

    def ratio(value: float | None, limit: float) -> float | None:
        return None if value is None or limit <= 0.0 else value / limit

    return BlockReadings(
        peak=(readings.peak_power or 0.0) / meter_scale,
        size=ratio(readings.size_error, job.part.tolerance),
        Ra=ratio(readings.Ra, job.limits.roughness),
        Ra_before=ratio(readings.Ra_before, job.limits.roughness),
        burn=readings.burn,
    )
