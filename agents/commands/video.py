"""`python -m agents video`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.command_defaults import PICTURES
from grind_env.envs.distribution_splits import EVERY
from grind_env.file_arguments import FILE, Writes
from grind_env.message_text import printable
from grind_env.policies.evaluation import SEEDS
from grind_env.policies.problem_lookup import find_problem
from grind_env.policy_commands import Configs, JobFile, NamedProblem, Parts, Split


def video(
    left: Annotated[str, typer.Option(help="Policy, agent file, or constant E8000D0 (E in mm/min)."), FILE],
    output: Annotated[Path, typer.Option(help="The .gif file to write."), Writes()],
    right: Annotated[str | None, typer.Option(help="Second policy or agent file; default none."), FILE] = None,
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the episode.")] = SEEDS["evaluation"],
    split: Split = EVERY,
    frames: Annotated[int, typer.Option(min=1, help="Frames of each block.")] = PICTURES,
    configs: Configs = None,
) -> None:
    """Film a policy, or two side by side on the same episode."""
    from agents.video import record
    from grind_env.policies.policy_lookup import named_policy

    problem = find_problem(task, job, parts)
    policies = [named_policy(name, problem.simulation(), configs) for name in (left, right) if name is not None]
    size = record(policies, problem, seed, output, frames, split)
    print(printable(f"{output}: {size / 1e6:.1f} MB"))
