"""Better words for a part program: searched on some lots, chosen on others, judged on unseen ones."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grind_env.arrays import Array
from grind_env.control import Programs, read, read_file
from grind_env.errors import GrindError
from grind_env.files import read_bytes
from grind_env.machine.job import Job
from grind_env.machine.job.file import job_beside, load_job
from grind_env.machine.script.settings import DRESS_SECONDS
from grind_env.plants import find_plant
from grind_env.plants.names import MODEL
from grind_env.shop.optimise.budget import ENOUGH_TRIALS, Budget, TimeUp, time_said
from grind_env.shop.optimise.comparing import compared
from grind_env.shop.optimise.editing import ProgramText, text_of
from grind_env.shop.optimise.freed import freed_of, without
from grind_env.shop.optimise.judgement import (
    QUANTITIES,
    Change,
    few,
    limits_of,
    not_freed,
    on_machines,
    paired,
    passed_over,
    quantities_of,
    undressed,
    verdict_of,
    wishes_kept,
    words_of,
)
from grind_env.shop.optimise.leaving import JUDGED, SEARCHED, following, judging
from grind_env.shop.optimise.outcome import Optimised, Trade, Verdict, WishUse, cheapest_by_time
from grind_env.shop.optimise.search import Point, Search
from grind_env.shop.optimise.unrolling import unrolled
from grind_env.shop.optimise.variation import (
    Pace,
    Progress,
    Variation,
    nothing_more,
    one_run,
    variation_of,
)
from grind_env.shop.optimise.wishes import Wishes
from grind_env.shop.risk import most_risk
from grind_env.shop.trials import LIMITS, SAME, LotUse, Measures, Trials, lots_said

OVER = 1.2
"""Times the budget up to which programs are judged, and words without each limit are searched."""


def find_words(
    program: str | Path,
    job: str | Path | Job | None = None,
    wishes: Wishes | None = None,
    *,
    parts: int = 50,
    seconds: float = 60.0,
    seed: int = 1,
    unroll: bool = False,
    variables: Mapping[int, float] = {},
    plant: str | None = None,
    progress: Progress = lambda label, count: None,
) -> Optimised:
    """Search better words for a program.

    On a machine that is not the model, the search is on the model, and the judgement on the machine: that of the
    catalogue's numbers, to which no calibration belongs.

    The search, the comparison of the best programs found and the judgement have lots of their own, the same ones for
    all programs, and machines of their own, drawn from what is not known of that of the job. The result is the same
    for the same seed unless the time ends the search.

    Args:
        program: file of the part program.
        job: its job file, or a job as `load_job` returns it, on whose own machine then is searched; the program's name
            with `.toml` if not given.
        wishes: what is varied between which bounds, and margins of the limits.
        parts: how often the program is run before the wheel is handed over; the wheel carries over.
        seconds: for search and judgement; of a program that the control executes for the search alone, and what follows
            ends within four times as many and 10 s.
        seed: of lots and search.
        unroll: whether M98 calls of cycle blocks are written out, each with words of its own.
        variables: values that `#` variables have before the first part.
        plant: name of the machine, in place of that of the job.
        progress: called with what is being done and by how many programs it has come on.

    Raises:
        GrindError: the program cannot be run, there is nothing to vary in it, or there is no time for one trial.
    """
    program = Path(program)
    programs, text = read_file(program), text_of(read_bytes(program))
    if unroll:
        text = unrolled(programs, text)
        programs = read(text.text, programs.name, programs.folder)
    try:
        planned, machine, name = _jobs(program, job, plant)
        planned = replace(planned, variables=variables)
        machine = None if machine is None else replace(machine, variables=variables)
        variation = variation_of(programs, text, planned, wishes or Wishes(), parts, seed, seconds)
        return _optimised(variation, name, progress, machine)
    except TimeUp:
        raise GrindError(
            f"{programs.name}: there was no time to try one program on {SEARCHED} lots, for the control executes this "
            f"one step by step; give it more than --budget {seconds:g}s, or grind fewer than --parts {parts}"
        ) from None


def _jobs(program: Path, job: str | Path | Job | None, plant: str | None) -> tuple[Job, Job | None, str]:
    """What is searched on, what the result is judged on where that is another machine, and the name of the job file."""
    machine = None if plant is None else find_plant(plant, modules=True)
    if isinstance(job, Job):
        return job, None if machine is None else job.on(machine), ""
    path = job_beside(program) if job is None else Path(job)
    held = load_job(path, plant=machine, calibrated=False)
    return replace(load_job(path, plant=MODEL), plant=""), held if held.plant else None, path.name


def _optimised(variation: Variation, job: str, progress: Progress, machine: Job | None = None) -> Optimised:
    """What the search finds on the job of the model, and what that comes to on a machine that is another one."""
    budget, uncertainty = variation.budget, variation.job.uncertainty
    compiled = variation.base.simulation.compiled
    search, tried, pace, points, seconds = searched(variation, progress)
    feasible = any(each.keeps for each in tried.values())
    lots = JUDGED if compiled else budget.judged(JUDGED, seconds / SEARCHED)
    before = variation.trials(LotUse.JUDGEMENT, lots)
    progress("judging", 0)
    old = before.measure(before.own[None])
    less = attrgetter(variation.wishes.quantity)
    judged = _judged(variation, before, old, points, lots)
    kept = judged[-1].keeps(variation)
    chosen = judged[-1] if kept else judged[0]
    promised, fleet = None, variation.fleet
    if machine is not None:
        promised = before.of_one(less(chosen.new)[0])
        variation = variation.on(machine)
        before = variation.trials(LotUse.JUDGEMENT, lots)
        old = before.measure(before.own[None])
        chosen = _judge(variation, before, old, chosen.point, lots)
        kept = chosen.keeps(variation)
    point, text, programs, after, new, wishes, change = chosen
    if point not in tried:
        search.objective(np.array([point]))
    objective = variation.wishes.quantity
    beyond = new.violation(variation.margins)[0]
    sought = feasible and before.simulation.compiled and machine is None
    left = Budget(OVER * budget.seconds - budget.spent)
    freed = freed_of(variation, before, point, new, tried, pace, left, progress) if sought else {}
    limits = limits_of(variation, old, new, freed)
    on = lots_said(before.lots, "unseen lots")
    verdict, reason = verdict_of(
        feasible or kept, QUANTITIES[objective], change, limits, beyond, wishes, variation.wishes.confidence, on
    )
    if not verdict.is_written and search.ended_early and len(search.costs) == 1:
        enough = f"try some {ENOUGH_TRIALS} with --budget {time_said(ENOUGH_TRIALS * seconds)}"
        verdict, reason = Verdict.UNTRIED, f"the first one took all the time of the search; {enough}"
    once = variation.once if after is before else one_run(programs, variation.job)
    quantities = quantities_of(before, variation.once, once, old, new)
    return Optimised(
        program=variation.programs.name,
        job=job,
        verdict=verdict,
        reason=reason,
        words=words_of(variation.choices, point),
        quantities=quantities,
        limits=limits,
        wishes=wishes,
        objective=objective,
        cheapest=cheapest_by_time(tried.values()),
        chosen=(tried[variation.start], tried[point]),
        remarks=(
            *variation.choices.remarks,
            *variation.base.simulation.unread,
            *undressed(before, after, variation.runs),
            *on_machines(fleet),
            *passed_over(len(judged), kept),
            *few(len(before.seeds), lots, JUDGED),
            *not_freed([name for name in LIMITS if sought and name not in freed and without(variation.job, name)]),
        ),
        before=variation.text.text,
        after=text.text if verdict.is_written else variation.text.text,
        data=text.bytes() if verdict.is_written else variation.text.bytes(),
        parts=variation.runs,
        lots=before.lots,
        seed=variation.seed,
        evaluations=len(search.costs),
        ended_early=search.ended_early,
        plant=variation.job.plant,
        promised=promised,
        confidence=variation.wishes.confidence,
        calibration=None if uncertainty is None else uncertainty.source,
    )


class Searched(NamedTuple):
    """What a search has come to."""

    search: Search
    tried: Mapping[Point, Trade]
    pace: Pace
    points: Sequence[Point]
    """In the order in which they are to be judged; the nearest one alone if none keeps what is asked."""
    seconds: float
    """That a program took, s."""


def searched(variation: Variation, progress: Progress) -> Searched:
    """Search better words, and compare the best."""
    budget, compiled = variation.budget, variation.base.simulation.compiled
    tried: dict[Point, Trade] = {}
    pace = Pace()
    leaves = partial(following, variation, pace) if compiled else nothing_more
    search = variation.search(variation.trials(LotUse.SEARCH, SEARCHED), progress, "searching", tried, pace, leaves)
    known = budget.spent
    search.run(variation.start, variation.seed, grid=variation.grid() if compiled else ())
    seconds = (budget.spent - known) / len(search.costs)
    points: Sequence[Point] = search.ranked[:1]
    if any(each.keeps for each in tried.values()):
        points = compared(variation, search.ranked, tried, pace, partial(judging, variation, pace), progress)
    return Searched(search, tried, pace, points, seconds)


class _Judged(NamedTuple):
    """Words of a program on the lots of the judgement."""

    point: Point
    text: ProgramText
    programs: Programs
    after: Trials
    new: Measures
    wishes: tuple[WishUse, ...]

    change: Change

    def keeps(self, variation: Variation) -> bool:
        """Whether they keep limits and wishes, and are better or at least what was asked for."""
        asked = all(each.kept for each in self.wishes) and not self.new.violation(variation.margins).any()
        return asked and (self.change.is_better or any(each.before > each.most for each in self.wishes))


def _judged(variation: Variation, before: Trials, old: Measures, points: Sequence[Point], lots: int) -> list[_Judged]:
    """Programs one after the other up to the first that keeps limits and wishes, or as long as there is time."""
    judged, budget, longest = list[_Judged](), variation.budget, 0.0
    for point in points:
        began = budget.spent
        if judged and began + longest > OVER * budget.seconds:
            break
        judged.append(_judge(variation, before, old, point, lots))
        if judged[-1].keeps(variation):
            break
        longest = max(longest, budget.spent - began)
    return judged


def _judge(variation: Variation, before: Trials, old: Measures, point: Point, lots: int) -> _Judged:
    text, programs = variation.with_words(point), variation.read(point)
    same = text.text == variation.text.text and not any(variation.ranges)
    after = before if same else variation.trials_of(programs, LotUse.JUDGEMENT, lots)
    said = _require_said(variation, before, after, point)
    new = old if same else after.measure(said[None])
    less = attrgetter(variation.wishes.quantity)
    difference = less(new)[0] - less(old)[0]
    risk = float(variation.risk(before, new, old)[0])
    change = Change(before.of_one(difference), paired(difference), risk, most_risk(variation.job))
    return _Judged(point, text, programs, after, new, wishes_kept(variation.wishes, old, new), change)


def _require_said(variation: Variation, before: Trials, after: Trials, point: Point) -> Array:
    """Refuse a text that does not say what was searched: what its blocks set is read off the text itself.

    Returns:
        What they set, shape as of `Trials.own`.
    """
    asked = variation.settings(before.own, np.array([point]))[0]
    said = after.own
    columns = [k for k in range(asked.shape[1]) if k != DRESS_SECONDS]
    if asked.shape != said.shape or not np.allclose(asked[:, columns], said[:, columns], rtol=SAME, atol=0.0):
        raise GrindError(
            f"{variation.programs.name}: other numbers in its words do not change its cycles as they say, so that no "
            "better program can be written; vary fewer words with --vary"
        )
    return said
