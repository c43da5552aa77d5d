"""Shop commands on foreign machines: `python -m tests.foreign` prints the table of the docs.

Costs are $ a part, the mean of 8 shifts or lots of 30 parts; all on the same seeds.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.foreign.shop import SHOPS, Cost, Part, PowerLaw, Shop, cost, depths_of, plans, shift, volumes_of
from tests.foreign.tools import advised_shift, calibrated, ground_cost, optimised

SEEDS = range(100, 108)
HEADER = (
    "machine",
    "program as it is",
    "best of 15 fixed plans",
    "power law",
    "`advise`",
    "`advise`, scrap",
    "`optimise`",
    "fit",
    "`advise`, calibrated",
    "`optimise`, calibrated",
)


def shifts(shop: Shop, ground: Callable[[int], list[Part]]) -> Cost:
    """Return the cost of the parts of all shifts."""
    return cost(shop, [part for seed in SEEDS for part in ground(seed)])


def optimised_cost(shop: Shop, folder: Path, job: Path) -> str:
    """Return the cost of a part after `optimise`, and its promised interval, as text."""
    found = optimised(shop, folder, job)
    return "stopped" if found is None else f"{found.after:.2f} ({found.low:.2f} to {found.high:.2f})"


def row(shop: Shop, folder: Path) -> list[str]:
    """Return the table row of a machine."""
    job = shop.write(folder)
    depths = depths_of(folder / "one.nc", job)
    fixed = min(shifts(shop, partial(shift, shop, depths, plan)).each for plan in plans(shop))
    ruled = shifts(shop, lambda seed: shift(shop, depths, PowerLaw(shop, volumes_of(shop)), seed))
    advised = shifts(shop, lambda seed: advised_shift(shop, folder, job, seed))
    found = [ground_cost(shop, folder / "lot.nc", job), fixed, ruled.each, advised.each]
    cells = [shop.name, *(f"{each:.2f}" for each in found), f"{advised.scrap:.1%}", optimised_cost(shop, folder, job)]
    fitted = calibrated(folder, job)
    if fitted is None:
        return [*cells, "refused", "", ""]
    again = shifts(shop, lambda seed: advised_shift(shop, folder, fitted, seed))
    return [*cells, "may be used", f"{again.each:.2f}", optimised_cost(shop, folder, fitted)]


def main(names: list[str]) -> None:
    """Print the table of the named machines, or of all."""
    print(f"| {' | '.join(HEADER)} |\n|{' --- |' * len(HEADER)}")
    for name in names or SHOPS:
        with TemporaryDirectory() as folder:
            print(f"| {' | '.join(row(SHOPS[name], Path(folder)))} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
