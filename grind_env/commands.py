"""The commands of `grind` that run policies: `evaluate`, `verify` and `play`."""

import json
import re
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grind_env.arguments import CONFIGS, FILE, JOB, PROBLEM, Writes
from grind_env.shop.commands.arguments import OtherPart
from grind_env.targets import Own
from grind_env.terminal import progress

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
        help="Machine that is not the model: meter:7, foreign:3+meter:7, held-out:5, laws:5, module:name; meter or "
        "laws is another one in every episode."
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
    app.command(epilog="grind evaluate --env grind/Rush-v0 --policy adaptive_rule --episodes 64")(evaluate)
    app.command(epilog="grind verify row.json --seed 31415926535897932384")(verify)
    app.command(epilog="grind play --task power_limited --policy adaptive_rule --no-window")(play)


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

    A score is 0 for the best fixed plan and 100 for the planner; on other episodes than theirs it is called unpaired,
    and on another machine (--plant) there is none. --submit writes the costs of all episodes and what ran.
    """
    from grind_env.errors import GrindError, printable
    from grind_env.policies.judging import evaluate as judge
    from grind_env.policies.naming import FALLBACK, usual_name
    from grind_env.policies.problem import find_problem

    if submit is not None and configs is not None:
        raise GrindError("a row names the parameters of the package: leave out --configs or --submit")
    problem = find_problem(env, job, parts)
    chosen = _policy(policy, problem.simulation(), configs, trust, other_part)
    with progress(problem.simulation().task.blocks) as advance:
        found = judge(
            chosen,
            problem,
            seeds=seeds,
            split=split,
            episodes=episodes,
            first_seed=first_seed,
            plant=plant,
            model=model,
            advance=partial(advance, "steps"),
        )
    if submit is not None:
        from grind_env.policies.rows import row_of, write_row

        usual = FALLBACK if usual_name(problem.simulation()) == FALLBACK else "shipped"
        write_row(submit, row_of(found, problem, policy or usual))
    if as_json:
        print(json.dumps({"env": problem.id, "name": problem.name, **found.numbers()}))
    else:
        print(printable(str(found)))


def verify(
    row: Annotated[Path, typer.Argument(metavar="ROW", help="File that `grind evaluate --submit` wrote."), FILE],
    policy: Annotated[
        str | None,
        typer.Option(help="Policy file or module:name, if the policy is not of the package; its code is run."),
        FILE,
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Number of 20 digits or more, from which seeds of other episodes are drawn."),
    ] = None,
    episodes: Annotated[
        int | None, typer.Option(min=2, max=10_000, help="Number of drawn episodes; by default as many as in the row.")
    ] = None,
) -> None:
    """Run the policy of a row again that somebody has submitted.

    The mean cost of its episodes must be what the row says; with --seed, that of episodes that nobody knew when the row
    was made must lie where the row predicts it, with 95 %.

    Exit status 0: the row holds. 1: it does not hold. 2: it is no row, or cannot be run.
    """
    from grind_env.errors import GrindError, printable, shortened
    from grind_env.files import shown
    from grind_env.policies.rows import read_row
    from grind_env.policies.rows import verify as verified

    if episodes is not None and seed is None:
        raise GrindError("--episodes is of those that are drawn from --seed: give it, too, or leave --episodes out")
    read = read_row(row)
    try:
        holds, found = verified(read, policy, seed=seed, episodes=episodes)
    except GrindError as error:
        raise GrindError(f"{shown(row)}: {error}") from None
    print(printable(f"{shown(row)}: {shortened(read.policy)} in {read.id}\n{found}"))
    if not holds:
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

    With --output the job of the program is written beside it: `grind run` of both shows the same parts.
    """
    from grind_env.errors import printable
    from grind_env.files import write_atomically
    from grind_env.machine.job.text import job_text
    from grind_env.policies.model_view import on
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
