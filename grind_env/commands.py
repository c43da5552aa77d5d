"""The commands of `grind` that run policies: `evaluate`, `verify` and `play`."""

import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grind_env.arguments import CONFIGS, FILE, JOB, PROBLEM, Writes
from grind_env.shop.commands.arguments import OtherPart
from grind_env.targets import Own
from grind_env.terminal import progress_bar

if TYPE_CHECKING:
    from grind_env.envs.simulation import Simulation
    from grind_env.policies.policy import Policy

NamedProblem = Annotated[
    str,
    typer.Option(
        "--env", "--task", "--program", help="An id, its task, a task file (.toml), or a part program (any other file)."
    ),
    PROBLEM,
]
JobFile = Annotated[str | None, typer.Option(help="Job file of a part program; its name with .toml by default."), JOB]
Parts = Annotated[int, typer.Option(min=1, help="How often a part program is run.")]
NamedPolicy = Annotated[
    str | None,
    typer.Option(
        help="A policy, the file of a trained agent, a constant: E8D0, or module:name for one of yours; after guarded: "
        "with a guard; by default the shipped one; robust is for other machines."
    ),
    FILE,
]
Configs = Annotated[
    Path | None,
    typer.Option(
        help="Folder of the tuned parameters of the scripted policies; by default the shipped ones, for files of "
        "yours runs/parameters."
    ),
    CONFIGS,
]
Trust = Annotated[
    bool, typer.Option("--trust", help="Load a .zip of Stable-Baselines3, which can run code of its author.")
]
Plant = Annotated[
    str | None,
    typer.Option(
        help="Machine that is not the model: meter:7, foreign:3+meter:7, held-out:5, public:5, module:name; meter or "
        "public is another one in every episode."
    ),
]
FALSE = 1
"""Exit status of a row that does not hold."""
Split = Annotated[
    str, typer.Option(help="Contexts: all, inner, interpolation between its ranges, or extrapolation beyond all.")
]

PLAYED = "# Written by `grind play`, and replaced when it is written again: change a copy of it.\n"
"""First line of the job that is written beside a program."""
PLAYED_JOB = Own("job that `grind play` has written", re.compile(re.escape(PLAYED.encode())).match)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command(epilog="Example: grind evaluate --env grind/Rush-v0 --policy adaptive_rule --episodes 64")(evaluate)
    app.command(epilog="Example: grind verify row.json --seed 31415926535897932384")(verify)
    app.command(epilog="Example: grind play --task power_limited --policy adaptive_rule --no-window")(play)


def evaluate(
    env: NamedProblem = "power_limited",
    policy: NamedPolicy = None,
    job: JobFile = None,
    parts: Parts = 1,
    episodes: Annotated[int, typer.Option(min=2, help="Number of episodes.")] = 64,
    seeds: Annotated[
        str | None, typer.Option(help="Seeds: training, validation or evaluation, which is the default.")
    ] = None,
    split: Split = "all",
    first_seed: Annotated[int | None, typer.Option(min=0, help="First of seeds of one's own instead.")] = None,
    plant: Plant = None,
    model: Annotated[
        str | None, typer.Option(help="The machine that the policy takes it for; by default the model.")
    ] = None,
    configs: Configs = None,
    trust: Trust = False,
    other_part: OtherPart = False,
    submit: Annotated[
        Path | None, typer.Option(help="Write a row to this .json file, which `grind verify` runs again."), Writes()
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run a policy through many episodes: cost per good part and score, with 95 % intervals.

    A score is of the same episodes as those of the best fixed plan and of the planner, 0 and 100. It is called unpaired
    where the episodes are others than those of the reference scores.

    With --plant another machine grinds than the one that planners, beliefs and experts hold, and there is no score: its
    0 and 100 are of the model.

    With --submit seeds, actions, costs and the policy itself are written down, with the texts of a program, job or task
    of yours and the source of a module that policy or plant name. A .zip of Stable-Baselines3 is not: such a row can
    only be replayed.
    """
    from grind_env.errors import printable
    from grind_env.policies.judging import evaluate as judge
    from grind_env.policies.naming import usual_name
    from grind_env.policies.problem import find_problem

    problem = find_problem(env, job, parts)
    chosen = _policy(policy, problem.simulation(), configs, trust, other_part)
    with progress_bar("steps", problem.simulation().most_steps) as advance:
        found = judge(
            chosen,
            problem,
            seeds=seeds,
            split=split,
            episodes=episodes,
            first_seed=first_seed,
            plant=plant,
            model=model,
            advance=advance,
        )
    if submit is not None:
        from grind_env.policies.rows.making import row_of
        from grind_env.policies.rows.row import write_row

        run, drawn = found.evaluation, range(found.first_seed, found.first_seed + episodes)
        text = usual_name(problem.simulation()) if policy is None else policy
        row = row_of(run, problem, drawn, chosen, text, configs, split=split, plant=found.plant, model=found.model)
        write_row(submit, row)
        if not row.says:
            print("the row carries no .zip, and can only be replayed: give a .safetensors file", file=sys.stderr)
    if as_json:
        print(json.dumps({"env": problem.id, "name": problem.name, **found.numbers()}))
    else:
        print(printable(str(found)))


def verify(
    row: Annotated[Path, typer.Argument(metavar="ROW", help="File that `grind evaluate --submit` wrote."), FILE],
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Run its policy, too, on episodes drawn from this number of 20 digits or more."),
    ] = None,
    episodes: Annotated[
        int | None, typer.Option(min=2, max=10_000, help="How many of these; by default as many as it has.")
    ] = None,
    trust: Annotated[
        bool, typer.Option("--trust", help="Run the modules in it, which can do whatever their author wrote.")
    ] = False,
) -> None:
    """Find out whether a row holds that somebody has submitted.

    Its actions are replayed: it is "replayed" if every episode costs what it says, to the bit. With --seed its policy
    is run, too, where nothing comes to it but what is measured, on episodes that nobody knew when the row was made. It
    is "measured-only" if their mean cost lies where the row predicts it, with 95 %: of fifteen good rows one misses.

    Exit status 0: it holds. 1: it does not hold. 2: it is no row, or cannot be run.
    """
    from grind_env.errors import GrindError, printable
    from grind_env.files import shown
    from grind_env.policies.rows.row import read_row
    from grind_env.policies.rows.verifying import verify as verified

    if episodes is not None and seed is None:
        raise GrindError("--episodes is of those that are drawn from --seed: give it, too, or leave --episodes out")
    read = read_row(row)
    try:
        verdict = verified(read, seed=seed, episodes=episodes, trust=trust)
    except GrindError as error:
        raise GrindError(f"{shown(row)}: {error}") from None
    print(printable(f"{shown(row)}: {read}\n{verdict.found}"))
    if not verdict.status:
        raise typer.Exit(FALSE)


def play(
    env: NamedProblem = "power_limited",
    policy: NamedPolicy = None,
    job: JobFile = None,
    parts: Parts = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the episode.")] = 2_000_000,
    split: Split = "all",
    plant: Plant = None,
    program: Annotated[
        Path | None,
        typer.Option(
            "--output", help="Write the part program to this .nc file, and its job beside it, instead of showing both."
        ),
        Writes(beside={".toml": PLAYED_JOB}),
    ] = None,
    window: Annotated[
        bool, typer.Option(help="A window where there is a screen; without, text in the terminal.")
    ] = True,
    trust: Trust = False,
    other_part: OtherPart = False,
    configs: Configs = None,
) -> None:
    """Show an episode, what it cost, and the part program that the policy wrote.

    With --output the job of the program is written beside it, with the wheel, the lots and the stocks of the episode:
    `grind run` of both shows the same parts. With --plant the job names the machine of the episode, too. A job of that
    name is replaced only if `grind play` has written it.
    """
    from grind_env.errors import printable
    from grind_env.files import write_atomically
    from grind_env.machine.job.text import job_text
    from grind_env.policies.held import on
    from grind_env.policies.play import play as play_episode
    from grind_env.policies.problem import find_problem

    problem = find_problem(env, job, parts)
    plays = _policy(policy, problem.simulation(), configs, trust, other_part)
    shown = None if program is not None else "human" if window else "ansi"
    played = play_episode(plays, problem if plant is None else on(problem, plant), seed, split, shown)
    if program is None:
        print(printable(played.program.replace("\r\n", "\n")))
    else:
        write_atomically(program, lambda path: path.write_text(played.program, encoding="utf-8"))
        job_beside = program.with_suffix(".toml")
        write_atomically(job_beside, lambda path: path.write_text(PLAYED + job_text(played.job), encoding="utf-8"))
        if played.requests:
            # to the last digit, for the table may have turned within the ms before
            asked = " ".join(f"--dress-at {seconds}" for seconds in played.requests)
            print(printable(f"it is the same with the dresses that the operator asks for: grind run {program} {asked}"))
    dull = f"; {played.handover:.2f} $ of it are for the dull wheel handed over, which no run of the program shows"
    on_plant = f", on {printable(played.job.plant)}" if played.job.plant else ""
    each = f", {played.cost / played.good:.3f} $ each" if played.good > 0.0 else ""
    print(
        f"{printable(plays.name)}, seed {seed}, split {split}{on_plant}: "
        f"{played.cost:.2f} $ for {played.good:.1f} good parts of {played.finished}{each};"
        f" {played.dresses} dress executions, {played.seconds / 3600.0:.2f} h on the machine"
        + (dull if played.handover >= 0.005 else "")
    )


def _policy(
    text: str | None, simulation: "Simulation", configs: Path | None, trust: bool, other_part: bool
) -> "Policy":
    from grind_env.errors import printable
    from grind_env.policies.naming import Unzip, agent_of, chosen_policy

    unzip: Unzip | None = None
    if trust:
        from grind_env.sb3 import load_zip

        unzip = load_zip
    policy = chosen_policy(text, simulation, configs, unzip, other_part=other_part)
    if (agent := agent_of(policy)) is not None and agent.remark:
        print(printable(agent.remark), file=sys.stderr)
    return policy
