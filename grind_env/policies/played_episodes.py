"""Episodes played by a policy, with their part programs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from grind_env.envs.distribution_splits import EVERY
from grind_env.machine.job import Job
from grind_env.policies.nominal_model import model_beside, parted
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """Result of a played episode."""

    program: str  #: part program with its dress program, as `machine.grind` runs it
    job: Job  #: job of the program, with the wheel, lots and stocks of the episode
    #: times of the control, s, at which the operator asks for a dress while the program runs
    requests: tuple[float, ...]
    cost: float  #: cost of the episode, $
    handover: float  #: part of `cost` for the wheel's state after the last block, $, which no run of the program shows
    good: float  #: expected number of good parts
    finished: int  #: number of finished parts
    dresses: int  #: number of dress executions
    seconds: float  #: time on the machine, s


def stepped(
    policy: Policy, problem: Problem, seed: int, split: str = EVERY, render_mode: str | None = None
) -> Iterator[tuple[Any, Mapping[str, Any]]]:
    """Yield the environment and the `info` of an episode at its reset and after every step; arguments as for `play`."""
    env: Any = problem.make(render_mode=render_mode).unwrapped
    try:
        observation, info = env.reset(seed=seed, options={"split": split})
        model = model_beside(problem)
        held, shown = model or env.simulation, parted(policy, env.simulation, model, env.episodes)
        policy.begin(held, 1)
        yield env, info
        over = False
        while not over:
            decision = policy.act(observation[None], reveal(policy.sees, held, shown(env.episodes)))
            observation, _, over, _, info = env.step(env.codec.encode(*decision)[0])
            yield env, info
    finally:
        env.close()


def play(policy: Policy, problem: Problem, seed: int, split: str = EVERY, render_mode: str | None = None) -> Played:
    """Run a policy through the episode of a seed, in the public environment.

    On an out-of-model machine the policy computes with the model.

    Args:
        policy: the policy.
        problem: the problem.
        seed: seed of the episode.
        split: split of the contexts, as in `evaluate`.
        render_mode: `"human"` for a window, or without a screen text in the terminal; `"ansi"` for text; None to show
            nothing.

    Raises:
        GrindError: there is no such split, or the policy chooses an E or a D that the environment lacks.
    """
    executions = 0
    for env, info in stepped(policy, problem, seed, split, render_mode):
        executions += int(info.get("D", 0))
        if render_mode == "ansi" and "D" in info:
            print(env.render())
    written, outcomes = env.written(), env.outcomes
    return Played(
        program=written.program,
        job=written.job,
        requests=written.requests,
        cost=sum(outcome.cost for outcome in outcomes),
        handover=sum(outcome.handover_cost for outcome in outcomes),
        good=sum(outcome.good for outcome in outcomes),
        finished=round(sum(outcome.finished for outcome in outcomes)),
        dresses=executions,
        seconds=sum(outcome.seconds for outcome in outcomes),
    )
