"""Commands of `python -m agents` that are studies: one command each, all with the same options, some with more."""

import inspect
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from agents.benchmark.plan import CORE, EPISODES, FLAGSHIP, chosen_problems
from agents.budgets import GAP_EPISODES, SCORE_EPISODES, STUDY_EPISODES, STUDY_MACHINES, TRACK_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.options import Tasks, going_on
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.arguments import FILE, PROBLEM, Reads
from grind_env.commands import Configs, JobFile, Parts, Plant
from grind_env.envs.names import MODULE_NAMES, task_names
from grind_env.errors import GrindError
from grind_env.terminal import table_console

DRESSES = RESULTS / "dress_study"
"""Folder of the tables and pictures of the dress study."""


def plants(
    family: Annotated[
        list[str] | None, typer.Option("--family", help="Of machines, or `model`; may be repeated; all by default.")
    ] = None,
    tasks: Annotated[
        str | None,
        typer.Option(
            "--tasks",
            "--task",
            "--env",
            "--program",
            help="Part programs: plate, rail, die or files, separated by commas; these three by default.",
        ),
        PROBLEM,
    ] = None,
    question: Annotated[
        list[str] | None,
        typer.Option("--question", help="calibrate, optimise, advise or robust; may be repeated; all by default."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Machines of each family.")] = STUDY_MACHINES,
    episodes: Annotated[int, typer.Option(min=1, help="Batches of 60 parts that judge advice on a machine.")] = 1,
) -> None:
    """Options of plants."""


def track(
    machines: Annotated[
        list[str] | None,
        typer.Option("--machines", help="Their number, of held-out:1 on, or a name; may be repeated; 20 by default."),
    ] = None,
    adapters: Annotated[
        list[str] | None,
        typer.Option("--adapters", help="Name, policy, file or module:name; may be repeated; by default the headline."),
        FILE,
    ] = None,
    blocks: Annotated[
        str | None, typer.Option(help="Blocks on a machine when it is judged; 0,60,300,1200 by default.")
    ] = None,
    wide: Annotated[bool, typer.Option("--wide", help="More adapters, and WideRails on 8 machines.")] = False,
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each adapter on each machine.")] = 3,
) -> None:
    """Options of track."""


def replicate(
    first: Annotated[
        list[int] | None,
        typer.Option("--first", min=0, help="First seed of a set; may be repeated; three sets by default."),
    ] = None,
    published: Annotated[
        Path,
        typer.Option(help="Folder of benchmark.parquet, the results that are replicated."),
        Reads(within="benchmark.parquet"),
    ] = RESULTS,
) -> None:
    """Options of replicate."""


def dress_study(plant: Plant = None) -> None:
    """Options of dress-study."""


class StudyCommand(NamedTuple):
    """A study as a command: the module whose `study(asked, **own)` makes it, its help, example and defaults.

    `own` is a function whose parameters are options of its own, `without` names common options that it has not, and
    `free` those of its own that choose no trials: a choice of trials is written into the folder of the cache.
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
        "agents.splits",
        "Compare rules, planners and agents on contexts that no training has seen, and on some beyond the task.",
        "--task power_limited",
    ),
    "safety": StudyCommand(
        "agents.safety.page",
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
        tasks=",".join(name for name in (*task_names(), *MODULE_NAMES) if name != "job"),
        episodes=SCORE_EPISODES,
    ),
    "gaps": StudyCommand(
        "agents.reference.gaps",
        "What it is worth to adapt E, D or both: tune what is missing, run every policy.\n\n"
        "The fixed plan is the best one without sensors. The planner knows the state of the wheel; hindsight knows the "
        "future, too.",
        "--tasks power_limited,rush",
        tasks=",".join(name for name in (*task_names(), *MODULE_NAMES) if name != "job"),
        episodes=GAP_EPISODES,
    ),
    "plants": StudyCommand(
        "agents.plants.page",
        "How calibration, search and adviser hold on machines that are not the model: how far off, at what cost.\n\n"
        "The two families `bursts` and `graded` were kept out of all tuning of calibration and adviser. The tables "
        "keep the answers to other questions.",
        "--family meter --seeds 1 --tasks plate",
        tasks=None,
        own=plants,
        without=("parts", "steps", "configs"),
    ),
    "track": StudyCommand(
        "agents.track.study",
        "How fast, how safely and how well policies adapt to machines that are held out, from measurements alone.\n\n"
        "An adapter grinds shift after shift, and may change its policy after each; on the way episodes judge it.",
        "--machines public:1 --adapters bc --blocks 0,60 --seeds 1",
        tasks=None,
        episodes=TRACK_EPISODES,
        own=track,
        without=("steps", "configs"),
        free=("wide", "seeds"),
    ),
    "dress-study": StudyCommand(
        "agents.dressing.trials",
        "Cost against dress interval, dress lead, depth and passes, and what decides when to dress.\n\n"
        "With --plant on another machine, for which plans are chosen anew; policies that see measurements stay those "
        "of the model, and planners that see more hold the machine.",
        "--task power_limited",
        tasks="all",
        episodes=STUDY_EPISODES,
        own=dress_study,
        without=("seeds", "steps", "configs"),
        free=("plant", "tasks"),
        folder=DRESSES,
    ),
    "replicate": StudyCommand(
        "agents.benchmark.replications",
        "Re-run published results of the benchmark on new seeds, by which nothing was chosen.\n\n"
        "Policies of the results, by default of all tasks that have some, are run on other episodes, whose mean costs "
        "are to lie where the published rows have them with 95 %.",
        "--task rush --first 7000000 --episodes 64",
        tasks=None,
        episodes=EPISODES,
        own=replicate,
        without=("seeds", "steps"),
    ),
}


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for name, of in COMMANDS.items():
        app.command(name=name, help=of.help, epilog=f"python -m agents {name} {of.example}")(command(name, of))


def command(name: str, of: StudyCommand) -> Callable[..., None]:
    """Return the function of a command."""

    def common(
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
    ) -> None: ...

    shared, own = (inspect.signature(function, eval_str=True).parameters for function in (common, of.own))
    taken = {key: each for key, each in {**shared, **own}.items() if key not in of.without}

    def study(**given: Any) -> None:
        from agents.study import StudyOptions

        usual = {key: each.default for key, each in shared.items()} | given
        if "seeds" not in own and not of.seeds and (usual["seeds"], usual["steps"]) != (None, None):
            raise GrindError(f"{name} trains nothing: leave out --seeds and --steps")
        runs, fresh, job, parts = (usual[key] for key in ("runs", "fresh", "job", "parts"))
        chosen = [key for key, each in {"tasks": shared["tasks"], **own}.items() if given[key] != each.default]
        folder = usual["results"] or (runs if {*chosen} - {*of.free} else of.folder)
        options = Options(jobs=usual["jobs"], ray=usual["ray"], runs=runs, fresh=fresh, console=table_console())
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
