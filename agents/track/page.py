"""Tables of the track: a page, and a row for every run."""

from collections.abc import Iterator, Mapping
from math import isnan

import numpy as np

from agents.track.scale_anchors import PLAN, PLANNER, TRAINED
from agents.track.scores import Anchors, Ground, points, summary
from grind_env.array_types import Array
from grind_env.data_table import table_of
from grind_env.policies.track import BASELINE, SHIFTS, TASK

RUN = ("task", "plant", "adapter", "seed")
#: columns of the CSV: cost per block, $, scrap share and CPU time, s, of a run; cost per block of each shift, $
COLUMNS = (*RUN, "cost", "scrap", "cpu_seconds", *(f"cost_{k}" for k in range(1, SHIFTS + 1)))
WHAT = f"""\
Each policy grinds {SHIFTS} shifts of 60 blocks on each of {{machines}} machines, with the lots of {{seeds}} seeds. All
blocks count. `{PLAN}`, `{PLANNER}` and `{TRAINED}` are privileged: they are tuned or trained on the machine itself, and
the planner sees its state. `{TRAINED}` is the mean of its trainings. Intervals are 95 %: machines and seeds are
resampled."""
GAIN = f"""\
0 is the bundled `{BASELINE}`, 100 is `{TRAINED}`, an agent trained on that machine alone from measurements. *Of sums*
is the gain of the costs summed over machines. A machine on which `{TRAINED}` is no cheaper than `{BASELINE}` counts in
the sums only. CPU time is that of a run."""
SCORE = """\
0 is the best fixed plan, tuned on the machine. 100 is the bound: the cheapest of all policies that had been run on the
machine, the planner among them, when `track_anchors.csv` was frozen."""
SCORES = "mean", "median", "of sums"


def rows(ground: Ground) -> Iterator[list[object]]:
    """Yield a row for the run of every seed."""
    for plant, names in ground.items():
        for name, (runs, _, seconds) in names.items():
            scrap = runs.scrap.sum(axis=1) / runs.parts.sum(axis=1)
            for seed, cost in enumerate(runs.cost):
                numbers = cost.mean(), scrap[seed], seconds, *cost
                yield [TASK, plant, name, seed, *(f"{number:.6g}" for number in numbers)]


def page(ground: Ground, anchors: Mapping[str, Anchors]) -> str:
    """Return the tables as Markdown."""
    of_all = set.intersection(*({*names} for names in ground.values()))
    names, shifts = (
        [name for name in next(iter(ground.values())) if name in of_all],
        [f"{k}" for k in range(1, SHIFTS + 1)],
    )
    # shape (3, machines, seeds, shifts): cost per block in $, bad parts, parts
    runs = {name: np.stack([np.stack(of[name].runs) for of in ground.values()], axis=1) for name in names}
    cost = {name: each[0].mean(axis=2) for name, each in runs.items()}
    plan, robust, trained, bound = (np.stack(each) for each in list(zip(*anchors.values(), strict=True))[:4])
    seconds = {name: np.mean([of[name].cpu_seconds for of in ground.values()]) for name in names}

    def scores(name: str, zero: Array, hundred: Array) -> list[str]:
        return ["" if isnan(each.value) else f"{each:.0f}" for each in summary(cost[name], zero, hundred)]

    def scrap(name: str, axis: tuple[int, ...]) -> list[str]:
        _, bad, parts = runs[name].sum(axis=axis)
        return [f"{share:.2f}" for share in np.atleast_1d(100.0 * bad / parts)]

    def gain(name: str, k: int) -> str:
        value = points(cost[name][k].mean(), robust[k].mean(), trained[k].mean())
        return "" if isnan(value) else f"{value:.0f}"

    ratio = {name: f"{each.sum() / robust.sum():.3f}" for name, each in cost.items()}
    others = [name for name in names if name not in (PLAN, PLANNER, TRAINED, BASELINE)]
    tables = [
        (
            f"## Adaptation gain\n\n{GAIN}",
            ("policy", *SCORES, f"cost / {BASELINE}", "scrap, %", "CPU-s"),
            [
                (name, *scores(name, robust, trained), ratio[name], *scrap(name, (1, 2, 3)), f"{seconds[name]:.1f}")
                for name in names
            ],
        ),
        (
            f"## Track score\n\n{SCORE}",
            ("policy", *SCORES),
            [(name, *scores(name, plan, bound)) for name in names],
        ),
        (
            "## Machines: $ a block and adaptation gain",
            ("machine", PLAN, BASELINE, TRAINED, "bound", "set by", *others),
            [
                (plant, *(f"{each.mean():.3f}" for each in of[:4]), of.bound_by, *(gain(name, k) for name in others))
                for k, (plant, of) in enumerate(anchors.items())
            ],
        ),
        (
            "## $ a block, shift by shift",
            ("policy", *shifts),
            [(name, *(f"{each:.3f}" for each in runs[name][0].mean(axis=(0, 1)))) for name in names],
        ),
        (
            "## Scrap, %, shift by shift",
            ("policy", *shifts),
            [(name, *scrap(name, (1, 2))) for name in names],
        ),
    ]
    parts = [WHAT.format(machines=len(anchors), seeds=robust.shape[1])]
    return "\n\n".join([*parts, *(f"{said}\n\n{table_of(columns, body).markdown()}" for said, columns, body in tables)])
