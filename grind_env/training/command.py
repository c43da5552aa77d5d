"""The command `grind train`: an agent for a task or a part program, judged beside what plays without training."""

import re
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grind_env.arguments import PROBLEM, Writes
from grind_env.shop.commands.arguments import BATCH, FirstVariables, JobFile

if TYPE_CHECKING:
    from grind_env.envs.simulation import Simulation
    from grind_env.policies.judging import Judgement
    from grind_env.policies.policy import Policy
    from grind_env.policies.problem import Problem

RULE = "empirical_rule"
"""What plays a task on machines that are not the model without training or tuning."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: grind train plate.nc --parts 60")(train)


def train(
    task: Annotated[
        str, typer.Argument(metavar="TASK|PROGRAM", help="Task, id, task file (.toml), or part program."), PROBLEM
    ],
    job: JobFile = None,
    parts: Annotated[
        int | None, typer.Option(min=1, help=f"Parts of the batch, of a part program; {BATCH} if not given.")
    ] = None,
    variables: FirstVariables = None,
    plant: Annotated[
        str,
        typer.Option(
            help="Machines, one in every episode: public are of all families that differ from the model; model is it."
        ),
    ] = "public",
    seed: Annotated[int, typer.Option(min=0, help="Of the training.")] = 0,
    steps: Annotated[int, typer.Option(min=10_000, help="Blocks to learn from.")] = 1_000_000,
    memory: Annotated[
        str, typer.Option(help="What it remembers or is shown: none, stack, gru, belief, state.")
    ] = "gru",
    budget: Annotated[
        float | None, typer.Option(help="Share of parts that may be scrap; no limit if not given.")
    ] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Validation episodes to be judged on.")] = 128,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="File of the agent; PROGRAM, or the name of the task, with .safetensors if none."
        ),
        Writes(),
    ] = None,
) -> None:
    """Train an agent on machines that are not the model, in some two minutes, and judge it there.

    It is PPO with a GRU, which finds out from the readings what machine it grinds on; it holds no model. What it comes
    to stands beside what `grind advise` takes without it, or beside the empirical rule on a task. The file goes into
    `grind advise --policy`, `grind evaluate --policy` and `grind play --policy`, which need no PyTorch. If the training
    is killed, repeat the command to resume it.
    """
    from grind_env.errors import GrindError, printable, quoted
    from grind_env.extras import needing
    from grind_env.plants.names import MODEL
    from grind_env.policies.evaluation import episode_seeds
    from grind_env.policies.held import machines_name, model_of, training_machines
    from grind_env.policies.judging import evaluate
    from grind_env.policies.learned.saved import SUFFIX, write_policy
    from grind_env.terminal import progress_bar

    with needing("train", "grind train needs"):
        from grind_env.training import gru_ppo
        from grind_env.training.checkpoint import find_checkpoint

    if memory not in gru_ppo.SEEN:
        raise GrindError(f"--memory is {quoted(memory)}, but must be one of {', '.join(gru_ppo.SEEN)}")
    if budget is not None and not 0.0 < budget < 1.0:
        raise GrindError(f"--budget is {budget:g}, but must be a share between 0 and 1")
    if seed > gru_ppo.LAST_SEED:
        raise GrindError(f"--seed is {seed}, but must be at most {gru_ppo.LAST_SEED}")
    episode_seeds("validation", episodes)
    named = _problem(task, None if job is None else str(job), parts, variables)
    machines = training_machines(named, None if plant == MODEL.name else plant)
    path = _usual_file(task, named) if output is None else output
    if path.suffix != SUFFIX:
        raise GrindError(f"--output is {quoted(str(path))}, but agents are {SUFFIX} files: name {path.stem}{SUFFIX}")
    settings = gru_ppo.Settings(memory=memory, steps=steps, budget=budget)
    problem = gru_ppo.shown(machines, memory)
    if not problem.simulation().compiled:
        slow = f"the control executes {named.name} step by step: {steps:,} blocks may take hours"
        print(printable(f"{slow}; fewer --steps are quicker, and learn less"), file=sys.stderr)
    checkpoint = find_checkpoint((problem, settings, seed, *_contents(problem.simulation())))
    if checkpoint.path.is_file():
        print(printable(f"{path}: resuming the interrupted training"), file=sys.stderr)
    begin = time.process_time()
    with progress_bar("steps", steps) as advance:
        agent, scale = gru_ppo.train(problem, settings, seed, advance, checkpoint)
    policy, form = gru_ppo.policy_of(agent, scale, problem, memory), gru_ppo.form_of(memory)
    policy.machines = machines_name(problem.simulation())
    beside = {"settings": asdict(settings) | {"seed": seed}, "machines": policy.machines}
    write_policy(path, policy.actor, model_of(problem), policy.name, form, beside)
    checkpoint.remove()
    print(printable(f"{path}: trained in {time.process_time() - begin:.0f} CPU-seconds"))
    judged = []
    with progress_bar("steps", 2 * problem.simulation().most_steps) as advance:
        for plays in (policy, _untrained(named)):
            judged.append(evaluate(plays, problem, seeds="validation", episodes=episodes, advance=advance))
            print(printable(str(judged[-1])))
    print(_verdict(*judged))


def _problem(task: str, job: str | None, parts: int | None, variables: Sequence[str] | None) -> "Problem":
    """What is named; a part program for which no number of parts is given is a batch, as for `grind advise`.

    Raises:
        GrindError: there is no such problem, or what is said of a part program is said of another one.
    """
    from grind_env.errors import GrindError
    from grind_env.policies.problem import JOB, find_problem

    problem = find_problem(task, job, 1 if parts is None else parts)
    if parts is None and problem.id == JOB:
        problem = find_problem(task, job, BATCH)
    if not variables:
        return problem
    if problem.id != JOB:
        raise GrindError(f"--set is of a part program, and {problem.name} is none: leave it out")
    return replace(problem, arguments=(*problem.arguments, ("variables", ",".join(variables))))


def _contents(simulation: "Simulation") -> "Iterator[tuple[str, str | float]]":
    """Yield all inputs of a training by name: those of the agent, and of a job its plant, wheel and uncertainty."""
    from grind_env.envs.inputs import inputs_of, named

    yield from inputs_of(simulation).items()
    yield from (each for each in named(getattr(simulation, "job", None)) if isinstance(each[1], str | float | int))


def _untrained(problem: "Problem") -> "Policy | str":
    """What plays where nothing was trained."""
    from grind_env.envs.job.simulation import JobSimulation
    from grind_env.shop.advise.adviser import policy_for

    simulation = problem.simulation()
    return policy_for(None, simulation) if isinstance(simulation, JobSimulation) else RULE


def _usual_file(task: str, problem: "Problem") -> Path:
    """Where the agent is written if nobody says where: beside the part program, or in the current folder.

    Raises:
        FileError: it cannot be written there, or something else than an agent would be replaced.
    """
    from grind_env.files import beside
    from grind_env.policies.learned.saved import ENTRY, SUFFIX
    from grind_env.policies.problem import JOB
    from grind_env.targets import Own, Target, check_targets

    path = beside(Path(task), SUFFIX) if problem.id == JOB else Path(problem.name + SUFFIX)
    agent = Own("trained agent", re.compile(rb'.{8}\{"__metadata__":\{"' + ENTRY.encode(), re.DOTALL).match)
    check_targets([Target(path=path, option="--output", own=agent)])
    return path


def _verdict(found: "Judgement", other: "Judgement") -> str:
    """What the agent saves of the cost of a good part, with 95 %, on the same episodes."""
    import numpy as np

    from grind_env.policies.statistics import bootstrap, cost_per_good_part

    run, beside = found.evaluation, other.evaluation
    # nothing is known where neither has a good part
    with np.errstate(invalid="ignore"):
        saved = bootstrap(
            lambda cost, good, least, best: 1.0 - cost_per_good_part(cost, good) / cost_per_good_part(least, best),
            *(run.cost, run.good, beside.cost, beside.good),
        )
    if not saved.low > 0.0:
        return f"it is not known to be better than {other.policy}: play that, or train longer or with another --seed"
    low, high = (f"{100.0 * end:.0f}" for end in (saved.low, saved.high))
    return f"a good part costs {100.0 * saved.value:.0f} % less than by {other.policy} ({low} to {high})"
