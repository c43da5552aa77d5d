"""On which machines programs are tried: those that the job may be of, in which its program grinds good parts."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from grind_env.arrays import Array
from grind_env.kernel.random import WORD
from grind_env.machine.job import Job
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.machine.job.worlds import known_of, world
from grind_env.plants import find_plant
from grind_env.process.process import PROCESS
from grind_env.shop.trials import LotUse, Trials, lots_of

MACHINES = {LotUse.SEARCH: 32, LotUse.COMPARISON: 256, LotUse.JUDGEMENT: 128, LotUse.SWEEP: 128}
"""On which programs are tried for each use; on fewer where there are fewer lots."""
FIRST = {LotUse.SEARCH: 0, LotUse.COMPARISON: 32, LotUse.JUDGEMENT: 288, LotUse.SWEEP: 0}
"""Place of the first of them: those of a search are no other's, if there are enough."""
NEEDED = 416

AT_ONCE, MOST_DRAWN = 64, 768
"""Machines that are drawn at once, and at most."""
ROUNDS, PARTS_EACH, MOST_LOTS = 4, 50, 8
"""In how many rounds it is seen whether a machine grinds good parts with the program as it is, and parts of each, on so
many lots at most."""
SEEN_GOOD = 200
"""Parts that the shop has ground with it and found good, at most: of machines with .1 % scrap that is met on four in
five, with 1 % on one in seven."""
LEAST_BELIEVED = 0.5
"""Of the machine of the job, which so many good parts must not make less likely: where the model itself has scrap,
fewer of them are taken to have been good."""
LEAST = 16
"""Machines on which all are good, without which the program tells nothing."""


@dataclass(frozen=True, slots=True)
class Fleet:
    """Machines that may be that of a job.

    Attributes:
        uncertainty: of which they are drawn.
        seed: likewise.
        numbers: of those on which the program grinds good parts, among all that were drawn.
        drawn: how many that were; 0 if nothing was asked of them.
    """

    uncertainty: Uncertainty
    seed: int
    numbers: tuple[int, ...]
    drawn: int = 0

    def count(self, use: LotUse, seeds: Sequence[tuple[int, ...]]) -> int:
        """How many machines a use has on so many lots."""
        return min(MACHINES[use], len(seeds), len(self.numbers))

    def under(self, trials: Trials, use: LotUse, seeds: Sequence[tuple[int, ...]]) -> Trials:
        """Trials on lots and on the machines of a use, other ones for each if there are enough.

        A search tries thousands of programs: it has the laws of the model, which take a quarter less time. What it
        finds is compared and judged on all that the machine may be.
        """
        places = [(FIRST[use] + k) % len(self.numbers) for k in range(self.count(use, seeds))]
        job, root = trials.simulation.job, self.uncertainty.root
        drawn = world if use is LotUse.SEARCH else machine
        machines = [drawn(job, self.uncertainty, root, self.seed, self.numbers[place]) for place in places]
        return trials.on(seeds, machines, self.uncertainty.drift)


def fleet_of(trials: Trials, seed: int, *, untried: bool, is_up: Callable[[], bool] = lambda: False) -> Fleet | None:
    """Machines that may be that of the job of some trials.

    On how many of them a program that the control executes grinds good parts takes too long to see. Without a
    calibration nothing is left of such a program on all that the catalogue allows, and it is None.

    Args:
        trials: of the program as it is.
        seed: of the machines.
        untried: whether nothing is known of how it grinds there.
        is_up: whether there is no time to look at more of them, or at more parts of these.
    """
    job = trials.simulation.job
    uncertainty = known_of(job)
    if uncertainty.is_certain:
        return Fleet(uncertainty, seed, (0,))
    every = Fleet(uncertainty, seed, tuple(range(NEEDED)))
    if not trials.simulation.compiled:
        return None if job.uncertainty is None else every
    if untried:
        return every
    root, numbers, drawn = uncertainty.root, list[int](), 0
    own = float(np.mean([good_on(trials, [job], 0.0, seed, number) for number in range(ROUNDS)]))
    seen = min(SEEN_GOOD, math.log(LEAST_BELIEVED) / math.log(own)) if 0.0 < own < 1.0 else SEEN_GOOD * own
    while len(numbers) < NEEDED and drawn < MOST_DRAWN and not (numbers and is_up()):
        left = {k: machine(job, uncertainty, root, seed, k) for k in range(drawn, drawn + AT_ONCE)}
        chances = {k: np.random.default_rng((seed, k, 1)).random() for k in left}
        likely = dict.fromkeys(left, 1.0)
        for number in range(ROUNDS):
            if not left or (number and is_up()):
                break
            good = good_on(trials, list(left.values()), uncertainty.drift, seed, number)
            for k, share in zip(list(left), good, strict=True):
                likely[k] *= share ** (seen / ROUNDS)
                if likely[k] < chances[k]:
                    del left[k]
        numbers += left
        drawn += AT_ONCE
    return Fleet(uncertainty, seed, tuple(numbers), drawn) if len(numbers) >= LEAST else every


def machine(job: Job, uncertainty: Uncertainty, root: Array, seed: int, number: int) -> Job:
    """One of the `worlds`; where it may obey other laws, those of a `public` machine."""
    drawn = world(job, uncertainty, root, seed, number)
    return drawn.on(find_plant("public", seed=(seed * MOST_DRAWN + number) & WORD)) if other_laws(job) else drawn


def other_laws(job: Job) -> bool:
    """Whether the machine of a job may obey others than the model's: it has no calibration, no name, no own process."""
    return job.uncertainty is None and not job.plant and job.process is PROCESS


def compile_other_laws(once: Trials) -> None:
    """Let what a run of a program takes on machines of other laws be compiled, where its machine may obey them."""
    job = once.simulation.job
    if other_laws(job) and once.simulation.compiled:
        once.on(once.seeds, [job.on(find_plant("public", seed=0))]).measure(once.own[None])


def good_on(trials: Trials, machines: list[Job], drift: float, seed: int, number: int) -> list[float]:
    """Share of good parts of the program as it is on each machine, in a round by its number with lots of its own."""
    each = min(-(-PARTS_EACH // trials.runs), MOST_LOTS)
    lots = lots_of(seed, LotUse.BASE, (number + 1) * each)[number * each :]
    seeds = [lot for lot in lots for _ in machines]
    if trials.simulation.job.parts:
        seeds = seeds[: len(machines)]
    on = trials.on(seeds, machines, drift)
    good: list[float] = (1.0 - on.by_machine(on.measure(on.own[None]).scrap)[0]).tolist()
    return good
