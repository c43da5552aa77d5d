"""Full grid of the benchmark: the cells of all results."""

from collections.abc import Sequence

from agents.benchmark.cpu_time import DECISION
from agents.benchmark.plan import AT, KINDS, BenchmarkCell, planned
from grind_env.envs.task_names import CORE
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import REFERENCE

EPISODES, INTERPOLATION_EPISODES, PLANTS_EPISODES = 512, 256, 256
#: number of trainings of every kind in a task, and of every kind with more than a million steps
SEEDS, LONGER_SEEDS = 5, 3
#: longer trainings, and their tasks
LONGER = {"plain_gru@3M": CORE, "plain_gru@10M": ("power_limited", "wide_plates", "blades")}
MORE_SEARCH = f"{REFERENCE}{AT}12"  #: hindsight with four times the search: shows whether 100 is near the optimum


def grid(
    problems: Sequence[Problem], policies: Sequence[str] | None, kinds: Sequence[str] | None, seeds: int | None
) -> list[BenchmarkCell]:
    """Return the cells of the grid, the slowest first; by default of all policies, variants and kinds."""
    cells = dict.fromkeys(planned(problems, policies, [], 0))
    for problem in problems:
        usual = [*KINDS, *(kind for kind, tasks in LONGER.items() if problem.name in tasks)]
        for kind in usual if kinds is None else kinds:
            count = (LONGER_SEEDS if AT in kind else SEEDS) if seeds is None else seeds
            cells |= dict.fromkeys(planned([problem], [], [kind], count))
        if policies is None:
            cells[BenchmarkCell(problem, MORE_SEARCH)] = None
    return sorted(cells, key=lambda cell: (-(cell.steps or 0), -DECISION.get(cell.base, 0.0) - cell.trains))
