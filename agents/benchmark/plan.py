"""The plan of a benchmark: a cell for each task, policy and training seed."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

from agents.evaluation_cache import RUNS
from grind_env.envs.task_names import CORE, shipped_names
from grind_env.message_text import did_you_mean, quoted
from grind_env.policies.evaluation import SEEDS
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.registry import FIXED_PLANS, REFERENCE, fitting, policy_names
from grind_env.policies.tuned_parameters import ConfigError

FLAGSHIP = "power_limited"
EMPIRICAL, ON_BELIEF = "empirical_rule", "belief_planner"
LONG = (REFERENCE, ON_BELIEF, "mpc")  #: policies that take long to run: the planners
EPISODES, INTERPOLATION_EPISODES, PLANTS_EPISODES = 128, 64, 64
ROBUST = "robust"
#: kinds of agents of `grind_env/training/gru_ppo.py`, with their memory; `robust` is trained on public machines
PLAIN: dict[str, Literal["gru", "belief"]] = {"plain_gru": "gru", "plain_belief": "belief", ROBUST: "gru"}
RECIPE = "ppo"  #: kind of agent that the recipe of `docs/howto/train.md` trains, with Stable-Baselines3
KINDS, USUAL_KINDS = (*PLAIN, RECIPE), (RECIPE, "plain_gru")
LAST_SEED = 398  #: last seed of trainings: a larger seed would use validation seeds for episodes (`gru_ppo.LAST_SEED`)
#: sets of out-of-model machines for training and for judging, one machine in every episode
PUBLIC, HELD_OUT = "public", "held-out"
AT = "@"  #: separator in a variant's name: `plain_gru@3M` is trained for more steps, `hindsight@12` sweeps more often
STEPS = re.compile(r"([1-9]\d{0,2})M")
LIMIT = 1_000_000  #: number of blocks that training or tuning may grind in the budget class 1M; the other class is open
#: work whose E and D are chosen in a core task, and hidden state
ABOUT = {
    "power_limited": ("wide plates at the power limit", "lot's dulling rate"),
    "reciprocation": ("plates; the wheel moves down steadily", "lot's dulling rate"),
    "wide_plates": ("plates, flat and to size", "lot's dulling rate"),
    "wide_rails": ("rails, roughed, then finished", "lot's dulling rate"),
    "blades": ("blades that burn easily", "kind of wheel, age of coolant"),
    "rush": ("orders with due dates", "lot's dulling rate"),
    "job_shop": ("parts of three kinds", "lot's dulling rate"),
}


class BenchmarkCell(NamedTuple):
    """One policy on one problem, with a training seed if it is trained."""

    problem: Problem
    policy: str
    seed: int | None = None

    @property
    def task(self) -> str:
        return self.problem.name

    def __str__(self) -> str:
        return f"{self.task} {self.name}"

    @property
    def name(self) -> str:
        """Name of the policy, with its training seed."""
        return self.policy if self.seed is None else f"{self.policy}-{self.seed}"

    @property
    def base(self) -> str:
        """Name of the policy without its variant."""
        return self.policy.partition(AT)[0]

    @property
    def variant(self) -> str:
        """Return the name of the variant; empty for none."""
        return self.policy.partition(AT)[2]

    @property
    def steps(self) -> int | None:
        """Number of training steps of a variant such as `@3M`; None for others."""
        asked = STEPS.fullmatch(self.variant)
        return int(asked[1]) * 1_000_000 if asked else None

    @property
    def apart(self) -> str:
        """Cache folder of a variant, whose policy has the name without the variant; empty without a variant."""
        return f"{AT}{self.variant}/" if self.variant else ""

    @property
    def trains(self) -> bool:
        return self.seed is not None

    def has_agent(self, runs: Path) -> bool:
        """Return whether the cache has an agent of the cell."""
        return self.trains and any((runs / self.task).glob(f"{self.name}-*"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """Options of measuring cells: episodes, training steps, and folders."""

    first: int = SEEDS["evaluation"]
    episodes: int = EPISODES
    interpolation_episodes: int = INTERPOLATION_EPISODES
    plants_episodes: int = PLANTS_EPISODES
    steps: int | None = None
    runs: Path = field(default=RUNS, repr=False)
    configs: Path | None = None
    fresh: bool = field(default=False, repr=False)


def chosen_problems(names: str, job: str | None = None, parts: int = 1) -> list[Problem]:
    """Return the problems of a list with commas, of `core` or of `all` tasks; refuse two problems of one name."""
    groups = {"core": CORE, "all": shipped_names()}
    listed = groups.get(names) or [each.strip() for each in names.split(",")]
    problems = list(dict.fromkeys(find_problem(name, job, parts) for name in listed))
    found = [problem.name for problem in problems]
    if twice := {name for name in found if found.count(name) > 1}:
        raise ConfigError(
            f"{min(twice)} is the name of two problems, whose results would be mixed: rename the file of one of them"
        )
    return problems


def planned(
    problems: Sequence[Problem], policies: Sequence[str] | None, kinds: Sequence[str], seeds: int
) -> list[BenchmarkCell]:
    """Return the cells, the slowest first; they always include the policies that anchor the score."""
    names = {problem: named(problem) for problem in problems}
    known = list(dict.fromkeys(name for each in names.values() for name in each))
    variants = [name for name in policies or () if AT in name]
    for name, _, variant in (each.partition(AT) for each in variants):
        if name != REFERENCE or not variant.isdecimal():
            raise ConfigError(
                f"{quoted(name + AT + variant)} is no variant: give {REFERENCE}@SWEEPS or AGENT@STEPS, as 3M"
            )
    if unknown := {name.partition(AT)[0] for name in policies or ()} - set(known):
        raise ConfigError(f"there is no policy {quoted(min(unknown))}: choose from {', '.join(known)}")
    if not 0 <= seeds <= LAST_SEED + 1:
        raise ConfigError(f"{seeds} training seeds are asked for, but there are 0 to {LAST_SEED + 1}")
    for kind in kinds:
        base, at, variant = kind.partition(AT)
        if base not in KINDS or bool(at) != bool(STEPS.fullmatch(variant)):
            raise ConfigError(
                f"there is no kind of agent {quoted(kind)}{did_you_mean(kind, KINDS)}: choose from {', '.join(KINDS)}"
            )
    wanted = {*(known if policies is None else policies), *FIXED_PLANS, REFERENCE}
    cells = []
    for problem in problems:
        cells += [BenchmarkCell(problem, kind, seed) for kind in kinds for seed in range(seeds)]
        cells += [BenchmarkCell(problem, name) for name in names[problem] if name in wanted]
        cells += [BenchmarkCell(problem, name) for name in variants if name.partition(AT)[0] in names[problem]]
    return sorted(cells, key=lambda cell: (cell.policy not in LONG, cell.seed is None))


def named(problem: Problem) -> list[str]:
    """Return the names of the policies of a problem, with the planner on the belief and the empirical rule."""
    simulation = problem.simulation()
    return [*policy_names(simulation), *fitting([EMPIRICAL, ON_BELIEF], simulation)]
