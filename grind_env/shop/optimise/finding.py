"""Better words for a part program: searched on some lots, chosen on others, judged on unseen ones."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.arrays import Array
from grind_env.control import read, read_file
from grind_env.errors import GrindError
from grind_env.files import read_bytes
from grind_env.machine.job import Job, Part
from grind_env.machine.job.file import job_beside, load_job
from grind_env.machine.script.settings import DRESS_SECONDS
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.optimise.budget import ENOUGH_TRIALS, Budget, TimeUp, time_said
from grind_env.shop.optimise.editing import text_of
from grind_env.shop.optimise.judgement import (
    QUANTITIES,
    Freed,
    few,
    limits_of,
    not_freed,
    paired,
    quantities_of,
    undressed,
    verdict_of,
    wishes_kept,
    words_of,
)
from grind_env.shop.optimise.outcome import Optimised, Trade, Verdict, cheapest_by_time
from grind_env.shop.optimise.search import GENERATIONS, Point
from grind_env.shop.optimise.unrolling import unrolled
from grind_env.shop.optimise.variation import Progress, Variation, nothing_more, one_run, variation_of
from grind_env.shop.optimise.wishes import Wishes
from grind_env.shop.trials import LIMITS, SAME, LotUse, Trials, lots_said

SEARCHED, CHOSEN, JUDGED = 16, 128, 256
"""Lots on which programs are searched, on which the best of them are compared, and on which that one is judged; more of
short batches, and fewer of a program that the control executes, if there is no time for them."""
FINALISTS = 4
"""Programs that are compared, the best of all and of those that keep each of `CLEARANCES`."""
CLEARANCES = (1.0, 0.97, 0.94)
"""Shares of what is asked of the limits; much that the search finds just within them is beyond them on other lots."""
STEP_BY_STEP = 3, 8
"""Finalists, and lots on which they are compared, of a program that the control executes, a thousand times slower."""
FEWER = 4
"""Generations of a search without a limit, over those of the whole one."""

WITHOUT_LIMITS, OVER = 0.1, 1.2
"""Share of the budget that the search leaves for words without each limit, and times the budget up to which they are
searched."""

FREE = {"temp": ("rise_allowance", 2000.0), "Ra": ("roughness_limit", NO_LIMIT), "size": ("tolerance", NO_LIMIT)}
"""Field of a part that holds a limit, and what it is without."""


def find_words(
    program: str | Path,
    job: str | Path | None = None,
    wishes: Wishes | None = None,
    *,
    parts: int = 50,
    seconds: float = 60.0,
    seed: int = 1,
    unroll: bool = False,
    variables: Mapping[int, float] = {},
    progress: Progress = lambda label, count: None,
) -> Optimised:
    """Search better words for a program.

    The search, the comparison of the best programs found and the judgement have lots of their own, the same ones for
    all programs. The result is the same for the same seed unless the time ends the search.

    Args:
        program: file of the part program.
        job: its job file; the program's name with `.toml` if not given.
        wishes: what is varied between which bounds, and margins of the limits.
        parts: how often the program is run before the wheel is handed over; the wheel carries over.
        seconds: for search and judgement; of a program that the control executes for the search alone, and what follows
            ends within four times as many and 10 s.
        seed: of lots and search.
        unroll: whether M98 calls of cycle blocks are written out, each with words of its own.
        variables: values that `#` variables have before the first part.
        progress: called with what is being done and by how many programs it has come on.

    Raises:
        GrindError: the program cannot be run, there is nothing to vary in it, or there is no time for one trial.
    """
    program = Path(program)
    job = job_beside(program) if job is None else Path(job)
    programs, text = read_file(program), text_of(read_bytes(program))
    if unroll:
        text = unrolled(programs, text)
        programs = read(text.text, programs.name, programs.folder)
    try:
        held = replace(load_job(job), variables=variables)
        variation = variation_of(programs, text, held, wishes or Wishes(), parts, seed, seconds)
        return _optimised(variation, job.name, progress)
    except TimeUp:
        raise GrindError(
            f"{programs.name}: there was no time to try one program on {SEARCHED} lots, for the control executes this "
            f"one step by step; give it more than --budget {seconds:g}s, or grind fewer than --parts {parts}"
        ) from None


def _optimised(variation: Variation, job: str, progress: Progress) -> Optimised:
    budget = variation.budget
    tried: dict[Point, Trade] = {}
    compiled = variation.base.simulation.compiled
    judging = partial(_judging, variation) if compiled else nothing_more
    search = variation.search(variation.trials(LotUse.SEARCH, SEARCHED), progress, "searching", tried, judging)
    known = budget.spent
    search.run(variation.start, variation.seed, grid=variation.grid() if compiled else ())
    seconds = (budget.spent - known) / len(search.costs)
    feasible = any(each.keeps for each in tried.values())
    point = _chosen(variation, search.ranked, tried) if feasible else search.ranked[0]
    text = variation.with_words(point)
    programs = variation.read(point)
    lots = JUDGED if compiled else budget.judged(JUDGED, seconds / SEARCHED)
    same = text.text == variation.text.text and not any(variation.ranges)
    before = variation.trials(LotUse.JUDGEMENT, lots)
    after = before if same else variation.trials_of(programs, LotUse.JUDGEMENT, lots)
    said = _require_said(variation, before, after, point)
    progress("judging", 0)
    old = before.measure(before.own[None])
    new = old if same else after.measure(said[None])
    objective = variation.wishes.quantity
    less = attrgetter(objective)
    difference = paired(less(new)[0] - less(old)[0])
    wishes = wishes_kept(variation.wishes, old, new)
    beyond = new.violation(variation.margins)[0]
    sought = feasible and before.simulation.compiled
    left = Budget(OVER * budget.seconds - budget.spent)
    freed = _freed(variation, before, point, seconds / SEARCHED, left, progress) if sought else {}
    limits = limits_of(variation, old, new, freed)
    on = lots_said(len(before.seeds), "unseen lots")
    verdict, reason = verdict_of(feasible, QUANTITIES[objective], difference, limits, beyond, wishes, on)
    if verdict is not Verdict.BETTER and search.ended_early and len(search.costs) == 1:
        enough = f"try some {ENOUGH_TRIALS} with --budget {time_said(ENOUGH_TRIALS * seconds)}"
        verdict, reason = Verdict.UNTRIED, f"the first one took all the time of the search; {enough}"
    better = verdict is Verdict.BETTER
    quantities = quantities_of(variation.once, variation.once if same else one_run(programs, variation.job), old, new)
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
            *few(len(before.seeds), lots, JUDGED),
            *not_freed([name for name in LIMITS if sought and name not in freed and without(variation.job, name)]),
        ),
        before=variation.text.text,
        after=text.text if better else variation.text.text,
        data=text.bytes() if better else variation.text.bytes(),
        parts=variation.runs,
        lots=len(before.seeds),
        seed=variation.seed,
        evaluations=len(search.costs),
        ended_early=search.ended_early,
    )


def _chosen(
    variation: Variation, ranked: list[Point], tried: dict[Point, Trade], finalists_each: int = FINALISTS
) -> Point:
    """The best of the first programs on lots that no search has seen; the nearest to the limits if none keeps them.

    Without the time for that it is the first of them.
    """
    if variation.base.simulation.compiled:
        lots = CHOSEN
        best = [[point for point in ranked if tried[point].share <= share][:finalists_each] for share in CLEARANCES]
        finalists = list(dict.fromkeys(chain.from_iterable(best))) or ranked[:1]
    else:
        count, lots = STEP_BY_STEP
        finalists = ranked[:count]
    if len(finalists) == 1:
        return finalists[0]
    try:
        found = variation.measure(
            variation.trials(LotUse.COMPARISON, lots), finalists, variation.budget.require_comparison
        )
    except TimeUp:
        return finalists[0]
    return finalists[int(variation.worth(found).argmin())]


def _require_said(variation: Variation, before: Trials, after: Trials, point: Point) -> Array:
    """Refuse a text that does not say what was searched: what its blocks set is read off the text itself.

    Returns:
        What they set, shape as of `Trials.own`; where the operator says by block delete what parts are dressed, with
        that switch as the text asks for it.
    """
    asked = variation.settings(before.own, np.array([point]))[0]
    said = after.own
    counting = variation.counting(point)
    if counting is not None and counting.counter is None:
        deleted = variation.trials_of(variation.read(point, block_delete=True), LotUse.BASE, 1).own
        dressed = (after.run_of_block + 1) % counting.interval.every == 0
        said = np.where(dressed[:, None], said, deleted)
    columns = [k for k in range(asked.shape[1]) if k != DRESS_SECONDS]
    if asked.shape != said.shape or not np.allclose(asked[:, columns], said[:, columns], rtol=SAME, atol=0.0):
        raise GrindError(
            f"{variation.programs.name}: other numbers in its words do not change its cycles as they say, so that no "
            "better program can be written; vary fewer words with --vary"
        )
    return said


def _judging(variation: Variation, each: float) -> float:
    """Time that it takes to compare and judge what a search has found, and that is left for words without limits, s.

    Args:
        variation: the program.
        each: time that a program takes on a lot, s.
    """
    lots = len(variation.trials(LotUse.JUDGEMENT, FINALISTS * len(CLEARANCES) * CHOSEN + 3 * JUDGED).seeds)
    return each * lots + variation.reading + WITHOUT_LIMITS * variation.budget.seconds


def _freed(
    variation: Variation, judged: Trials, best: Point, each: float, budget: Budget, progress: Progress
) -> dict[str, Freed]:
    """The best words without each limit: what they save on unseen lots, and how far they are beyond it.

    Limits for which the time is up are left out; `each` is the time that a program takes on a lot, s.
    """
    less = attrgetter(variation.wishes.quantity)
    with_all, words = less(variation.measure(judged, [best]))[0], {}
    others = [(k, name, free) for k, name in enumerate(LIMITS) if (free := without(variation.job, name)) is not None]
    judging = each * (len(CLEARANCES) * CHOSEN + 2 * JUDGED) / JUDGED * len(judged.seeds)
    for number, (k, name, free) in enumerate(others):
        seconds = (budget.seconds - budget.spent) / (len(others) - number) - judging
        if seconds < 0.0:
            break
        margins = variation.margins.copy()
        margins[k] = np.inf
        other = variation.with_job(free, margins, Budget(seconds))
        tried: dict[Point, Trade] = {}
        search = other.search(other.trials(LotUse.SEARCH, SEARCHED), progress, f"without the limit of {name}", tried)
        search.run(best, variation.seed, GENERATIONS // FEWER)
        point = _chosen(other, search.ranked, tried, 1)
        found = less(other.measure(other.trials(LotUse.JUDGEMENT, JUDGED), [point]))[0]
        share = float(variation.measure(judged, [point]).ratios[0, k])
        words[name] = Freed(paired(with_all - found), share)
    return words


def without(job: Job, limit: str) -> Job | None:
    """The job without a limit; None if it has none."""
    machine = job.setup.machine
    if limit == "power":
        stronger = replace(machine, power_limit=min(4.0 * machine.power_limit, 500_000.0))
        return replace(job, setup=replace(job.setup, machine=stronger))
    name, free = FREE[limit]
    kinds = [
        job.part,
        *(each.part for each in job.parts if each.part is not None),
        *(each.part for each in job.stations),
    ]
    if free == NO_LIMIT and all(getattr(asked, name) == NO_LIMIT for kind in kinds for asked in (kind, *kind.stages)):
        return None

    def freed(part: Part) -> Part:
        other: dict[str, Any] = {name: free}
        return replace(part, stages=tuple(replace(stage, **other) for stage in part.stages), **other)

    parts = tuple(each if each.part is None else replace(each, part=freed(each.part)) for each in job.parts)
    stations = tuple(replace(each, part=freed(each.part)) for each in job.stations)
    return replace(job, part=freed(job.part), parts=parts, stations=stations, met=())
