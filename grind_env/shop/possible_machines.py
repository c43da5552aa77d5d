"""Possible machines of a job, drawn from its uncertainty, on which the unchanged program grinds good parts."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grind_env.array_types import Array
from grind_env.errors import GrindError
from grind_env.kernel import compile_at_once
from grind_env.kernel.random import WORD
from grind_env.machine.job import Job
from grind_env.machine.job.drawn_machines import draw_machine, uncertainty_of
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.plants import find_plant
from grind_env.process.process_interface import PROCESS
from grind_env.shop.trials import LotUse, Measures, Trials

#: number of machines on which programs are tried, for each use; fewer if there are fewer lots
MACHINES = {LotUse.SEARCH: 32, LotUse.COMPARISON: 256, LotUse.JUDGEMENT: 256, LotUse.SWEEP: 128}
#: index of the first machine of each use; indices beyond the last machine begin again at the first
FIRST = {LotUse.SEARCH: 0, LotUse.COMPARISON: 32, LotUse.JUDGEMENT: 288, LotUse.SWEEP: 160}
NEEDED = 416

AT_ONCE, MOST_DRAWN = 64, 768  #: number of machines drawn at once, and in total at most
#: factors on the variation of lots and parts; the first one is used with which enough machines grind good parts
SPREADS = 1.0, 0.7, 0.5, 0.35
#: rounds in which a machine must grind good parts with the unchanged program; parts of a round, and lots at most
ROUNDS, PARTS_EACH, MOST_LOTS = 4, 50, 8
#: good parts that the shop is assumed to have ground with the program, even if the model predicts scrap
SEEN_GOOD = 200
LEAST = 16  #: least number of machines; if fewer grind good parts, the machines with the least scrap are taken instead
#: share of scrap from which on the model condemns a program; half of the drawn machines must reach it, too
CONDEMNED = 0.5

#: share of scrap from which on a program is condemned on the machines that agree best with its good parts
EVEN_AGREEING = 0.05


class CondemnedError(GrindError):
    """Program whose parts are good at the machine, but scrap in the model."""

    status = 3

    def __init__(self, scrap: float) -> None:
        super().__init__(
            f"The model says this program scraps {100.0 * scrap:.0f} % of its parts. If it does not, the model is "
            "wrong: calibrate it, or state in the job the limits and the share of heat of this machine, or grind fewer "
            "--parts with a wheel. If the program was never ground here, say --untried."
        )


@dataclass(frozen=True, slots=True)
class Fleet:
    """Possible machines of a job."""

    uncertainty: Uncertainty  #: uncertainty from which the machines are drawn
    seed: int  #: seed of the draws
    numbers: tuple[int, ...]  #: indices of the machines among all draws
    drawn: int = 0  #: number of draws; 0 if the machines need not grind good parts
    agree: int = 0  #: number of draws that grind good parts with the unchanged program
    spread: float = 1.0  #: factor on the variation of lots and parts, inferred from good parts

    def trials_for(self, trials: Trials, use: LotUse, seeds: Sequence[tuple[int, ...]]) -> Trials:
        """Return trials on lots and machines; each use has its own machines if there are 544 or more.

        A search tries thousands of programs: its machines obey the laws of the model, which takes a quarter less time.
        The machines of the other uses may obey other laws.
        """
        first, count = FIRST[use], min(MACHINES[use], len(seeds), len(self.numbers))
        numbers = [self.numbers[k % len(self.numbers)] for k in range(first, first + count)]
        job, root = trials.simulation.job, self.uncertainty.root
        drawn = draw_machine if use is LotUse.SEARCH else machine
        machines = [drawn(job, self.uncertainty, root, self.seed, number) for number in numbers]
        return trials.spread_by(self.spread).with_lots(seeds, machines, self.uncertainty.drift)


def fleet_of(
    trials: Trials, seed: int, *, untried: bool, needed: int = NEEDED, is_up: Callable[[], bool] = lambda: False
) -> Fleet | None:
    """Return the possible machines of a job on which its program grinds good parts.

    This test takes too long for a program that the control executes step by step. Without a calibration, None is
    returned for such a program.
    """
    job = trials.simulation.job
    uncertainty = uncertainty_of(job)
    every = Fleet(uncertainty, seed, (0,) if uncertainty.is_certain else tuple(range(NEEDED)))
    if not trials.simulation.compiled:
        return None if job.uncertainty is None else every
    if untried:
        return every
    evidence = GoodParts(trials, uncertainty, seed)
    scrap = evidence.scrap_of({0: job}, 0.0, 0)[0]
    if uncertainty.is_certain and scrap >= CONDEMNED:
        raise CondemnedError(scrap)
    if uncertainty.is_certain:
        return every
    for spread in SPREADS:
        evidence = GoodParts(trials.spread_by(spread), uncertainty, seed)
        agree, scraps = list[int](), dict[int, float]()
        while len(agree) < needed and len(scraps) < MOST_DRAWN and not (scraps and is_up()):
            numbers = range(len(scraps), len(scraps) + AT_ONCE)
            agree += evidence.agreeing(numbers, scraps)
            if min(scrap, float(np.median([*scraps.values()]))) >= CONDEMNED:
                raise CondemnedError(scrap)
        if len(agree) >= LEAST or is_up():
            break
    nearest = sorted(scraps, key=lambda k: (scraps[k], k))[:LEAST]
    return Fleet(uncertainty, seed, tuple(agree if len(agree) >= LEAST else nearest), len(scraps), len(agree), spread)


def require_good(fleet: Fleet | None, old: Measures, *, untried: bool) -> None:
    """Raise a CondemnedError if a program is scrap even on the machines that agree best with its good parts."""
    # with little time few machines are drawn, and the nearest of these may be far from good parts
    searched = fleet is not None and (fleet.agree >= LEAST or fleet.drawn >= MOST_DRAWN)
    most = EVEN_AGREEING if searched else CONDEMNED
    if not untried and (scrap := float(old.scrap.mean())) >= most:
        raise CondemnedError(scrap)


class GoodParts:
    """Likelihood of the good parts on a machine."""

    def __init__(self, trials: Trials, uncertainty: Uncertainty, seed: int) -> None:
        self.trials, self.uncertainty, self.seed = trials, uncertainty, seed
        self.lots = min(-(-PARTS_EACH // trials.simulation.parts), MOST_LOTS)

    def agreeing(self, numbers: Sequence[int], scraps: dict[int, float]) -> list[int]:
        """Return a sample of machines, each accepted with the likelihood of good parts on it; `scraps` gets the scrap.

        A rejected machine grinds no further rounds.
        """
        job, root = self.trials.simulation.job, self.uncertainty.root
        left = {k: machine(job, self.uncertainty, root, self.seed, k) for k in numbers}
        chances = {k: np.random.default_rng((self.seed, k, 1)).random() for k in numbers}
        likely = dict.fromkeys(numbers, 1.0)
        for number in range(ROUNDS):
            scrap = self.scrap_of(left, self.uncertainty.drift, number)
            for k, share in zip(list(left), scrap, strict=True):
                scraps[k] = max(scraps.get(k, 0.0), share)
                likely[k] *= (1.0 - share) ** (SEEN_GOOD / ROUNDS)
                if likely[k] < chances[k]:
                    del left[k]
            if not left:
                break
        return list(left)

    def scrap_of(self, machines: Mapping[int, Job], drift: float, number: int) -> list[float]:
        """Return the share of scrap of the unchanged program on machines by their numbers, in a round.

        Each machine has its own lots: with the same lots for all, the seed would decide how many machines agree.
        """
        seeds = [(self.seed, int(LotUse.BASE), number, k, lot) for lot in range(self.lots) for k in machines]
        on = self.trials.with_lots(seeds, [*machines.values()], drift)
        return [*map(float, on.by_machine(on.measure(on.own[None]).scrap)[0])]


def machine(job: Job, uncertainty: Uncertainty, root: Array, seed: int, number: int) -> Job:
    """Return a possible machine by number; if the job does not fix its laws, the laws of a `public` machine."""
    drawn = draw_machine(job, uncertainty, root, seed, number)
    return (
        drawn.on(find_plant("public", seed=(seed * MOST_DRAWN + number) & WORD))
        if job.uncertainty is None and not job.plant and job.process is PROCESS
        else drawn
    )


def compile_all(once: Trials) -> None:
    """Compile the code for trials of a program, on machines with the laws of the model and with other laws."""
    job = once.simulation.job
    if once.simulation.compiled:
        compile_at_once()
        known = uncertainty_of(job)
        for draw in (draw_machine, machine):
            once.with_lots(once.seeds, [draw(job, known, known.root, 0, 0)]).measure(once.own[None])
