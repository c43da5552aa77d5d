"""Study commands of `python -m agents`: common options, and the options of each study."""

import inspect
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from agents.benchmark.plan import EPISODES, FLAGSHIP, chosen_problems
from agents.command_defaults import GAP_EPISODES, STUDY_EPISODES, STUDY_MACHINES
from agents.commands.options import TASKS, Tasks, going_on
from agents.evaluation_cache import RESULTS, RUNS
from agents.study import Fresh, Hours, Jobs, Options, Ray, Results, Runs, StudyOptions
from grind_env.envs.task_names import CORE, shipped_names
from grind_env.errors import GrindError
from grind_env.file_arguments import FILE, PROBLEM, Reads, Writes
from grind_env.policy_commands import Configs, JobFile, Parts
from grind_env.score_scale import EPISODES as SCORE_EPISODES
from grind_env.terminal_output import table_console

DRESSES = RESULTS / "dress_study"  #: folder of the tables and pictures of the dress study


def plants(
    family: Annotated[
        list[str] | None, typer.Option("--family", help="Family of machines or model; repeatable; default all.")
    ] = None,
    tasks: Annotated[
        str | None,
        typer.Option(*TASKS, help="plate, rail, die or part programs, with commas between; default these three."),
        PROBLEM,
    ] = None,
    question: Annotated[
        list[str] | None,
        typer.Option("--question", help="calibrate, optimise, advise, robust; repeatable; default all."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Machines of each family.")] = STUDY_MACHINES,
    episodes: Annotated[int, typer.Option(min=1, help="Batches of 60 parts a machine.")] = 1,
) -> None:
    """Options of plants."""


def track(
    machines: Annotated[
        list[str] | None, typer.Option(help="Machine by name; repeatable; default 20 held-out.")
    ] = None,
    adapters: Annotated[
        list[str] | None, typer.Option(help="Policy, file or module:Class; repeatable; default all."), FILE
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Runs on each machine.")] = 4,
    submit: Annotated[
        Path | None, typer.Option(help="Write a row for `grind verify` to this .json file."), Writes()
    ] = None,
) -> None:
    """Options of track."""


def replicate(
    first: Annotated[
        list[int] | None,
        typer.Option("--first-seed", min=0, help="First seed of a set; repeatable; default three sets."),
    ] = None,
    published: Annotated[
        Path,
        typer.Option(help="Folder of the published results.", show_default="agents/results"),
        Reads(within="benchmark.parquet"),
    ] = RESULTS,
) -> None:
    """Options of replicate."""


class StudyCommand(NamedTuple):
    """Command of a study: the module whose `study(asked, **own)` makes the study, help, example and defaults.

    The parameters of the function `own` are the command's own options. `without` names missing common options.
    `free` names own options that do not choose trials; a choice of trials becomes part of the cache folder.
    """

    module: str
    help: str
    example: str
    tasks: str | None = ",".join(CORE)
    episodes: int = 128
    seeds: int = 0
    steps: int = 0
    own: Callable[..., None] = lambda: None
    without: tuple[str, ...] = ()
    free: tuple[str, ...] = ()
    folder: Path = RESULTS


COMMANDS = {
    "splits": StudyCommand(
        "agents.split_study",
        "Compare policies on contexts that were not in training.",
        "--task power_limited",
    ),
    "safety": StudyCommand(
        "agents.safety.page",
        "Measure cost and violations of agents with a scrap limit.\n\n"
        "plain_gru, with and without a multiplier, beside rules. Power, size, Ra and burn are counted by block, scrap"
        " by part.",
        "--tasks power_limited,rush --seeds 3",
        episodes=256,
        seeds=3,
        steps=1_000_000,
    ),
    "recipe": StudyCommand(
        "agents.training_recipe_study",
        "Run the training recipe of the docs on several seeds.\n\nRows of other tasks stay in the table.",
        "--tasks core --seeds 5",
        tasks=FLAGSHIP,
        seeds=10,
        steps=1_000_000,
    ),
    "scores": StudyCommand(
        "agents.reference.score_study",
        "Measure all policies, and the costs of scores 0 and 100.\n\nUntuned policies are tuned first.",
        "--task power_limited",
        tasks=",".join(shipped_names()),
        episodes=SCORE_EPISODES,
    ),
    "gaps": StudyCommand(
        "agents.reference.adaptation_gaps",
        "Measure the value of adapting E, D or both.\n\n"
        "The fixed plan needs no sensors; the planner knows the wheel state; hindsight also knows the future.",
        "--tasks power_limited,rush",
        tasks="core",
        episodes=GAP_EPISODES,
    ),
    "plants": StudyCommand(
        "agents.plants.page",
        "Test calibrate, optimise and advise on out-of-model machines.\n\n"
        "The families bursts and graded were not used in any tuning. Rows of other questions stay in the tables.",
        "--family meter --seeds 1 --tasks plate",
        tasks=None,
        own=plants,
        without=("parts", "steps", "configs"),
    ),
    "track": StudyCommand(
        "agents.track.study",
        "Measure what policies gain by learning on held-out machines.\n\n"
        "600 blocks on each machine; all count. A policy may learn after each shift of 60 blocks.",
        "--machines public:1 --adapters my_module:Class",
        tasks=None,
        own=track,
        without=("tasks", "job", "parts", "episodes", "steps", "configs"),
        free=("submit",),
    ),
    "dress-study": StudyCommand(
        "agents.dressing.trials",
        "Measure cost over dress interval, lead, depth and passes.",
        "--task power_limited",
        tasks="core",
        episodes=STUDY_EPISODES,
        without=("seeds", "steps", "configs"),
        free=("tasks",),
        folder=DRESSES,
    ),
    "intervals": StudyCommand(
        "agents.dressing.interval_sensitivity",
        "Measure how the best dress interval depends on model constants.\n\n"
        "Sweeps E and interval of two example programs with each constant at a low and a high value.",
        "--jobs 1",
        tasks=None,
        without=("tasks", "job", "parts", "episodes", "seeds", "steps", "configs"),
    ),
    "replicate": StudyCommand(
        "agents.benchmark.replication_study",
        "Re-run published results of the benchmark on new seeds.\n\n"
        "The new mean costs must lie in the 95 % prediction intervals of the published rows.",
        "--task rush --first-seed 7000000 --episodes 64",
        tasks=None,
        episodes=EPISODES,
        own=replicate,
        without=("seeds", "steps"),
    ),
}


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for name, of in COMMANDS.items():
        app.command(name=name, help=of.help, epilog=f"python -m agents {name}\npython -m agents {name} {of.example}")(
            command(name, of)
        )


def command(name: str, of: StudyCommand) -> Callable[..., None]:
    """Return the function of a command."""

    def common(
        tasks: Tasks = None,
        job: JobFile = None,
        parts: Parts = 1,
        episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = of.episodes,
        seeds: Annotated[int | None, typer.Option(min=1, help=f"Trainings of each agent; default {of.seeds}.")] = None,
        steps: Annotated[
            int | None, typer.Option(min=1, help=f"Environment steps of a training; default {of.steps}.")
        ] = None,
        jobs: Jobs = 2,
        ray: Ray = None,
        runs: Runs = RUNS,
        configs: Configs = None,
        results: Results = None,
        fresh: Fresh = False,
        hours: Hours = False,
    ) -> None: ...

    shared, own = (inspect.signature(function, eval_str=True).parameters for function in (common, of.own))
    taken = {key: each for key, each in {**shared, **own}.items() if key not in of.without}

    def study(**given: Any) -> None:
        usual = {key: each.default for key, each in shared.items()} | given
        if "seeds" not in own and not of.seeds and (usual["seeds"], usual["steps"]) != (None, None):
            raise GrindError(f"{name} trains nothing: leave out --seeds and --steps")
        runs, fresh, job, parts = (usual[key] for key in ("runs", "fresh", "job", "parts"))
        choices = {"tasks": shared["tasks"], **own}
        chosen = [key for key, each in choices.items() if given.get(key, each.default) != each.default]
        folder = usual["results"] or (runs if {*chosen} - {*of.free} else of.folder)
        found = {key: usual[key] for key in ("jobs", "ray", "runs", "fresh", "hours")}
        options = Options(**found, console=table_console())
        asked = StudyOptions(
            problems=() if of.tasks is None else chosen_problems(usual["tasks"] or of.tasks, job, parts),
            tasks=usual["tasks"],
            job=job,
            parts=parts,
            episodes=usual["episodes"],
            seeds=usual["seeds"] or of.seeds,
            steps=usual["steps"] or of.steps,
            configs=usual["configs"],
            results=folder,
            options=options,
        )
        with going_on(fresh):
            mine = {key: given[key] for key in own if key not in shared}
            import_module(of.module).study(asked, **mine).publish_to(folder, options)

    study.__signature__ = inspect.Signature([*taken.values()])  # type: ignore[attr-defined]
    study.__annotations__ = {key: each.annotation for key, each in taken.items()}
    return study
