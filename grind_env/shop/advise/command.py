"""The arguments of `grind advise` -> a session."""

import sys
from pathlib import Path

from grind_env.envs.job.simulation import JobSimulation
from grind_env.errors import GrindError, printable, quoted
from grind_env.files import shown
from grind_env.machine.job_file import job_beside
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.problem import find_problem
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.session import Files, Session
from grind_env.shop.advise.sources import CsvSource, JsonLines, Prompt, Source
from grind_env.shop.advise.state import origin_of
from grind_env.shop.advise.values import check_variables

BLOCK, PART = "block", "part"


class ArgumentError(GrindError):
    """Arguments that do not go together."""


def open_session(
    program: Path,
    job: Path | None,
    *,
    policy: str | None,
    parts: int,
    by: str,
    measurements: Path | None,
    follow: bool,
    state: Path | None,
    values: Path | None,
    as_json: bool,
) -> Session:
    """A session before its first block.

    Raises:
        GrindError: an argument is faulty, or the program, the job or the policy does not fit.
    """
    if by not in (BLOCK, PART):
        raise ArgumentError(f"--by is {quoted(by)}, but must be {BLOCK} or {PART}")
    if follow and measurements is None:
        raise ArgumentError("--follow waits for rows of a file: name it with --measurements")
    path = job_beside(program) if job is None else job
    kept = program.with_suffix(".advise.json") if state is None else state
    files = Files(state=kept, log=kept.with_suffix(".csv"), values=values)
    _check_files(files, [each for each in (program, path, measurements) if each is not None])
    simulation = find_problem(str(program), str(path), parts).simulation()
    assert isinstance(simulation, JobSimulation)
    chosen = policy_for(policy, simulation)
    if values is not None and by == PART:
        check_variables(simulation)
    saved = Path(policy) if policy is not None and policy.endswith(SUFFIX) else None
    source: Source
    if measurements is not None:
        source = CsvSource(measurements, follow=follow)
    else:
        source = Prompt() if sys.stdin.isatty() else JsonLines(sys.stdin)
    return Session(
        adviser=Adviser(simulation, chosen),
        origin=origin_of(simulation, chosen, saved),
        files=files,
        source=source,
        say=_say,
        by_part=by == PART,
        as_json=as_json,
    )


def _check_files(files: Files, read: list[Path]) -> None:
    """Refuse to write over what is read, or twice into one file.

    Raises:
        ArgumentError: a file would be.
    """
    taken = {path.resolve() for path in read}
    for path in (files.state, files.log, files.values):
        if path is None:
            continue
        if path.resolve() in taken:
            raise ArgumentError(f"{shown(path)} would be written over: name another file for --state or --write")
        taken.add(path.resolve())


def _say(text: str) -> None:
    print(printable(text), flush=True)
