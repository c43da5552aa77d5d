"""The scores of the track from its checked-in table."""

import csv
import io
from pathlib import Path

import numpy as np

from agents.cells import RESULTS
from agents.track.knowing import ANCHORS
from agents.track.page import CSV
from agents.track.study import TASK
from grind_env.files import read_text
from grind_env.policies.statistics import RESAMPLES, Interval, percentile_interval, score_of_means

SHOWN = (0, 300)
"""Blocks on a machine behind which adapters are judged, of those that are shown."""


def on_plants(folder: Path = RESULTS, task: str = TASK) -> dict[tuple[str, int], Interval]:
    """Mean score of every adapter over the machines, and after how many blocks; none where there is no table.

    The interval is of the machines alone: the table has no episodes.
    """
    if not (folder / CSV).exists():
        return {}
    costs: dict[tuple[str, int], dict[str, list[float]]] = {}
    for row in csv.DictReader(io.StringIO(read_text(folder / CSV))):
        if row["task"] == task and int(row["blocks"]) in SHOWN:
            of = costs.setdefault((row["adapter"], int(row["blocks"])), {})
            of.setdefault(row["plant"], []).append(float(row["cost"]))
    found = {}
    for (name, blocks), of in costs.items():
        anchors = [costs.get((anchor, blocks), {}) for anchor in ANCHORS]
        machines = [plant for plant in of if all(plant in each for each in anchors)]
        if machines and name not in ANCHORS:
            scores = score_of_means(
                *(np.array([np.mean(each[plant]) for plant in machines]) for each in (of, *anchors))
            )
            index = np.random.default_rng(0).integers(0, len(scores), (RESAMPLES, len(scores)))
            found[name, blocks] = percentile_interval(float(scores.mean()), scores[index].mean(axis=1))
    return found
