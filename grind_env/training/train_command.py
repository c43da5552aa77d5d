"""The command `grind train`: train an agent for a task or a part program, and compare it with untrained policies."""

import re
import shlex
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grind_env.file_arguments import PROBLEM, Writes
from grind_env.shop.commands.arguments import BATCH, FirstVariables, JobFile

if TYPE_CHECKING:
    from grind_env.envs.simulation import Simulation
    from grind_env.policies.problem_lookup import Problem
    from grind_env.policies.scoring import Judgement

JUDGES = "held-out-laws"  #: set of machines on which agents are judged
NOT_RECOMMENDED = 3  #: exit status for an agent that is not recommended


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="grind train plate.nc --parts 60\ngrind train rush --seed 1 -o rush.safetensors")(train)


def train(
    task: Annotated[
        str, typer.Argument(metavar="TASK|PROGRAM", help="Task (name, id, .toml file) or part program."), PROBLEM
    ],
    job: JobFile = None,
    parts: Annotated[int | None, typer.Option(min=1, help=f"Parts that a program grinds; default {BATCH}.")] = None,
    variables: FirstVariables = None,
    plant: Annotated[
        str, typer.Option(help="Training machines: public, laws, training (half of each) or model.")
    ] = "training",
    seed: Annotated[int, typer.Option(min=0, help="Seed of the training.")] = 0,
    steps: Annotated[int, typer.Option(min=10_000, help="Environment steps.")] = 1_000_000,
    memory: Annotated[str, typer.Option(help="What it remembers: none, stack, gru or belief.")] = "gru",
    max_scrap: Annotated[float | None, typer.Option(help="Largest share of scrap, as 0.005; default no limit.")] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes, each on a new machine.")] = 128,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Agent file; default PROGRAM or TASK.safetensors."),
        Writes(),
    ] = None,
) -> None:
    """Train an agent for a task or a part program in about two minutes.

    The agent is trained on simulated machines whose physics differs from the model, and evaluated on others
    (docs/howto/train.md). To resume a killed training, repeat the command. Exit status 3: the agent is not
    recommended.
    """
    from grind_env.errors import GrindError
    from grind_env.message_text import printable, quoted
    from grind_env.optional_libraries import needing
    from grind_env.plants.plant_names import MODEL
    from grind_env.policies.evaluation import episode_seeds
    from grind_env.policies.learned.saved import SUFFIX, write_policy
    from grind_env.policies.nominal_model import machines_name, model_of, on, training_machines
    from grind_env.policies.problem_lookup import JOB
    from grind_env.policies.scoring import evaluate
    from grind_env.terminal_output import progress

    with needing("train", "grind train needs"):
        from grind_env.training import gru_ppo
        from grind_env.training.checkpoint import find_checkpoint
    from grind_env.training.baselines import rivals

    memories = [each for each in gru_ppo.SEEN if each != "state"]  # no real machine measures the state
    if memory not in memories:
        raise GrindError(f"--memory is {quoted(memory)}, but must be one of {', '.join(memories)}")
    if max_scrap is not None and not 0.0 < max_scrap < 1.0:
        raise GrindError(f"--max-scrap is {max_scrap:g}, but must be a share between 0 and 1")
    if seed > gru_ppo.LAST_SEED:
        raise GrindError(f"--seed is {seed}, but must be at most {gru_ppo.LAST_SEED}")
    episode_seeds("validation", episodes)
    named = _problem(task, None if job is None else str(job), parts, variables)
    machines = training_machines(named, None if plant == MODEL.name else plant)
    path = _usual_file(task, named) if output is None else output
    if path.suffix != SUFFIX:
        raise GrindError(f"--output is {quoted(str(path))}, but agents are {SUFFIX} files: name {path.stem}{SUFFIX}")
    settings = gru_ppo.Settings(memory=memory, steps=steps, budget=max_scrap)
    problem = gru_ppo.shown(machines, memory)
    if not problem.simulation().compiled:
        slow = f"the control executes {named.name} step by step: {steps:,} blocks may take hours"
        print(printable(f"{slow}; fewer --steps are quicker, and learn less"), file=sys.stderr)
    checkpoint = find_checkpoint((problem, settings, seed, *_contents(problem.simulation())))
    if checkpoint.path.is_file():
        print(printable(f"{path}: resuming the interrupted training"), file=sys.stderr)
    begin = time.process_time()
    with progress(steps) as advance:
        agent, scale = gru_ppo.train(problem, settings, seed, partial(advance, "steps"), checkpoint)
    policy, form = gru_ppo.policy_of(agent, scale, problem, memory), gru_ppo.form_of(memory)
    policy.machines = machines_name(problem.simulation())
    beside = {"settings": asdict(settings) | {"seed": seed}, "machines": policy.machines}
    write_policy(path, policy.actor, model_of(problem), policy.name, form, beside)
    checkpoint.remove()
    seconds = time.process_time() - begin
    judges = gru_ppo.shown(on(named, JUDGES), memory)
    with progress(4 * problem.simulation().task.blocks) as advance:
        judged = [
            evaluate(plays, judges, seeds="validation", episodes=episodes, advance=partial(advance, "steps"))
            for plays in (policy, *rivals(named, on(named, JUDGES)))
        ]
    recommended, verdict = _verdict(*judged)
    lines = [f"{path}: {verdict}", *map(str, judged), f"{path}: trained in {seconds:.0f} CPU-seconds"]
    print(printable("\n".join(lines)))
    if named.id == JOB:
        with_agent = ["--policy", str(path)] if recommended else []
        words = shlex.join(["grind", "advise", task, *with_agent])
        print(printable(f"next: {words}, with the same --job, --parts and --set"))
    if not recommended:
        raise typer.Exit(NOT_RECOMMENDED)


def _problem(task: str, job: str | None, parts: int | None, variables: Sequence[str] | None) -> "Problem":
    """Return the named problem; a part program without a number of parts is a batch, as for `grind advise`.

    Raises:
        GrindError: there is no such problem, or a task has options of part programs.
    """
    from grind_env.errors import GrindError
    from grind_env.policies.problem_lookup import JOB, find_problem

    problem = find_problem(task, job, 1 if parts is None else parts)
    if parts is None and problem.id == JOB:
        problem = find_problem(task, job, BATCH)
    if not variables:
        return problem
    if problem.id != JOB:
        raise GrindError(f"--set is of a part program, and {problem.name} is none: leave it out")
    return replace(problem, arguments=(*problem.arguments, ("variables", ",".join(variables))))


def _contents(simulation: "Simulation") -> "Iterator[tuple[str, str | float]]":
    """Yield all inputs of a training by name: inputs of the agent and, for a job, plant, wheel and uncertainty."""
    from grind_env.envs.input_comparison import inputs_of, named

    yield from inputs_of(simulation).items()
    yield from (each for each in named(getattr(simulation, "job", None)) if isinstance(each[1], str | float | int))


def _usual_file(task: str, problem: "Problem") -> Path:
    """Return the default file of the agent: beside the part program, or in the current folder.

    Raises:
        FileError: the file cannot be written, or a file that is no agent would be replaced.
    """
    from grind_env.files import beside
    from grind_env.output_checks import FileKind, Target, check_targets
    from grind_env.policies.learned.saved import ENTRY, SUFFIX
    from grind_env.policies.problem_lookup import JOB

    path = beside(Path(task), SUFFIX) if problem.id == JOB else Path(problem.name + SUFFIX)
    agent = FileKind("trained agent", re.compile(rb'.{8}\{"__metadata__":\{"' + ENTRY.encode(), re.DOTALL).match)
    check_targets([Target(path=path, option="--output", replaceable=agent)])
    return path


def _verdict(found: "Judgement", adviser: "Judgement", *others: "Judgement") -> tuple[bool, str]:
    """Return whether an agent is recommended, and why, from policies on the same episodes.

    A recommended agent is significantly cheaper than the adviser and no dearer than any other policy.
    """
    import numpy as np

    from grind_env.policies.score_statistics import bootstrap, cost_per_good_part

    run, beside = found.evaluation, adviser.evaluation
    # the ratio is NaN where neither policy makes a good part
    with np.errstate(invalid="ignore"):
        saved = bootstrap(
            lambda cost, good, least, best: 1.0 - cost_per_good_part(cost, good) / cost_per_good_part(least, best),
            *(run.cost, run.good, beside.cost, beside.good),
        )
    costs = [each.evaluation.cost_per_good_part.value for each in (adviser, *others)]
    best, own = (adviser, *others)[int(np.argmin(costs))], run.cost_per_good_part.value
    if saved.low > 0.0 and own <= min(costs):
        low, high = (f"{100.0 * end:.0f}" for end in (saved.low, saved.high))
        less = (
            f"a good part costs {100.0 * saved.value:.0f} % less than with {adviser.policy} (95 % CI {low} to {high})"
        )
        return True, f"recommended: {less} on machines of {found.plant}"
    if not np.isfinite(min(costs)):
        return False, "not recommended: no policy makes a good part: check program and job with `grind run`"
    chance = " (may be chance)" if own < min(costs) else ""
    text = f"{own:.2f} $ with the agent{chance}" if np.isfinite(own) else "the agent makes none"
    text = f"a good part costs {min(costs):.2f} $ with {best.policy}, {text}"
    return False, f"not recommended: {text}, on machines of {found.plant}"
