"""The best point of a sweep, written into its program."""

from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grind_env.control import read_file
from grind_env.files import read_bytes
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import job_of
from grind_env.machine.script.block_settings import E
from grind_env.shop.optimise.search_problem import Variation, variation_of
from grind_env.shop.optimise.variables import STEPS, SearchVariable
from grind_env.shop.optimise.word_editing import text_of
from grind_env.shop.search_options import INTERVAL, options_of
from grind_env.shop.sweep.study import Sweep, SweepError, SweepPoint, sweep_trials
from grind_env.shop.trials import most_risk, risk

#: steps of the written values, metric and in inches; of a lead the steps of its F
EXACT = {"E": (Decimal(1), Decimal(".0001")), "lead": STEPS["lead"], "depth": STEPS["depth"]}
NEAR = 0.01  #: greatest relative difference of the cost of a part as written, because E, F and infeeds are rounded
ROUNDING = 0.001  #: greatest relative difference of E as written


class NothingBetter(SweepError):
    """Sweep without a better point than the unchanged program."""

    status = 3


class Recommended(NamedTuple):
    """Program with the words of the best point of a sweep."""

    data: bytes  #: content of its file
    cost: float  #: $ a part, as that of the best point
    keeps_limits: bool  #: whether it keeps limits and permitted risk as written


def recommended(
    found: Sweep,
    program: str | Path,
    job: str | Path | Job | None = None,
    *,
    seed: int = 1,
    variables: Mapping[int, float] = {},
    untried: bool = False,
) -> Recommended:
    """Return the program with the best point written into it; the written program is simulated, too."""
    best, path = found.best, Path(program)
    if best == found.own or not best.keeps_limits:
        raise NothingBetter(f"{path.name}: no point keeps the limits and costs less than the program")
    settings = replace(job_of(path, job), variables=variables)
    names = [name for name in EXACT if getattr(best, name) != getattr(found.own, name)]
    if best.every:
        names += ["D", INTERVAL]
    every = {INTERVAL: (best.every, best.every)} if best.every else {}
    options = options_of(names, every, free=True, untried=True)
    text = text_of(read_bytes(path))
    variation = _set(variation_of(read_file(path), text, settings, options, found.parts, seed), best, found.own)
    point = (0,) * len(variation.counts)
    base, _ = sweep_trials(variation.base, seed, untried=untried)
    written = variation.read_trials(variation.read(point))
    written = written.with_lots(base.seeds, base.simulation.machines.jobs, base.drift)
    if not np.allclose(written.own[:, E] / base.own[:, E], best.E / found.own.E, rtol=ROUNDING):
        raise SweepError(f"{path.name}: written into its text the best point does not run with its E")
    old, measured = (each.measure(each.own[None]) for each in (base, written))
    cost = float(measured.cost.mean()) + best.luck
    if abs(cost - best.cost.value) > NEAR * best.cost.value:
        why = "; ".join(variation.choices.remarks) or "its words do not change its cycles as they say"
        raise SweepError(
            f"{path.name}: written into its text the best point costs {cost:.3f} $ a part and not "
            f"{best.cost.value:.3f} $: {why}"
        )
    keeps = measured.ratios.max() <= 1.0 and risk(written, measured, old)[0] <= most_risk(settings)
    return Recommended(data=variation.with_words(point).bytes(), cost=cost, keeps_limits=bool(keeps))


def _set(variation: Variation, best: SweepPoint, own: SweepPoint) -> Variation:
    """Return the variation with one level for each variable, the level of the best point."""
    turns = variation.base.simulation.task.wheel_revolutions
    variables = variation.choices.variables
    dressed = any(each.name == "D" and each.own for each in variables)
    first = next((each for each in variables if each.name == "D"), None)

    def level(each: SearchVariable) -> Decimal:
        if each.name == "D":
            return max(each.own, Decimal(1)) if each.own or (each is first and not dressed) else each.own
        values = {"E": float(each.own) * best.E / own.E, "lead": 60.0 * best.lead * turns, "depth": best.depth}
        unit, step = each.unit if each.name != "E" else Decimal(1), EXACT[each.name][each.unit != 1]
        return max(step, (Decimal(repr(values[each.name])) / unit / step).to_integral_value() * step)

    chosen = tuple(replace(each, levels=(level(each),)) for each in variables)
    return variation._replace(choices=variation.choices._replace(variables=chosen))
