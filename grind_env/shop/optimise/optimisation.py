"""Find better words of a part program: search on some lots, choose on others, judge on unseen lots."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grind_env.control import read_file
from grind_env.errors import GrindError
from grind_env.files import read_bytes
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import job_beside, load_job
from grind_env.machine.script.block_settings import DRESS_SECONDS
from grind_env.optional_libraries import needing
from grind_env.plants import find_plant
from grind_env.plants.plant_names import MODEL
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.optimise.candidate_ranking import costs_of_limits, job_without, rank_finalists
from grind_env.shop.optimise.judgement import (
    ProgramJudge,
    dress_remarks,
    limits_of,
    machine_remarks,
    quantities_of,
    ranking_remarks,
    verdict_of,
    words_of,
)
from grind_env.shop.optimise.result import Optimised, Trade, Verdict, cheapest_by_time
from grind_env.shop.optimise.search import ENOUGH_TRIALS, MOST_JUDGING, Budget, Point, TimeUp, time_text
from grind_env.shop.optimise.search_problem import LOTS, Progress, Variation, one_run, variation_of
from grind_env.shop.optimise.word_editing import text_of
from grind_env.shop.possible_machines import require_good
from grind_env.shop.search_options import LIMITS, SearchOptions
from grind_env.shop.trials import SAME, LotUse, Trials, lots_text

#: lots of the judgement of a program that the control executes: least number, and number without a time budget
LEAST_JUDGED, FEW_JUDGED = 8, 16


def find_words(
    program: str | Path,
    job: str | Path | Job | None = None,
    options: SearchOptions | None = None,
    *,
    parts: int = 50,
    seconds: float = math.inf,
    programs: int | None = None,
    seed: int = 1,
    variables: Mapping[int, float] = {},
    plant: str | None = None,
    progress: Progress = lambda label, count: None,
) -> Optimised:
    """Search for better words of a program; arguments as in `grind_env.optimise`.

    Search, comparison and judgement have separate lots, the same for all programs, and machines drawn from the job's
    uncertainty, separate if there are enough. The result is the same for the same seed unless the time ends the search.

    Raises:
        CondemnedError: the model scraps the unchanged program.
        GrindError: SciPy is missing, the program cannot be run or has nothing to vary, or no trial fits into the time.
    """
    with needing("shop", "the search needs"):
        import scipy.optimize  # noqa: F401 - a search that needs no evolution is refused, too
    path = Path(program)
    budget = Budget(seconds) if programs is None else Budget(programs=programs)
    held, text = read_file(path), text_of(read_bytes(path))
    try:
        planned, machine, name = _jobs(path, job, plant)
        planned = replace(planned, variables=variables)
        machine = None if machine is None else replace(machine, variables=variables)
        variation = variation_of(held, text, planned, options or SearchOptions(), parts, seed, budget)
        return _optimised(variation, name, progress, machine)
    except TimeUp:
        raise GrindError(
            f"{held.name}: there was no time to try one program on {LOTS[LotUse.SEARCH]} lots, for the control "
            f"executes this one step by step; give it more than --budget {budget.seconds:g}s, or grind fewer than "
            f"--parts {parts}"
        ) from None


def _jobs(program: Path, job: str | Path | Job | None, plant: str | None) -> tuple[Job, Job | None, str]:
    """Return the job to search on, the job to judge on if another machine, and the name of the job file."""
    machine = None if plant is None else find_plant(plant, modules=True)
    if isinstance(job, Job):
        return job, None if machine is None else job.on(machine), ""
    path = job_beside(program) if job is None else Path(job)
    held = load_job(path, plant=machine, calibrated=False)
    return replace(load_job(path, plant=MODEL), plant=""), held if held.plant else None, path.name


def _optimised(variation: Variation, job: str, progress: Progress, machine: Job | None) -> Optimised:
    """Search on the model's job, and judge the result on another machine."""
    budget, uncertainty, objective = variation.budget, variation.job.uncertainty, variation.options.quantity
    compiled, fleet = variation.base.simulation.compiled, variation.fleet
    progress("judging", 0)
    judgement = _judgement(variation)
    budget.keep(judgement.seconds * (len(LIMITS) if compiled else 1) + variation.reading_seconds)
    tried: dict[Point, Trade] = {}
    search = variation.search(variation.trials(LotUse.SEARCH), "searching", progress, tried)
    known = budget.spent
    search.run(variation.start, variation.seed, grid=variation.grid() if compiled else ())
    seconds = (budget.spent - known) / len(search.costs)
    feasible = any(each.keeps for each in tried.values())
    points: Sequence[Point] = rank_finalists(variation, search, tried, progress) if feasible else search.ranked[:1]
    chosen = judgement.best_of(points)
    judged, kept, unjudged = len(judgement.judged), chosen.keeps(variation), len(points) - len(judgement.judged)
    promised = None
    if machine is not None:
        promised = judgement.trials.of_one(getattr(chosen.new, objective)[0])
        variation = variation.for_machine(machine)
        judgement = ProgramJudge(variation, len(judgement.trials.seeds))
        chosen = judgement.judge(chosen.point)
        kept = chosen.keeps(variation)
    point, new, requirements, _ = chosen
    text, programs = variation.with_words(point), variation.read(point)
    after = variation.read_trials(programs)
    _require_written_settings(variation, after, point)
    if point not in tried:
        search.objective(np.array([point]))
    sought = feasible and compiled and machine is None
    costs = costs_of_limits(variation, judgement, point, tried, progress) if sought else {}
    limits = limits_of(variation, judgement.old, new, costs)
    on = lots_text(judgement.trials.lots, "unseen lots")
    verdict, reason = verdict_of(feasible or kept, chosen, limits, variation, on)
    if not verdict.is_written and search.ended_early and len(search.costs) == 1:
        enough = f"try about {ENOUGH_TRIALS} programs with --budget {time_text(ENOUGH_TRIALS * seconds)}"
        verdict, reason = Verdict.UNTRIED, f"the first one took all the time of the search; {enough}"
    elif not verdict.is_written and (search.ended_early or unjudged):
        reason = f"{reason}; a larger --budget may find one"
    base = judgement.trials
    unpriced = ", ".join(name for name in LIMITS if sought and name not in costs and job_without(variation.job, name))
    return Optimised(
        program=variation.programs.name,
        job=job,
        verdict=verdict,
        reason=reason,
        words=words_of(variation.choices, point),
        quantities=quantities_of(base, variation.once, one_run(programs, variation.job), judgement.old, new),
        limits=limits,
        requirements=requirements,
        objective=objective,
        cheapest=cheapest_by_time(tried.values()),
        chosen=(tried[variation.start], tried[point]),
        remarks=(
            *variation.choices.remarks,
            *variation.base.simulation.unread,
            *dress_remarks(base, after, variation.runs),
            *machine_remarks(fleet),
            *ranking_remarks(judged, kept, unjudged),
            *_few(judgement.trials),
            *([f"no time to find what the limit of {unpriced} costs: raise --budget"] if unpriced else []),
        ),
        before=variation.text.text,
        after=text.text if verdict.is_written else variation.text.text,
        data=text.bytes() if verdict.is_written else variation.text.bytes(),
        parts=variation.runs,
        counted=DressInterval.counting(base.simulation.parts // variation.runs),
        lots=base.lots,
        seed=variation.seed,
        evaluations=len(search.costs),
        judged=judged,
        ended_early=search.ended_early,
        plant=variation.job.plant,
        promised=promised,
        confidence=variation.options.confidence,
        calibration=None if uncertainty is None else uncertainty.source,
    )


def _judgement(variation: Variation) -> ProgramJudge:
    """Judge the unchanged program; one that the control executes has as many lots as its share of the time allows."""
    lots: int | None = None
    if not variation.base.simulation.compiled:
        judgement = ProgramJudge(variation, LEAST_JUDGED)
        time = 0.5 * MOST_JUDGING * variation.budget.seconds * LEAST_JUDGED
        most = time / judgement.seconds if judgement.seconds else LOTS[LotUse.JUDGEMENT]
        lots = int(min(max(most, LEAST_JUDGED), LOTS[LotUse.JUDGEMENT])) if np.isfinite(time) else FEW_JUDGED
    judgement = ProgramJudge(variation, lots)
    require_good(variation.fleet, judgement.old, untried=variation.options.untried)
    return judgement


def _few(trials: Trials) -> list[str]:
    """Return a remark if time was too short for all lots of the judgement; no remark if the job states its parts."""
    lots, most = len(trials.seeds), LOTS[LotUse.JUDGEMENT]
    if trials.simulation.compiled or trials.lots == 1 or lots >= most:
        return []
    return [f"judged on {lots} lots, because the time is too short for {most}: raise --budget"]


def _require_written_settings(variation: Variation, after: Trials, point: Point) -> None:
    """Refuse a text whose blocks have other settings than the search; the settings are read from the text itself."""
    asked = variation.settings(variation.base.own, np.array([point]))[0]
    said = after.own
    columns = [k for k in range(asked.shape[1]) if k != DRESS_SECONDS]
    if asked.shape != said.shape or not np.allclose(asked[:, columns], said[:, columns], rtol=SAME, atol=0.0):
        raise GrindError(
            f"{variation.programs.name}: other numbers in its words do not change its cycles as they say, so that no "
            "better program can be written; vary fewer words with --vary"
        )
