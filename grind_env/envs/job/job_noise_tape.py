"""The noise tape of an episode of a user's job, drawn in full at reset from the key of the episode.

The spreads are those of the tasks or of the job's `[lots]`: every wheel, coolant and lot of material differs somewhat
from the catalogue, and gauges are noisy.
"""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Table
from grind_env.belief.filter_quantities import FACTORS
from grind_env.envs.distribution_splits import Draws, draws_of
from grind_env.envs.disturbances import Disturbances
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import DrawnKind, Sigmas, TapeRow
from grind_env.envs.reset_options import CONTEXT_FACTORS, Given
from grind_env.machine.job import JobError, Lots, PartConditions

#: logarithmic standard deviation of each factor that an episode draws once, by stroke parameter
WHEEL_SPREAD = {"kA": 0.20, "ra_scale": 0.07, "fc": 0.10, "Gref": 0.15, "hf": 0.15}

#: names of these factors in a context, by stroke parameter
WHEEL_FACTORS = {name: "wheel_kA" if name == "kA" else name for name in WHEEL_SPREAD}

LOT_FACTORS = ("kA", "pm")  #: factors that every lot of material draws, by stroke parameter

STOCK, NEW_LOT = TapeRow._fields.index("stock"), TapeRow._fields.index("new_lot")
FACTOR_COLUMNS = [TapeRow._fields.index(name) for name in FACTORS]
OF_NEW_WHEEL = ("kA", "ra_scale")  #: factors that differ between the first wheel and a new wheel
#: columns of the tape in which parts with stated conditions differ
STATED = [
    TapeRow._fields.index(name) for name in ("stock", "gauged", *FACTORS, *(f"spare_{name}" for name in OF_NEW_WHEEL))
]

LEAST_STOCK = 0.4  #: smallest ratio of stock to nominal stock


def unfixable_factors(spread: float) -> dict[str, str]:
    """Return the factors that a context cannot fix in a job, each with the reason."""
    fixable = {*WHEEL_FACTORS.values(), *LOT_FACTORS, *({"noise"} if spread > 0.0 else ())}
    others = [name for name in (*CONTEXT_FACTORS, "material", "sequence") if name not in fixable]
    why = "the program and the job of grind/Job-v0 say what is ground and with which wheel"
    return dict.fromkeys(others, why) | ({} if spread > 0.0 else {"noise": "with spread=0 the gauges are exact"})


def spreads(lots: Lots, factor: float) -> dict[str, float]:
    """Return the spreads of wheels, coolant, lots and gauges of a job times a factor, by name as in `tasks.Spread`."""
    return {
        "measurement": factor,
        "lot_growth": factor * lots.growth,
        "lot_pressure": factor * lots.pressure,
        "wheel_growth": factor * WHEEL_SPREAD["kA"],
        "wheel_roughness": factor * WHEEL_SPREAD["ra_scale"],
        "part_roughness": factor * lots.roughness,
        "fracture_force": factor * WHEEL_SPREAD["fc"],
        "g_ratio": factor * WHEEL_SPREAD["Gref"],
        "convection": factor * WHEEL_SPREAD["hf"],
    }


class JobGenerator(Disturbances):
    """Generator of the episodes of a job; for parts with stated conditions only gauge noise is drawn.

    The random numbers of a part depend on its number, the numbers of a reading on its block.

    Args:
        part_of_block: number of the part of each block, from 0.
        lots: variation of lots and stocks.
        stocks: nominal stock of each part, mm.
        spread: factor on all standard deviations; 0 for the nominal job with exact gauges.
        wheel: state before the first block, shape (fields of `WheelState`,).
        stated: stated differences of each part.

    Raises:
        JobError: `stated` has a factor that cannot differ from part to part.
    """

    def __init__(
        self,
        part_of_block: Sequence[int],
        lots: Lots,
        stocks: Sequence[float],
        spread: float,
        wheel: NDArray[Any],
        stated: Sequence[PartConditions] = (),
    ) -> None:
        self.wheel = wheel
        sigmas = Sigmas(*[0.0] * len(Sigmas._fields))._replace(measurement=spread)
        if not stated:
            probability = lots.probability if spread > 0.0 else 0.0
            sigmas = sigmas._replace(stock=spread * lots.stock, lot_probability=probability, **spreads(lots, spread))
        kinds = [
            DrawnKind(stocks[part], LEAST_STOCK, float(part != before), 0.0, 0.0, float(part))
            for before, part in itertools.pairwise([-1, *part_of_block])
        ]
        super().__init__(kinds, sigmas, range(len(kinds)))
        rows = [_stated(number, each, stocks[number - 1]) for number, each in enumerate(stated, 1)]
        self._stated = np.array(rows)[np.array(part_of_block)] if stated else None

    def draws(self, given: Given) -> Draws:
        # in every split, program and job decide what is ground and with which wheel
        return draws_of(given.split)._replace(stock=1.0, foreign=0.0)

    def mount(self, episodes: Episodes, index: NDArray[np.int64], which: NDArray[np.int64], fixed: Table) -> None:
        episodes.wheels[index, : self.wheel.size] = self.wheel
        if self._stated is not None:
            episodes.tape[index[:, None], :, np.array(STATED)] = self._stated.T


def _stated(number: int, part: PartConditions, nominal: float) -> tuple[float, ...]:
    """Return the stated conditions of a part in the columns `STATED` of a tape."""
    first, spare = part.factors, part.factors if part.new_wheel_factors is None else part.new_wheel_factors
    for name in {*first, *spare}:
        if name not in FACTORS:
            raise JobError(f"part {number} has a factor on {name}; here parts differ in {', '.join(FACTORS)}", "parts")
        if name not in OF_NEW_WHEEL and first.get(name, 1.0) != spare.get(name, 1.0):
            names = ", ".join(OF_NEW_WHEEL)
            raise JobError(
                f"part {number} has another {name} with a new wheel; here a wheel differs in {names}", "parts"
            )
    stock = nominal if part.stock is None else part.stock
    return (
        stock,
        stock,
        *(first.get(name, 1.0) for name in FACTORS),
        *(spare.get(name, 1.0) for name in OF_NEW_WHEEL),
    )


def conditions_of(
    tape: NDArray[np.float64], part_of_block: NDArray[np.int64], parts: int, nominal: Sequence[float]
) -> tuple[PartConditions, ...]:
    """Return the conditions of each part on a tape, shape (blocks, fields of `TapeRow`); `nominal` stock in mm."""
    first = np.flatnonzero(np.diff(part_of_block, prepend=-1))
    rows = tape[first]
    factors = [dict(zip(FACTORS, row, strict=True)) for row in rows[:, FACTOR_COLUMNS].tolist()]
    drawn = zip(part_of_block[first].tolist(), rows[:, STOCK].tolist(), strict=True)
    stocks = [None if stock == nominal[part] else stock for part, stock in drawn]
    found = [PartConditions(stock=stock, factors=each) for stock, each in zip(stocks, factors, strict=True)]
    # a part without a cycle block has the conditions of the part with the next block, or with the last block
    of_part = np.minimum(np.searchsorted(part_of_block[first], np.arange(parts)), len(found) - 1)
    return tuple(found[k] for k in of_part.tolist())
