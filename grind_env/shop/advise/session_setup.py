"""Sessions and rehearsals from the arguments of `grind advise`."""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.files import beside
from grind_env.machine.job.job_file import job_beside
from grind_env.message_text import printable, quoted
from grind_env.plants.plant_names import MODEL
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.policy_lookup import agent_of
from grind_env.policies.problem_lookup import find_problem
from grind_env.shop.advise.adviser import AdviceError, Adviser, policy_for
from grind_env.shop.advise.forecast_comparison import Shadow
from grind_env.shop.advise.operator_readings import MachineReadings
from grind_env.shop.advise.reading_sources import CsvSource, JsonLines, Prompt, ReadingSource
from grind_env.shop.advise.rehearsal import advised, as_programmed, ground
from grind_env.shop.advise.session import Files, Session, as_data, lines_of
from grind_env.shop.advise.state import origin_of
from grind_env.shop.advise.variables_file import check_free, check_variables

BLOCK, PART = "block", "part"


@dataclass(frozen=True, slots=True, kw_only=True)
class AdviceRequest:
    """Subject and options of a session, from `grind advise`."""

    program: Path
    job: Path | None
    policy: str | None
    other_part: bool
    parts: int
    variables: Mapping[int, float]
    step: float
    bounds: tuple[float, float] | None
    as_json: bool
    why: bool

    def simulation(self, plant: str = MODEL.name) -> JobSimulation:
        path = job_beside(self.program) if self.job is None else self.job
        given = dict(find_problem(str(self.program), str(path), self.parts).arguments)
        return load_simulation(given.get("program"), given["job"], self.parts, 1.0, "measured", self.variables, plant)

    def adviser(self, simulation: JobSimulation, *, shadow: bool = False) -> Adviser:
        """Return the adviser before the first block."""
        policy = policy_for(self.policy, simulation, self.step, other_part=self.other_part)
        for sentence in simulation.unread:
            _tell(sentence)
        if (agent := agent_of(policy)) is not None and agent.remark:
            _tell(agent.remark)
        return Adviser(simulation, policy, bounds=self.bounds, shadow=shadow)


def open_session(
    request: AdviceRequest,
    *,
    by: str,
    measurements: Path | None,
    follow: bool,
    state: Path,
    values: Path | None,
    shadow: bool,
) -> Session:
    """Return a session before its first block."""
    if by not in (BLOCK, PART):
        raise AdviceError(f"--rows is {quoted(by)}, but must be {BLOCK} or {PART}")
    if shadow and values is not None:
        raise AdviceError("--shadow looks on while others decide, and --write decides: leave one of them out")
    if follow and measurements is None:
        raise AdviceError("--follow waits for rows of a file: name it with --measurements")
    simulation = request.simulation()
    adviser = request.adviser(simulation, shadow=shadow)
    if shadow and adviser.watch is None:
        raise AdviceError(f"--shadow compares forecasts, and {adviser.policy.name} has none: leave out --policy")
    if values is not None:
        check_free(simulation, values)
        if by == PART:
            check_variables(simulation)
    saved = Path(request.policy) if request.policy is not None and request.policy.endswith(SUFFIX) else None
    how = f"{request.bounds}{shadow}" if request.bounds or shadow else ""
    return Session(
        adviser=adviser,
        origin=origin_of(simulation, adviser.policy, saved, how),
        files=Files(state=state, log=beside(state, ".csv"), values=values),
        source=_input() if measurements is None else CsvSource(measurements, follow=follow),
        say=_say,
        by_part=by == PART,
        as_json=request.as_json,
        why=request.why,
        shadow=Shadow() if shadow else None,
    )


def rehearse(request: AdviceRequest, plant: str, others: Sequence[str]) -> None:
    """Grind a batch on a simulated machine with advice, and print its cost beside the unchanged program's."""
    if others:
        raise AdviceError(f"--plant rehearses on a simulated machine, and {others[0]} is for a real one: leave one out")
    adviser, machine = request.adviser(request.simulation()), request.simulation(plant)
    follow = advised(adviser)

    def decide(number: int, readings: MachineReadings | None) -> JobChoice:
        choice, advice = follow(number, readings), adviser.advice
        assert advice is not None
        lines = (
            [json.dumps(as_data(adviser, advice))] if request.as_json else lines_of(adviser, advice, why=request.why)
        )
        for line in lines:
            _say(line)
        return choice

    costs = {
        name: {"cost": float(shift.cost.mean()), "scrap": float(shift.scrap.mean())}
        for name, shift in (("advised", ground(machine, decide)), ("program", ground(machine, as_programmed(machine))))
    }
    if request.as_json:
        _say(json.dumps({"rehearsed": plant, "parts": request.parts, **costs}))
        return
    said = [f"{each['cost']:.2f} $ a part, scrap {each['scrap']:.1%}" for each in costs.values()]
    _say(f"rehearsed on {plant}, {request.parts} parts: {said[0]}; the program as it is: {said[1]}")


def _input() -> ReadingSource:
    if sys.stdin is None or sys.stdin.closed:
        raise AdviceError("standard input is closed, so that no readings can come: name a file with --measurements")
    return Prompt() if sys.stdin.isatty() else JsonLines(sys.stdin.buffer)


def _tell(text: str) -> None:
    print(printable(text), file=sys.stderr)


def _say(text: str) -> None:
    print(printable(text), flush=True)
