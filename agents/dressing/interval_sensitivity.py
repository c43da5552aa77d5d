"""Study of the best dress interval of two example programs, with one machine number at an end of its range."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from agents.benchmark.figures import COLOURS, DPI, GREY, plain, write_figure
from agents.evaluation_cache import sources
from agents.plants.trials import DATA
from agents.study import Found, Study, StudyOptions
from grind_env import examples
from grind_env.files import read_text
from grind_env.machine.job.drawn_machines import USUAL_RESIDUAL, USUAL_SPREADS, value_of
from grind_env.machine.job.job_entries import entries_of, with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.uncertainty import CERTAIN
from grind_env.shop.sweep.study import SweepRanges, cheapest, sweep

PROGRAMS, RANGES, PARTS = ("plate_g82", "rail_g83"), SweepRanges(E=(10_000.0, 30_000.0), every=(1, 16)), 30
NOMINAL, ALL = "nominal", "all at once"
#: standard deviations from the catalogue's number to the ends of its range, which holds 90 of 100 machines
ENDS = {"low": -1.645, "high": 1.645}
SPREADS = {**USUAL_SPREADS, "material.power_factor": USUAL_RESIDUAL}
#: ends of numbers without a spread: part height in the job, mm; thermal expansion of the catalogue's steels, 1/K
STATED = {"part.height": (10.0, 40.0), "material.thermal_expansion": (10.5e-6, 13e-6)}
PICTURE = "figures/intervals.png"
PAGE = f"[How to read it](../../docs/benchmark/dress-study.md)\n\n![Best interval and loss by number]({PICTURE})"


@dataclass(frozen=True)
class UnknownTrial:
    """Sweep of an example on a machine with one number changed, none (`NOMINAL`), or all drawn (`ALL`)."""

    program: str
    number: str
    end: str = ALL
    value: float = math.nan


class Answer(NamedTuple):
    """Best plan of a trial: E, mm/min; its cost and the nominal plan's, $ per part; loss of the nominal plan, %."""

    program: str
    number: str
    end: str
    value: float
    E: float
    every: int
    cost: float
    plan_cost: float
    lost: float
    plan_keeps_limits: bool


def study(asked: StudyOptions) -> Study:
    """Return the study: each program with nominal numbers, with each number at both ends, and with all of them."""
    return Study(
        name="intervals",
        title="Best dress interval against each unknown number",
        trials=list(trials()),
        run=find,
        columns=Answer._fields,
        rows=answers,
        page=lambda found: PAGE,
        draw=lambda found, folder: write_figure(intervals_figure(answers(found)), folder / PICTURE),
        episodes=0,
        decides=lambda trial: [
            sources(sweep.__module__, ("grind_env.",)),
            *map(read_text, sorted(DATA.rglob("*.toml"))),
        ],
        trains=False,
    )


def trials() -> Iterator[UnknownTrial]:
    """Return the trials, program by program."""
    for program in PROGRAMS:
        entries = entries_of(load_job(examples.path(f"{program}.toml")))
        yield UnknownTrial(program, NOMINAL, NOMINAL)
        for number, spread in SPREADS.items():
            for end, deviations in ENDS.items():
                value = value_of(entries, number) * math.exp(deviations * spread)
                yield UnknownTrial(program, number, end, float(f"{value:.4g}"))
        for number, values in STATED.items():
            yield from (UnknownTrial(program, number, end, value) for end, value in zip(ENDS, values, strict=True))
        yield UnknownTrial(program, ALL)


def find(trial: UnknownTrial) -> dict[str, Any]:
    """Return the points of a sweep, and the index of the best point."""
    job = load_job(examples.path(f"{trial.program}.toml"))
    kind, _, key = trial.number.partition(".")
    if kind == "part":
        changed: Any = {key: trial.value}
        job = replace(job, part=replace(job.part, **changed))
    elif key:
        job = with_entries(job, {kind: {key: trial.value}})
    job = job if trial.end == ALL else replace(job, uncertainty=CERTAIN)
    points = sweep(examples.path(f"{trial.program}.nc"), job, RANGES, parts=PARTS).speeds
    shown = [(each.E, each.every, each.cost.value, each.keeps_limits) for each in points]
    return {"best": points.index(cheapest(points)), "points": shown}


def answers(found: Found) -> list[Answer]:
    """Return the rows of the table."""
    plans = {trial.program: each["best"] for trial, each in found.items() if trial.end == NOMINAL}
    rows = []
    for trial, each in found.items():
        E, every, cost, _ = each["points"][each["best"]]
        *_, plan_cost, keeps = each["points"][plans[trial.program]]
        numbers = round(E), every, round(cost, 4), round(plan_cost, 4), round(100.0 * (plan_cost / cost - 1.0), 1)
        rows.append(Answer._make((*astuple(trial), *numbers, keeps)))
    return rows


def intervals_figure(rows: Sequence[Answer]) -> Figure:
    """Draw the best interval at both ends of each number, and the loss of the nominal plan, one panel per program."""
    rows, ticks = sorted(rows, key=lambda row: row.lost, reverse=True), (1, 2, 4, 8, 16)
    numbers = [*dict.fromkeys(row.number for row in rows if row.number not in (NOMINAL, ALL)), ALL]
    marks = {"low": ("v", -0.17), "high": ("^", 0.17), ALL: ("D", 0.0)}
    figure = Figure(figsize=(7.2, 0.8 + 0.4 * len(numbers)), dpi=DPI, layout="constrained")
    for program, panel in zip(PROGRAMS, figure.subplots(1, len(PROGRAMS), sharey=True), strict=True):
        for row in (each for each in rows if each.program == program):
            if row.end == NOMINAL:
                panel.axvline(row.every, color=GREY, ls="--", lw=1.0, zorder=0)
                continue
            (mark, shift), colour = marks[row.end], COLOURS[[*marks].index(row.end)]
            at = row.every, numbers.index(row.number) + shift
            panel.plot(*at, mark, color=colour)
            if row.lost >= 2.0:
                said = f"   {row.lost:.0f} %{'' if row.plan_keeps_limits else ' *'}"
                panel.annotate(said, at, color=colour, va="center")
        plain(panel, "x")
        panel.set_xscale("log", base=2)
        panel.set_xticks(ticks, map(str, ticks))
        panel.set_yticks(range(len(numbers)), [each.rpartition(".")[2].replace("_", " ") for each in numbers])
        panel.set(title=program, xlabel="parts from dress to dress", xlim=(0.8, 40.0), ylim=(len(numbers) - 0.4, -0.6))
    return figure
