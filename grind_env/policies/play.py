"""One episode of one policy, to watch, and the part program that came of it."""

from dataclasses import dataclass

from grind_env.envs.env import GrindEnv
from grind_env.envs.tasks import Task
from grind_env.policies.evaluation import split_of
from grind_env.policies.policy import Policy, reveal


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """What came of an episode."""

    program: str
    """Part program with its dress program, as `machine.grind` runs it."""
    cost: float
    """$."""
    good: float
    """Expected number of good parts."""
    finished: int
    """Parts finished."""
    dresses: int
    """Dress executions."""
    seconds: float
    """Time on the machine, s."""


def play(policy: Policy, task: Task, seed: int, render_mode: str | None = None) -> Played:
    """Run a policy through the episode of a seed, in the environment that anybody else would step.

    Args:
        policy: decides.
        task: what it grinds.
        seed: of the episode; one of the split `"test"` draws it from the test contexts, as `evaluate` does.
        render_mode: `"human"` to follow it in a window, or without a screen as text in the terminal; `"ansi"` for text;
            None to show nothing.
    """
    env = GrindEnv(task=task.name, observation="measured", render_mode=render_mode)
    policy.begin(task, 1)
    try:
        observation, _ = env.reset(seed=seed, options={"split": "test"} if split_of(seed) == "test" else None)
        over = False
        while not over:
            assert env.episodes is not None
            decision = policy.act(observation[None], reveal(policy.sees, task, env.episodes))
            observation, _, over, _, _ = env.step(env.codec.encode(*decision)[0])
            if render_mode == "ansi":
                print(env.render())
        outcomes = env.outcomes
        return Played(
            program=env.part_program(),
            cost=sum(outcome.cost for outcome in outcomes),
            good=sum(outcome.good for outcome in outcomes),
            finished=round(sum(outcome.finished for outcome in outcomes)),
            dresses=sum(block.executions for block in env.blocks),
            seconds=sum(outcome.seconds for outcome in outcomes),
        )
    finally:
        env.close()
