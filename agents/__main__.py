"""`python -m agents tune | train | evaluate | benchmark | scores | video`."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from agents import benchmark as benchmarking
from agents import tune as tuning
from agents.evaluate import SPLITS, episode_seeds
from agents.evaluate import evaluate as run_policy
from agents.learning.train import LAST_SEED, LearnedPolicy, Training, trained_agent
from agents.reference import scores as scoring
from agents.reference.compare import compare as compare_published
from agents.reference.compare import comparison_table
from agents.registry import check_names, make_policy
from agents.tuned import CONFIGS
from agents.video import Film, policy_of, record
from grind_env.envs.tasks import load_task
from grind_env.errors import GrindError
from grind_env.scores import FILE as SCORES

BAD_INPUT = 2

STEPS = Training().steps

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Tune, evaluate and compare policies on the tasks of grind_env.",
)

TaskName = Annotated[str, typer.Option("--task", help="Name of the task.")]
Policies = Annotated[str | None, typer.Option(help="Names of policies, separated by commas; all by default.")]
Configs = Annotated[Path, typer.Option(help="Folder of the tuned parameters.")]
Steps = Annotated[int, typer.Option(min=1, help="Training steps.")]
Runs = Annotated[Path, typer.Option(help="Folder of the results.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Do again what is already done.")]


@app.command(epilog="Example: python -m agents tune --task power_limited --policies adaptive_rule --fresh")
def tune(
    task: TaskName = "power_limited",
    policies: Policies = None,
    evaluations: Annotated[int, typer.Option(min=1, help="Evaluations of each CMA-ES run.")] = tuning.EVALUATIONS,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes of each split.")] = tuning.EPISODES,
    configs: Configs = CONFIGS,
    fresh: Fresh = False,
) -> None:
    """Tune scripted policies on training episodes and store their parameters."""
    tuned = tuning.tune(task, listed(policies), evaluations=evaluations, episodes=episodes, folder=configs, fresh=fresh)
    for name, entry in tuned.items():
        print(f"{name}: {entry.training_cost} $ an episode in training, {entry.validation_cost} $ in validation")


@app.command(epilog="Example: python -m agents train --task power_limited --seed 0")
def train(
    task: TaskName = "power_limited",
    seed: Annotated[
        int, typer.Option(min=0, max=LAST_SEED, help="Seed of the agent and of its training episodes.")
    ] = 0,
    steps: Steps = STEPS,
    runs: Runs = benchmarking.RUNS,
    fresh: Fresh = False,
) -> None:
    """Train PPO; an agent already trained by the same code, settings and seed is kept."""
    path = trained_agent(load_task(task), seed, steps, runs, fresh)
    print(f"trained agent: {path}")


@app.command(epilog="Example: python -m agents evaluate --policy adaptive_rule --episodes 64")
def evaluate(
    policy: Annotated[str, typer.Option(help="Name of a policy, or the .zip file of a trained agent.")],
    task: TaskName = "power_limited",
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 64,
    split: Annotated[str, typer.Option(help=f"Seeds: {', '.join(SPLITS)}.")] = "evaluation",
    configs: Configs = CONFIGS,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run one policy and print what a good part costs."""
    job = load_task(task)
    decides = LearnedPolicy(Path(policy)) if policy.endswith(".zip") else make_policy(policy, job, configs)
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


@app.command(epilog="Example: python -m agents benchmark --task power_limited")
def benchmark(
    task: TaskName = "power_limited",
    policies: Policies = None,
    episodes: Annotated[int, typer.Option(min=1, help="Number of paired episodes.")] = benchmarking.EPISODES,
    agents: Annotated[int, typer.Option(min=0, help="PPO agents to train, with seeds 0, 1, ...")] = 1,
    steps: Steps = STEPS,
    runs: Runs = benchmarking.RUNS,
    configs: Configs = CONFIGS,
    fresh: Fresh = False,
) -> None:
    """Train PPO and compare it with the other policies on the same evaluation episodes."""
    job = load_task(task)
    check_names(job, listed(policies))
    paths = [trained_agent(job, seed, steps, runs, fresh) for seed in range(agents)]
    learned = [LearnedPolicy(path, "ppo" if agents == 1 else f"ppo_{seed}") for seed, path in enumerate(paths)]
    benchmarking.benchmark(
        job, listed(policies), learned=learned, episodes=episodes, folder=runs, configs=configs, fresh=fresh
    )


@app.command(epilog="Example: python -m agents scores --task power_limited")
def scores(
    task: Annotated[str | None, typer.Option(help="Name of the task, or wen; all by default.")] = None,
    episodes: Annotated[
        int, typer.Option(min=2, help="Evaluation episodes; planners plan half as many.")
    ] = scoring.EPISODES,
    compare: Annotated[bool, typer.Option("--compare", help="Only set the tables beside the published costs.")] = False,
    runs: Runs = benchmarking.RUNS,
    configs: Configs = CONFIGS,
    results: Annotated[Path, typer.Option(help="Folder of the tables.")] = scoring.RESULTS,
    data: Annotated[Path, typer.Option(help="File of the reference scores.")] = SCORES,
) -> None:
    """Measure the reference scores: tune what is missing, run every policy, write the tables."""
    names = scoring.scored_names() if task is None else [task]
    if compare:
        Console(width=None if sys.stdout.isatty() else benchmarking.WIDTH).print(
            comparison_table(compare_published(names, results))
        )
        return
    for name in names:
        if name == scoring.WEN:
            scoring.score_wen(data)
        else:
            scoring.score(name, episodes=episodes, results=results, runs=runs, configs=configs, data=data)


@app.command(epilog="Example: python -m agents video --left adaptive_rule --right E8D0 --output demo.gif")
def video(
    left: Annotated[str, typer.Option(help="A policy, the .zip file of a trained agent, or a constant: E8D0.")],
    right: Annotated[str, typer.Option(help="Likewise.")],
    output: Annotated[Path, typer.Option(help="The .gif file to write.")],
    task: TaskName = "power_limited",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the episode.")] = SPLITS["evaluation"],
    pictures: Annotated[int, typer.Option(min=1, help="Pictures of each block.")] = Film().frames,
    configs: Configs = CONFIGS,
) -> None:
    """Film two policies, side by side, on the same episode."""
    job = load_task(task)
    policies = [policy_of(name, job, configs) for name in (left, right)]
    size = record(policies, job, seed, output, Film(frames=pictures))
    print(f"{output}: {size / 1e6:.1f} MB")


def listed(names: str | None) -> list[str] | None:
    """The names in a comma-separated list."""
    return None if names is None else [name.strip() for name in names.split(",")]


def main() -> None:
    """Run the command; a user's mistake, or a file that cannot be written, is one sentence and exit status 2."""
    try:
        app(prog_name="python -m agents")
    except (GrindError, OSError) as error:
        print(f"agents: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()
