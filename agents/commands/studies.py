"""Commands of `python -m agents` that are studies: one command each, all with the same options."""

from collections.abc import Callable
from importlib import import_module
from typing import Annotated, NamedTuple

import typer

from agents.benchmark.plan import CORE, FLAGSHIP, chosen_problems
from agents.budgets import GAP_EPISODES, SCORE_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Tasks
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.commands import Configs, JobFile, Parts
from grind_env.envs.names import OTHERS, task_names
from grind_env.errors import GrindError
from grind_env.terminal import table_console


class StudyCommand(NamedTuple):
    """A study as a command.

    Attributes:
        module: whose `study(asked)` makes it.
        help: what it asks, and what must be known of it.
        example: options of the example.
        tasks: by default.
        episodes: by default.
        seeds: trainings by default; 0 where nothing is trained.
        steps: of a training by default.
    """

    module: str
    help: str
    example: str
    tasks: str = ",".join(CORE)
    episodes: int = 128
    seeds: int = 0
    steps: int = 0


COMMANDS = {
    "splits": StudyCommand(
        "agents.splits",
        "Compare rules, planners and agents on contexts that no training has seen, and on some beyond the task.",
        "--task power_limited",
    ),
    "safety": StudyCommand(
        "agents.safety.study",
        "What PPO with a GRU earns and violates, without and with a budget of scrap, beside a guarded rule.\n\n"
        "Power, size, Ra and burning are counted block by block, scrap part by part.",
        "--tasks power_limited,rush --seeds 3",
        episodes=256,
        seeds=3,
        steps=600_000,
    ),
    "recipe": StudyCommand(
        "agents.recipe",
        "Run the training recipe of the docs on several seeds, with the belief and without.\n\n"
        "The table keeps what it has of other tasks.",
        "--tasks core --seeds 5",
        tasks=FLAGSHIP,
        seeds=5,
        steps=1_000_000,
    ),
    "scores": StudyCommand(
        "agents.reference.scores",
        "Measure the reference scores: tune what is missing, run every policy, write the tables.",
        "--task power_limited",
        tasks=",".join(name for name in (*task_names(), *OTHERS) if name != "job"),
        episodes=SCORE_EPISODES,
    ),
    "gaps": StudyCommand(
        "agents.reference.gap_table",
        "What it is worth to adapt E, D or both: tune what is missing, run every policy.\n\n"
        "The fixed plan is the best one without sensors. The planner knows the state of the wheel; hindsight knows the "
        "future, too.",
        "--tasks power_limited,rush",
        tasks=",".join(name for name in (*task_names(), *OTHERS) if name != "job"),
        episodes=GAP_EPISODES,
    ),
}


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for name, of in COMMANDS.items():
        app.command(name=name, help=of.help, epilog=f"Example: python -m agents {name} {of.example}")(command(name, of))


def command(name: str, of: StudyCommand) -> Callable[..., None]:
    """Return the function of a command."""

    def study(
        tasks: Tasks = None,
        job: JobFile = None,
        parts: Parts = 1,
        episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = of.episodes,
        seeds: Annotated[
            int | None, typer.Option(min=1, help=f"Trainings of each agent, from seed 0; {of.seeds} by default.")
        ] = None,
        steps: Annotated[
            int | None, typer.Option(min=1, help=f"Environment steps of a training; {of.steps} by default.")
        ] = None,
        jobs: Jobs = 2,
        ray: Ray = None,
        runs: Runs = RUNS,
        configs: Configs = None,
        results: Results = None,
        fresh: Fresh = False,
    ) -> None:
        from agents.commands.asked import StudyOptions

        if not of.seeds and (seeds, steps) != (None, None):
            raise GrindError(f"{name} trains nothing: leave out --seeds and --steps")
        folder = results or (runs if tasks else RESULTS)
        options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
        asked = StudyOptions(
            problems=chosen_problems(tasks or of.tasks, job, parts),
            episodes=episodes,
            seeds=seeds or of.seeds,
            steps=steps or of.steps,
            configs=configs,
            results=folder,
            options=options,
        )
        with going_on(fresh):
            import_module(of.module).study(asked).publish_to(folder, options)

    return study
