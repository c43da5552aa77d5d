"""The arguments of `grind advise` -> a session."""

import sys
from collections.abc import Mapping
from pathlib import Path

from grind_env.envs.job.loading import load_simulation
from grind_env.errors import GrindError, printable, quoted
from grind_env.files import beside
from grind_env.machine.job.file import job_beside
from grind_env.plants.names import MODEL
from grind_env.policies.guard import STEP, Guarded
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.naming import agent_of
from grind_env.policies.problem import find_problem
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.session import Files, Session
from grind_env.shop.advise.shadow import Shadow
from grind_env.shop.advise.sources import CsvSource, JsonLines, Prompt, Source
from grind_env.shop.advise.state import origin_of
from grind_env.shop.advise.values import check_free, check_variables

BLOCK, PART = "block", "part"


class ArgumentError(GrindError):
    """Arguments that do not go together."""


def open_session(
    program: Path,
    job: Path | None,
    *,
    policy: str | None,
    other_part: bool = False,
    parts: int,
    variables: Mapping[int, float],
    by: str,
    measurements: Path | None,
    follow: bool,
    state: Path,
    values: Path | None,
    as_json: bool,
    step: float = STEP,
    bounds: tuple[float, float] | None = None,
    shadow: bool = False,
) -> Session:
    """A session before its first block.

    Raises:
        GrindError: an argument is faulty, or the program, the job or the policy does not fit.
    """
    if by not in (BLOCK, PART):
        raise ArgumentError(f"--by is {quoted(by)}, but must be {BLOCK} or {PART}")
    if shadow and values is not None:
        raise ArgumentError("--shadow looks on while others decide, and --write decides: leave one of them out")
    if follow and measurements is None:
        raise ArgumentError("--follow waits for rows of a file: name it with --measurements")
    path = job_beside(program) if job is None else job
    given = dict(find_problem(str(program), str(path), parts).arguments)
    simulation = load_simulation(given.get("program"), given["job"], parts, 1.0, "measured", variables, MODEL.name)
    for sentence in simulation.unread:
        _tell(sentence)
    chosen = policy_for(policy, simulation, step, other_part=other_part)
    if (agent := agent_of(chosen)) is not None and agent.remark:
        _tell(agent.remark)
    if shadow and not isinstance(chosen, Guarded):
        raise ArgumentError(
            f"--shadow compares forecasts, and {chosen.name} has none: give --policy "
            f"{Guarded.PREFIX}{policy or chosen.name}"
        )
    if values is not None:
        check_free(simulation, values)
    if values is not None and by == PART:
        check_variables(simulation)
    saved = Path(policy) if policy is not None and policy.endswith(SUFFIX) else None
    source = _input() if measurements is None else CsvSource(measurements, follow=follow)
    return Session(
        adviser=Adviser(simulation, chosen, bounds=bounds, shadow=shadow),
        origin=origin_of(simulation, chosen, saved, f"{bounds}{shadow}" if bounds or shadow else ""),
        files=Files(state=state, log=beside(state, ".csv"), values=values),
        source=source,
        say=_say,
        by_part=by == PART,
        as_json=as_json,
        shadow=Shadow() if shadow else None,
    )


def _input() -> Source:
    """Readings that are typed, or come through a pipe.

    Raises:
        ArgumentError: standard input is closed.
    """
    if sys.stdin is None or sys.stdin.closed:
        raise ArgumentError("standard input is closed, so that no readings can come: name a file with --measurements")
    return Prompt() if sys.stdin.isatty() else JsonLines(sys.stdin.buffer)


def _tell(text: str) -> None:
    print(printable(text), file=sys.stderr)


def _say(text: str) -> None:
    print(printable(text), flush=True)
