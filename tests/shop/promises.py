"""What `grind optimise` promises, and what machines that are not the model make of it.

    python -m tests.shop.promises foreign:1 meter:2       # these machines, all programs
    python -m tests.shop.promises --calibrated world:0 world:1   # with an `[uncertainty]` table written by hand, on
                                                                 # machines that are drawn of it

A row for each machine and program: what a part costs there with the program as it was and with the words found, what
was promised of it, and its scrap. Without machines it takes seeds 1 to 3 of seven families; bursts and graded are kept
for the study that nothing is tuned on.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from grind_env.control import read
from grind_env.machine.job import Job
from grind_env.machine.job.file import load_job
from grind_env.machine.job.worlds import known_of, worlds
from grind_env.plants import find_plant
from grind_env.shop.calls import optimise
from grind_env.shop.optimise.outcome import Optimised
from grind_env.shop.trials import LotUse, lots_of, trials_of
from tests.shop.programs import EXAMPLES

FAMILIES = "foreign", "thermal", "meter", "table", "fluid", "soft", "drift"
SEEDS = 1, 2, 3
PROGRAMS = "plate_g82", "keyway_g81", "rail_g83"
TABLE = """source = "written by hand"
names = ["material.ploughing_pressure", "material.wear_flat_growth", "wheel.roughness", "machine.stiffness"]
spread = [0.05, 0.1, 0.03, 0.05]
correlation = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
residual = 0.03
drift = 0.005
"""


class Kept(NamedTuple):
    """What has come of a promise; costs in $ a part, scrap in %."""

    plant: str
    program: str
    verdict: str
    before: float
    """On the machine, with the program as it was."""
    low: float
    """Least that is promised of the words found."""
    high: float
    after: float
    """On the machine."""
    scrap_before: float
    scrap: float

    @property
    def within(self) -> bool:
        """Whether the promise is kept."""
        return self.low <= self.after <= self.high


def job_text(program: str, *, calibrated: bool) -> str:
    """The job of an example, with the table written by hand or without."""
    text = (EXAMPLES / f"{program}.toml").read_text()
    return f"{text}\n[catalogue.uncertainty]\n{TABLE}" if calibrated else text


def found_for(job: Path, parts: int = 50, budget: float = 20.0) -> Optimised:
    """The words that are found on the model."""
    return optimise(EXAMPLES / f"{job.stem}.nc", job, parts=parts, budget=budget)


def machine_of(job: Path, name: str) -> Job:
    """A plant, or `world:N`, a machine that is drawn from what is not known, and with which nothing was searched."""
    family, _, number = name.partition(":")
    if family != "world":
        return load_job(job, plant=find_plant(name))
    held = load_job(job)
    return worlds(held, known_of(held), 987, int(number) + 1)[-1]


def kept(found: Optimised, job: Job, plant: str) -> Kept:
    """What a machine makes of the program that one ends up with."""
    lots = lots_of(7, LotUse.JUDGEMENT, 128)
    trials = [trials_of(read(text, found.program), job, found.parts, lots) for text in (found.before, found.after)]
    old, new = (each.measure(each.own[None]) for each in trials)
    cost = found.quantity("cost")
    promised = cost.after if found.verdict.is_written else cost.before
    return Kept(
        plant=plant,
        program=found.program,
        verdict=found.verdict.name.lower(),
        before=float(old.cost.mean()),
        low=promised.low,
        high=promised.high,
        after=float(new.cost.mean()),
        scrap_before=100.0 * float(old.scrap.mean()),
        scrap=100.0 * float(new.scrap.mean()),
    )


def main(arguments: list[str]) -> None:
    """Print the table."""
    plants = [each for each in arguments if not each.startswith("-")]
    plants = plants or [f"{family}:{seed}" for family in FAMILIES for seed in SEEDS]
    calibrated = "--calibrated" in arguments
    print(f"{'machine':12} {'program':14} {'verdict':12} before promised         after  kept  scrap % before, after")
    with TemporaryDirectory() as folder:
        for program in PROGRAMS:
            job = Path(folder) / f"{program}.toml"
            job.write_text(job_text(program, calibrated=calibrated))
            found = found_for(job)
            for plant in plants:
                print(said(kept(found, machine_of(job, plant), plant)), flush=True)


def said(row: Kept) -> str:
    """A row of the table."""
    return (
        f"{row.plant:12} {row.program:14} {row.verdict:12} {row.before:6.2f} {row.low:6.2f} to {row.high:6.2f} "
        f"{row.after:6.2f}  {'yes' if row.within else 'no':4} {row.scrap_before:6.2f} {row.scrap:6.2f}"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
