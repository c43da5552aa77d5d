"""The commands of `grind` that run policies: `evaluate`, `verify` and `play`."""

import json
import re
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grind_env.file_arguments import CONFIGS, FILE, JOB, PROBLEM, Writes
from grind_env.output_checks import FileKind
from grind_env.shop.commands.arguments import CsvFile, OtherPart, Plant
from grind_env.terminal_output import progress

if TYPE_CHECKING:
    from grind_env.envs.simulation import Simulation
    from grind_env.policies.policy import Policy

NamedProblem = Annotated[
    str, typer.Option("--task", "--env", "--program", help="Task (name, id, .toml file) or part program."), PROBLEM
]
JobFile = Annotated[str | None, typer.Option(help="Job file of a program; default PROGRAM with .toml."), JOB]
Parts = Annotated[int, typer.Option(min=1, help="Parts that a program grinds in an episode.")]
NamedPolicy = Annotated[
    str | None,
    typer.Option(help="Policy (docs/howto/evaluate.md), agent file, E8000D0 (mm/min), module:name; default plain_gru."),
    FILE,
]
Configs = Annotated[
    Path | None, typer.Option("--parameters", help="Folder of tuned parameters; default bundled."), CONFIGS
]
Trust = Annotated[
    bool, typer.Option("--trust", help="Load a .zip of Stable-Baselines3, which can run its author's code.")
]
FALSE = 1  #: exit status of `grind verify` if a row does not hold
Split = Annotated[str, typer.Option(help="Drawn contexts: all, inner, interpolation, extrapolation.")]

#: first line of the job that is written beside a program
PLAYED = "# Written by `grind play`, and replaced when it is written again: change a copy of it.\n"
PLAYED_JOB = FileKind("job that `grind play` has written", re.compile(re.escape(PLAYED.encode())).match)


def evaluate(
    ctx: typer.Context,
    env: NamedProblem = "power_limited",
    policy: NamedPolicy = None,
    job: JobFile = None,
    parts: Parts = 1,
    episodes: Annotated[
        int | None, typer.Option(min=2, help="Number of episodes; default 64, with --core 256.")
    ] = None,
    core: Annotated[bool, typer.Option("--core", help="Evaluate all core tasks, beside published policies.")] = False,
    seeds: Annotated[str | None, typer.Option(help="Seeds: training, validation or evaluation (default).")] = None,
    split: Split = "all",
    first_seed: Annotated[int | None, typer.Option(min=0, help="First of your own seeds, instead of --seeds.")] = None,
    plant: Plant = None,
    model: Annotated[str | None, typer.Option(help="Machine that planners assume; default: the task's.")] = None,
    configs: Configs = None,
    trust: Trust = False,
    other_part: OtherPart = False,
    submit: Annotated[
        Path | None, typer.Option(help="Write a row for `grind verify` to this .json file."), Writes()
    ] = None,
    csv: CsvFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Evaluate a policy: cost per good part and score, with 95 % CI.

    Score 0: the best fixed plan; 100: a planner that knows all future lots. With --plant only costs are printed.
    Details: docs/howto/evaluate.md.
    """
    from grind_env.errors import GrindError
    from grind_env.files import write_csv
    from grind_env.message_text import printable
    from grind_env.policies.policy_lookup import usual_name
    from grind_env.policies.problem_lookup import find_problem
    from grind_env.policies.scoring import evaluate as judge
    from grind_env.policies.submitted_rows import policy_file, row_of, write_rows

    if submit is not None and configs is not None:
        raise GrindError("a row names the parameters of the package: leave out --parameters or --submit")
    if submit is not None and policy is not None:
        policy_file(policy)  # a policy that cannot be submitted is refused before the evaluation
    if core:
        for name in ("env", "job", "parts", "seeds", "split", "first_seed", "plant", "model", "other_part"):
            if (source := ctx.get_parameter_source(name)) is None or source.name != "DEFAULT":
                option = "task" if name == "env" else name.replace("_", "-")
                raise GrindError(f"--core says which episodes of which tasks are ground: leave out --{option}")
        _evaluate_core(policy, episodes, configs, trust, submit, csv, as_json)
        return
    problem = find_problem(env, job, parts)
    chosen = _policy(policy, problem.simulation(), configs, trust, other_part)
    with progress(problem.simulation().task.blocks) as advance:
        found = judge(
            chosen,
            problem,
            seeds=seeds,
            split=split,
            episodes=64 if episodes is None else episodes,
            first_seed=first_seed,
            plant=plant,
            model=model,
            advance=partial(advance, "steps"),
        )
    if submit is not None:
        write_rows(submit, [row_of(found, problem, policy or usual_name(problem.simulation()))])
    if csv is not None:
        write_csv(csv, found.episodes().plain())
    if as_json:
        print(json.dumps({"env": problem.id, "name": problem.name, **found.numbers()}))
    else:
        print(printable(str(found)))


def _evaluate_core(
    text: str | None,
    episodes: int | None,
    configs: Path | None,
    trust: bool,
    submit: Path | None,
    csv: Path | None,
    as_json: bool,
) -> None:
    from grind_env.envs.task_names import CORE
    from grind_env.files import write_csv
    from grind_env.message_text import printable
    from grind_env.policies.core_scores import AGENT, SAID, evaluate_core
    from grind_env.policies.problem_lookup import find_problem
    from grind_env.policies.submitted_rows import row_of, write_rows
    from grind_env.score_scale import EPISODES
    from grind_env.terminal_output import table_console

    begin = time.monotonic()
    problems = {task: find_problem(task) for task in CORE}
    names = {task: (text or AGENT).replace("{task}", task) for task in CORE}
    policies = {task: _policy(names[task], each.simulation(), configs, trust, False) for task, each in problems.items()}
    steps = 2 * sum(each.simulation().task.blocks for each in problems.values())
    with progress(steps) as advance:
        found = evaluate_core(policies, episodes=episodes or EPISODES, advance=partial(advance, "steps"))
    if submit is not None:
        write_rows(submit, [row_of(found.judgements[task], problems[task], names[task]) for task in CORE])
    if csv is not None:
        write_csv(csv, found.table().plain())
    if as_json:
        print(json.dumps(found.numbers()))
        return
    found.table().print(table_console())
    seconds = time.monotonic() - begin
    print(printable(f"{SAID}\n{len(CORE)} tasks, {episodes or EPISODES} episodes each, in {seconds:.0f} s"))


def verify(
    row: Annotated[Path, typer.Argument(metavar="ROW", help="File that `grind evaluate --submit` wrote."), FILE],
    policy: Annotated[
        str | None, typer.Option(help="Agent file or module:name of the row's policy; its code is run."), FILE
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Draw new episodes from this number of 20 or more digits.")
    ] = None,
    episodes: Annotated[
        int | None, typer.Option(min=2, max=10_000, help="Episodes to draw; default as many as in the row.")
    ] = None,
) -> None:
    """Re-run a submitted result and compare the mean cost.

    With --seed, the mean cost of new episodes must lie in the 95 % prediction interval of the row.
    Exit status 0: the row holds; 1: it does not; 2: it cannot be run.
    """
    from grind_env.errors import GrindError
    from grind_env.files import shown
    from grind_env.message_text import printable, shortened
    from grind_env.policies.problem_lookup import find_problem
    from grind_env.policies.submitted_rows import read_rows
    from grind_env.policies.submitted_rows import verify as verified

    if episodes is not None and seed is None:
        raise GrindError("--episodes is of those that are drawn from --seed: give it, too, or leave --episodes out")
    all_hold = True
    for read in read_rows(row):
        named = None if policy is None else policy.replace("{task}", find_problem(read.id).name)
        try:
            holds, found = verified(read, named, seed=seed, episodes=episodes)
        except GrindError as error:
            raise GrindError(f"{shown(row)}: {error}") from None
        print(printable(f"{shown(row)}: {shortened(read.policy)} in {read.id}\n{found}"))
        all_hold &= holds
    if not all_hold:
        raise typer.Exit(FALSE)


def play(
    env: NamedProblem = "power_limited",
    policy: NamedPolicy = None,
    job: JobFile = None,
    parts: Parts = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed; default the first evaluation seed.")] = 2_000_000,
    split: Split = "all",
    plant: Plant = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Write the part program to this .nc file and its job beside it."),
        Writes(beside={".toml": PLAYED_JOB}),
    ] = None,
    window: Annotated[bool, typer.Option(help="Show a window, or text in the terminal.")] = True,
    trust: Trust = False,
    other_part: OtherPart = False,
    configs: Configs = None,
) -> None:
    """Show an episode, its cost and its part program (G-code).

    With --output, `grind run` on the written program and job repeats the episode.
    """
    from grind_env.files import write_atomically
    from grind_env.machine.job.job_writer import job_text
    from grind_env.message_text import printable
    from grind_env.policies.nominal_model import on
    from grind_env.policies.played_episodes import play as play_episode
    from grind_env.policies.problem_lookup import find_problem

    problem = find_problem(env, job, parts)
    plays = _policy(policy, problem.simulation(), configs, trust, other_part)
    shown = None if output is not None else "human" if window else "ansi"
    played = play_episode(plays, problem if plant is None else on(problem, plant), seed, split, shown)
    if output is None:
        print(printable(played.program.replace("\r\n", "\n")))
    else:
        write_atomically(output, lambda path: path.write_text(played.program, encoding="utf-8"))
        job_beside = output.with_suffix(".toml")
        write_atomically(job_beside, lambda path: path.write_text(PLAYED + job_text(played.job), encoding="utf-8"))
        if played.requests:
            # all digits: with a time rounded to ms the dress could come after another reversal of the table
            asked = " ".join(f"--dress-at {seconds}" for seconds in played.requests)
            print(printable(f"it is the same with the dresses that the operator asks for: grind run {output} {asked}"))
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
    from grind_env.message_text import printable
    from grind_env.policies.policy_lookup import Unzip, agent_of, chosen_policy

    unzip: Unzip | None = None
    if trust:
        from grind_env.sb3 import load_zip

        unzip = load_zip
    policy = chosen_policy(text, simulation, configs, unzip, other_part=other_part)
    if (agent := agent_of(policy)) is not None and agent.remark:
        print(printable(agent.remark), file=sys.stderr)
    return policy
