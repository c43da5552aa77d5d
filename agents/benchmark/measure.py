"""Measures one cell: trains the agent if there is none yet, and runs the policy through the episodes."""

from dataclasses import dataclass

from agents.benchmark.plan import Cell, Request
from agents.benchmark.trained import from_file
from agents.cells import Advance, kept_evaluation
from agents.learning.curve import Point, curve_path, read_curve, seconds_to
from agents.learning.settings import settings_of
from grind_env.envs.splits import EVERY
from grind_env.policies.evaluation import Evaluation, episode_seeds
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.registry import make_policy


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What was found of a cell.

    Attributes:
        cell: the cell.
        sees: what the policy sees.
        evaluation: on the evaluation seeds, split `all`.
        interpolation: on the same seeds with contexts of the split `interpolation`, if asked for.
        trained_on: split that the contexts of the training were drawn from; None of a policy that is not trained.
        curve: learning curve of the agent; empty of a policy that is not trained.
    """

    cell: Cell
    sees: Sees
    evaluation: Evaluation
    interpolation: Evaluation | None = None
    trained_on: str | None = None
    curve: tuple[Point, ...] = ()

    @property
    def steps(self) -> int | None:
        """Training steps."""
        return self.curve[-1].steps if self.curve else None

    @property
    def train_seconds(self) -> float | None:
        """Wall time of the training."""
        return self.curve[-1].seconds if self.curve else None

    @property
    def seconds_to_95(self) -> float | None:
        """Wall time after which the validation score stays above 95 % of the final one."""
        return seconds_to(self.curve) if self.curve else None


def measure(cell: Cell, request: Request, advance: Advance = lambda episodes: None) -> Measured:
    """Measure a cell; what is kept of the same code, parameters and seeds is not run again.

    Args:
        cell: what to measure.
        request: how.
        advance: called with the number of episodes of each chunk that is done.

    Raises:
        GrindError: if the policy has not been tuned, cannot be trained or does not fit the problem.
    """
    problem, simulation, curve = cell.problem, cell.problem.simulation(), []
    policy: Policy
    trained_on = None
    if cell.seed is None:
        policy = make_policy(cell.policy, simulation, request.configs)
    else:
        # torch takes seconds to import
        from agents.learning.train import trained_agent

        path = trained_agent(problem, cell.policy, cell.seed, request.steps, request.runs, request.fresh, quiet=True)
        policy = from_file(path, simulation, cell.name)
        trained_on = settings_of(problem, cell.policy).split
        if curve_path(path).exists():
            curve = read_curve(curve_path(path))

    def run(split: str, count: int) -> Evaluation:
        seeds = episode_seeds("evaluation", count)
        return kept_evaluation(policy, problem, seeds, request.runs, split=split, fresh=request.fresh, advance=advance)

    return Measured(
        cell=cell,
        sees=policy.sees,
        evaluation=run(EVERY, request.episodes),
        interpolation=run("interpolation", request.interpolation_episodes) if request.interpolation_episodes else None,
        trained_on=trained_on,
        curve=tuple(curve),
    )
