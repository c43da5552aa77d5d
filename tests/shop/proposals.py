"""What machines that are not the model make of a program that `grind init` proposes, and of the words of the rules.

    python -m tests.shop.proposals foreign:1 meter:2     # these machines, all parts

A row for each part and machine: share of good parts, that on the worst machine, and $ a part with the words of the
rules alone and with those proposed. Without machines it takes seeds 1 to 3 of seven families, and machines that are
drawn of what is not known.
"""

import sys
from collections.abc import Sequence
from typing import NamedTuple

from grind_env.control import read
from grind_env.machine.job import Job
from grind_env.machine.job.worlds import known_of, worlds
from grind_env.plants import find_plant
from grind_env.shop.start.folder import PROGRAM
from grind_env.shop.start.program import program_text
from grind_env.shop.start.proposal import proposal_of
from grind_env.shop.start.proposed import Asked, task_of
from grind_env.shop.start.rules import first_words
from grind_env.shop.trials import LotUse, lots_of, trials_of
from tests.shop.promises import FAMILIES, SEEDS

DRAWN, LOTS = 96, 16
PARTS = (
    Asked(material="aisi_52100", wheel="a60j"),
    Asked(material="aisi_d2", wheel="sg60j", Ra=0.8, tolerance=12.0),
    Asked(material="inconel_718", wheel="b126", Ra=0.8, tolerance=15.0),
    Asked(material="aisi_1045", wheel="a46h", Ra=0.8, width=60.0, length=300.0),
)


class Ground(NamedTuple):
    """What machines make of a program."""

    good: float
    """Share of good parts."""
    cost: float
    """$ a part."""
    worst: float
    """Share of good parts on the worst of them."""


def ground(text: str, job: Job, machines: Sequence[Job] = (), lots: int = LOTS, parts: int = 50) -> Ground:
    """What machines, or that of the job, make of a program, in batches of parts on lots that no search has seen."""
    seeds = lots_of(7, LotUse.JUDGEMENT, max(lots, len(machines)))
    trials = trials_of(read(text, PROGRAM), job, parts, seeds[:1]).on(seeds, machines)
    found = trials.measure(trials.own[None], handover=False)
    worst = float(trials.by_machine(found.scrap).max())
    return Ground(1.0 - float(found.scrap.mean()), float(found.cost.mean()), 1.0 - worst)


def drawn(job: Job, count: int = DRAWN) -> tuple[Job, ...]:
    """Machines of what is not known of that of a job, with which nothing was searched."""
    return worlds(job, known_of(job), 987, count)


def by_rules(job: Job) -> str:
    """The program of the rules alone."""
    return program_text(job, first_words(job))


def main(names: Sequence[str]) -> None:
    """Print the table."""
    plants = names or [f"{family}:{seed}" for family in FAMILIES for seed in SEEDS]
    for asked in PARTS:
        job = task_of(asked).job
        found = proposal_of(job, seconds=30.0, seed=1)
        print(f"{asked}\n{found.words}; {found.evaluations} programs tried")
        good, cost = found.good, found.cost
        print(f"{'promised':12} {'':22} {said(Ground(good.value, cost.value, good.low))}")
        texts = by_rules(job), found.text
        rows = {"drawn": [ground(text, job, drawn(job)) for text in texts]} if not names else {}
        rows |= {name: [ground(text, job.on(find_plant(name))) for text in texts] for name in plants}
        for name, row in rows.items():
            print(f"{name:12} {'  '.join(map(said, row))}")


def said(row: Ground) -> str:
    """A part of a row."""
    return f"{100.0 * row.good:5.1f} ({100.0 * row.worst:5.1f}) %{row.cost:6.2f} $"


if __name__ == "__main__":
    main(sys.argv[1:])
