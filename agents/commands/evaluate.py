"""`python -m agents evaluate`."""

import json
from pathlib import Path
from typing import Annotated

import typer

from grind_env.envs.tasks import load_task
from grind_env.policies.evaluation import SPLITS, episode_seeds
from grind_env.policies.evaluation import evaluate as run_policy
from grind_env.policies.registry import make_policy
from grind_env.policies.tuned import CONFIGS


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents evaluate --policy adaptive_rule --episodes 64")(evaluate)


def evaluate(
    policy: Annotated[str, typer.Option(help="Name of a policy, or the .safetensors file of a trained agent.")],
    task: Annotated[str, typer.Option(help="Name of the task.")] = "power_limited",
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 64,
    split: Annotated[str, typer.Option(help=f"Seeds: {', '.join(SPLITS)}.")] = "evaluation",
    configs: Annotated[Path, typer.Option(help="Folder of the tuned parameters of the scripted policies.")] = CONFIGS,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run one policy and print what a good part costs."""
    from grind_env.policies.learned.saved import SUFFIX, load_policy

    job = load_task(task)
    decides = load_policy(Path(policy)) if policy.endswith(SUFFIX) else make_policy(policy, job, configs)
    result = run_policy(decides, job, episode_seeds(split, episodes))
    cost = result.cost_per_good_part
    numbers = {
        "cost_per_good_part": cost.value,
        "low": cost.low,
        "high": cost.high,
        "scrap": result.scrap,
        "E": float(result.speeds.mean()) / 1000.0,
        "D": float(result.executions.mean()),
    }
    if as_json:
        print(json.dumps({"task": task, "policy": policy, "split": split, "episodes": episodes, **numbers}))
    else:
        print(
            f"{policy}: {cost.value:.3f} $ per good part ({cost.low:.3f} to {cost.high:.3f}),"
            f" {100 * result.scrap:.2f} % scrap, E {numbers['E']:.1f} m/min, D {numbers['D']:.2f}"
        )
