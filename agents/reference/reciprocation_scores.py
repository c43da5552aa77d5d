"""Reference scores of `grind/Reciprocation-v0`: the plans, the rule and the planner of the tasks, on its own blocks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.coefficients import RULES, from_vector, rounded
from agents.reference.scores import reference_of
from agents.search import evolve, grid_search, refine
from grind_env.envs.names import environment_id
from grind_env.envs.reciprocation.program import TASK
from grind_env.envs.reciprocation.simulation import ReciprocationSimulation
from grind_env.envs.tasks import Task, read_task
from grind_env.policies.choices import speed_bounds, speed_grid
from grind_env.policies.evaluation import Evaluation, episode_seeds, roll_out, start_episodes
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.policy import Policy
from grind_env.policies.scripted.rules import Fixed, PowerThreshold, Random, handbook
from grind_env.policies.tuned import arguments, write_whole
from grind_env.scores import FILE, Reference, read_references, write_text

EPISODES = 64
TRAINING = 48
SPEEDS, INTERVAL_SPEEDS = 20, 12
INTERVALS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20)
"""Parts from one request for a dress to the next."""
EVALUATIONS = 300
"""Of each of the CMA-ES runs of the rule."""
STARTS = (0, 1)
"""Seeds of these runs."""


@dataclass
class FeedThreshold(PowerThreshold):
    """`PowerThreshold` that reads the observation of this environment."""

    def begin(self, task: Task, episodes: int) -> None:
        """As `PowerThreshold.begin`."""
        super().begin(task, episodes)
        self.entries = ReciprocationSimulation(task).entries


@dataclass
class FeedHindsight(Hindsight):
    """`Hindsight` that plans with the blocks of this environment."""

    def begin(self, task: Task, episodes: int) -> None:
        """As `Hindsight.begin`."""
        super().begin(task, episodes)
        self.simulation = ReciprocationSimulation(task)


class FeedTuner:
    """Searches plans and rules on the training episodes.

    Args:
        simulation: of the task.
        episodes: number of training episodes, and of validation episodes.
        advance: called after every evaluation.
    """

    def __init__(
        self,
        simulation: ReciprocationSimulation,
        episodes: int = TRAINING,
        advance: Callable[[], object] = lambda: None,
    ) -> None:
        self.simulation = simulation
        self._episodes = {
            split: start_episodes(simulation, episode_seeds(split, episodes)) for split in ("training", "validation")
        }
        self._advance = advance

    def cost(self, policy: Policy, split: str = "training") -> float:
        """Mean cost of an episode, $."""
        self._advance()
        return float(roll_out(policy, self.simulation, self._episodes[split]).cost.mean())

    def fixed(self, name: str, speeds: int, executions: Sequence[int], intervals: Sequence[int]) -> Fixed:
        """The best plan without sensors of a grid, its E refined."""
        task = self.simulation.task

        def plan(E: float, D: int, every: int) -> Fixed:
            return Fixed(rounded(E), D, every, name)

        grid = product((speed_grid(task, speeds) / 1000.0).tolist(), executions, intervals)
        found = grid_search(lambda point: self.cost(plan(*point)), grid)
        E, *rest = found.point
        low, high = speed_bounds(task)
        found = refine(lambda E: self.cost(plan(E, *rest)), found._replace(point=E), low / 1000.0, high / 1000.0)
        return plan(found.point, *rest)

    def threshold(self, evaluations: int) -> FeedThreshold:
        """The best of the CMA-ES runs of the power rule, on the validation episodes."""
        coefficients = RULES["power_threshold"]

        def make(vector: Any) -> FeedThreshold:
            return FeedThreshold(**arguments(from_vector(coefficients, self.simulation.task, vector)))

        start = [0.0] * len(coefficients)
        runs = [evolve(lambda vector: self.cost(make(vector)), start, evaluations, seed) for seed in STARTS]
        return min((make(run.point) for run in runs), key=lambda policy: self.cost(policy, "validation"))


def reciprocation_reference(*, episodes: int = EPISODES, evaluations: int = EVALUATIONS) -> Reference:
    """Tune the plans and the rule, plan the evaluation episodes, and measure all on them.

    Args:
        episodes: evaluation episodes.
        evaluations: of each CMA-ES run.
    """
    task = read_task(TASK)
    simulation = ReciprocationSimulation(task)
    start = start_episodes(simulation, episode_seeds("evaluation", episodes))
    found: dict[str, Evaluation] = {}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, transient=True) as progress:
        bar = progress.add_task(f"{TASK}: tuning", total=None)
        tuner = FeedTuner(simulation, advance=lambda: progress.advance(bar))
        policies: list[Policy] = [
            Random(),
            handbook(task),
            tuner.fixed("constant", SPEEDS, range(task.action.executions + 1), (1,)),
            tuner.fixed("interval", INTERVAL_SPEEDS, (1, 2), INTERVALS),
            tuner.threshold(evaluations),
            FeedHindsight(),
        ]
        progress.update(bar, total=progress.tasks[0].completed)
        bar = progress.add_task(TASK, total=len(policies))
        for policy in policies:
            progress.update(bar, description=f"{TASK}: {policy.name}")
            found[policy.name] = roll_out(policy, simulation, start)
            progress.advance(bar)
    return reference_of(task, policies, found)


def score_reciprocation(data: Path = FILE) -> None:
    """Measure the reference scores of the continuous infeed."""
    found = reciprocation_reference()
    # read only now: others may have written to the file in the meantime
    write_whole(data, write_text({**read_references(data), environment_id(TASK): found}))
