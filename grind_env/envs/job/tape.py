"""What is random in an episode of the user's own job: a whole tape, drawn at reset from the key of the episode.

The spreads are those of the scenarios (section 3), or those that the job's `[lots]` names: every wheel, coolant and lot
of material differs somewhat from the catalogue, and gauges are noisy.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.hidden import FACTORS
from grind_env.envs.contexts import CONTEXT_FACTORS, Fixed, Given, apart
from grind_env.envs.drawing import EPISODE, GAUGES, PART, READINGS, deviation, factor, key_of, keys_of, unless, words_of
from grind_env.envs.splits import Draws, draws_of
from grind_env.envs.tape import TapeRow, write_row
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader
from grind_env.kernel.random import uniform
from grind_env.machine.job import JobError, Lots, PartConditions

WHEEL_SPREAD = {"kA": 0.20, "ra_scale": 0.07, "fc": 0.10, "Gref": 0.15, "hf": 0.15}
"""Logarithmic standard deviation of each factor that an episode draws once, by stroke parameter."""

WHEEL_FACTORS = {name: "wheel_kA" if name == "kA" else name for name in WHEEL_SPREAD}
"""What a context calls them."""

LOT_FACTORS = ("kA", "pm")
"""Factors that every lot of material draws, by stroke parameter."""

STOCK, NEW_LOT = TapeRow._fields.index("stock"), TapeRow._fields.index("new_lot")
FACTOR_COLUMNS = [TapeRow._fields.index(name) for name in FACTORS]
OF_NEW_WHEEL = ("kA", "ra_scale")
"""Factors that a new wheel has of its own."""
STATED = [
    TapeRow._fields.index(name) for name in ("stock", "gauged", *FACTORS, *(f"spare_{name}" for name in OF_NEW_WHEEL))
]
"""Columns in which stated parts differ."""

read_fixed, read_draws = column_reader(Fixed), column_reader(Draws)

LEAST_STOCK = 0.4
"""Of the nominal one; no part has less."""


class JobSigmas(NamedTuple):
    """Standard deviations: logarithmic ones of factors, and relative ones of stock and readings."""

    wheel_growth: float
    wheel_roughness: float
    fracture_force: float
    g_ratio: float
    convection: float
    lot_growth: float
    lot_pressure: float
    stock: float
    part_roughness: float
    measurement: float


def barred_factors(spread: float) -> dict[str, str]:
    """What a context of `grind_env.envs.contexts` cannot fix in a job, each with the reason."""
    fixable = {*WHEEL_FACTORS.values(), *LOT_FACTORS, *({"noise"} if spread > 0.0 else ())}
    others = [name for name in (*CONTEXT_FACTORS, "material", "sequence") if name not in fixable]
    why = "the program and the job of grind/Job-v0 say what is ground and with which wheel"
    return dict.fromkeys(others, why) | ({} if spread > 0.0 else {"noise": "with spread=0 the gauges are exact"})


class JobGenerator:
    """Draws the episodes of a job; of parts that are stated only the noise of the gauges.

    Args:
        part_of_block: number of the part of each block, from 0.
        lots: how lots and stocks differ.
        stocks: nominal stock of each part, mm.
        spread: factor on all standard deviations; 0 is the nominal job with exact gauges.
        wheel: as the first block finds it, shape (fields of `WheelState`,).
        stated: of each part, where the job says how it differs.

    Raises:
        JobError: a factor that cannot differ from part to part here.
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
        self.part_of_block, self.stocks, self.wheel = np.array(part_of_block), np.array(stocks), wheel
        self.lots = Lots(probability=0.0, growth=0.0, pressure=0.0, stock=0.0, roughness=0.0) if stated else lots
        of_wheel = 0.0 if stated else spread
        drawn = self.lots.growth, self.lots.pressure, self.lots.stock, self.lots.roughness, 1.0
        self._sigmas = JobSigmas(
            *(of_wheel * each for each in WHEEL_SPREAD.values()), *(spread * each for each in drawn)
        )
        rows = [_stated(number, each, stocks[number - 1]) for number, each in enumerate(stated, 1)]
        self._stated = np.array(rows)[self.part_of_block] if stated else None

    def begin(
        self,
        tape: NDArray[np.float64],
        wheels: NDArray[np.float64],
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """Begin an episode with a key from each of M generators: write its tape and its first wheel.

        Args:
            tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
            wheels: shape (N, fields of `WheelState`); written likewise.
            index: rows of the new episodes, shape (M,).
            rngs: their generators.
            given: what is given of each.
        """
        each, which = apart(given)
        fill_jobs(
            tape,
            index,
            keys_of(rngs),
            which,
            np.array([one.fixed for one in each]),
            np.array([draws_of(one.split) for one in each]),
            self.part_of_block,
            self.stocks,
            self._sigmas,
            self.lots.probability,
        )
        wheels[index, : self.wheel.size] = self.wheel
        if self._stated is not None:
            tape[index[:, None], :, np.array(STATED)] = self._stated.T


def _stated(number: int, part: PartConditions, nominal: float) -> tuple[float, ...]:
    """What a tape holds of a part in the columns `STATED`."""
    first, spare = part.factors, part.factors if part.new_wheel_factors is None else part.new_wheel_factors
    for name in {*first, *spare}:
        if name not in FACTORS:
            raise JobError(f"part {number} has a factor on {name}; here parts differ in {', '.join(FACTORS)}", "parts")
        if name not in OF_NEW_WHEEL and first.get(name, 1.0) != spare.get(name, 1.0):
            kept = ", ".join(OF_NEW_WHEEL)
            raise JobError(
                f"part {number} has another {name} with a new wheel; here a wheel differs in {kept}", "parts"
            )
    stock = nominal if part.stock is None else part.stock
    return (
        stock,
        stock,
        *(first.get(name, 1.0) for name in FACTORS),
        *(spare.get(name, 1.0) for name in OF_NEW_WHEEL),
    )


@entry
def fill_jobs(
    tape: Any,
    index: Any,
    keys: Any,
    which: Any,
    fixed: Any,
    splits: Any,
    part_of_block: Any,
    nominal: Any,
    sigmas: JobSigmas,
    probability: float,
) -> None:
    """Write the tapes of M episodes.

    Args:
        tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
        index: episodes that begin, shape (M,).
        keys: two uniform numbers for each, shape (M, 2).
        which: number of what is given of each, shape (M,).
        fixed: what a context fixes, by that number, shape (any, fields of `Fixed`).
        splits: of the split likewise, shape (any, fields of `Draws`); what is ground and with which wheel, the program
            and its job say in every one.
        part_of_block: number of the part of each block, shape (blocks,).
        nominal: stock of each part, mm, shape (parts,).
        sigmas: spreads of the job.
        probability: that a part after the first begins a new lot.
    """
    for j in range(index.size):
        given, split = read_fixed(fixed, which[j]), read_draws(splits, which[j])
        fill_job(tape[index[j]], keys[j, 0], keys[j, 1], given, split, part_of_block, nominal, sigmas, probability)


@inlined
def fill_job(
    tape: Any,
    u_0: float,
    u_1: float,
    fixed: Fixed,
    split: Draws,
    part_of_block: Any,
    nominal: Any,
    sigmas: JobSigmas,
    probability: float,
) -> None:
    """Write a tape, shape (blocks, fields of `TapeRow`), by two uniform numbers; the others are as for `fill_jobs`.

    A number of a part is drawn for that of the part, and one of a reading for that of the block.
    """
    key_0, key_1 = key_of(u_0, u_1)
    growth_word, rough_word, fc_word, Gref_word = words_of(key_0, key_1, EPISODE, 0)
    hf_word, _, _, _ = words_of(key_0, key_1, EPISODE, 1)
    ranges, reach = split.bits, split.reach
    wheel_kA = unless(fixed.wheel_kA, factor(reach * sigmas.wheel_growth, growth_word, ranges))
    wheel_ra = factor(sigmas.wheel_roughness, rough_word, ranges)
    fc = unless(fixed.fc, factor(sigmas.fracture_force, fc_word, ranges))
    Gref = unless(fixed.Gref, factor(sigmas.g_ratio, Gref_word, ranges))
    hf = unless(fixed.hf, factor(sigmas.convection, hf_word, ranges))
    measurement = sigmas.measurement * unless(fixed.noise, split.noise)
    # a lot that differs from the last one in nothing is no new lot
    lots = sigmas.measurement > 0.0 and (np.isnan(fixed.kA) or np.isnan(fixed.pm))
    part, kA, pm, ra_scale, part_ra, stock = -1, 1.0, 1.0, 1.0, 1.0, nominal[0]
    for k in range(part_of_block.size):
        begins = False
        while part < part_of_block[k]:
            part += 1
            lot_word, kA_word, pm_word, stock_word = words_of(key_0, key_1, PART, part)
            _, part_word, _, _ = words_of(key_0, key_1, GAUGES, part)
            begins = part == 0 or (lots and uniform(lot_word) < probability)
            if begins:
                kA = unless(fixed.kA, factor(reach * sigmas.lot_growth, kA_word, ranges))
                pm = unless(fixed.pm, factor(reach * sigmas.lot_pressure, pm_word, ranges))
            part_ra = factor(sigmas.part_roughness, part_word, 0.0) if np.isnan(fixed.ra_scale) else 1.0
            ra_scale = unless(fixed.ra_scale, wheel_ra * part_ra)
            stock = nominal[part] * max(LEAST_STOCK, 1.0 + deviation(sigmas.stock, stock_word))
        _, _, mean_word, first_word = words_of(key_0, key_1, GAUGES, k)
        peak_word, size_word, roughness_word, wheel_word = words_of(key_0, key_1, READINGS, k)
        shown = 1.0 if begins else 0.0  # numba takes no condition among so many keywords
        row = TapeRow(
            kind=float(k),
            stock=stock,
            gauged=stock,
            new_lot=shown,
            kA=wheel_kA * kA,
            pm=pm,
            hf=hf,
            fc=fc,
            Gref=Gref,
            ra_scale=ra_scale,
            part_ra=part_ra,
            mean_noise=deviation(measurement, mean_word),
            first_noise=deviation(measurement, first_word),
            peak_noise=deviation(measurement, peak_word),
            size_noise=deviation(measurement, size_word),
            roughness_noise=deviation(measurement, roughness_word),
            wheel_noise=deviation(measurement, wheel_word),
            material=0.0,
            spare_kA=wheel_kA * kA,
            spare_ra_scale=ra_scale,
            due=0.0,
            work=0.0,
            is_due=0.0,
        )
        write_row(tape, k, row)


def conditions_of(
    tape: NDArray[np.float64], part_of_block: NDArray[np.int64], parts: int, nominal: Sequence[float]
) -> tuple[PartConditions, ...]:
    """What a tape, shape (blocks, fields of `TapeRow`), says of each part; its `nominal` stock in mm."""
    first = np.flatnonzero(np.diff(part_of_block, prepend=-1))
    rows = tape[first]
    factors = [dict(zip(FACTORS, row, strict=True)) for row in rows[:, FACTOR_COLUMNS].tolist()]
    drawn = zip(part_of_block[first].tolist(), rows[:, STOCK].tolist(), strict=True)
    stocks = [None if stock == nominal[part] else stock for part, stock in drawn]
    found = [PartConditions(stock=stock, factors=each) for stock, each in zip(stocks, factors, strict=True)]
    # a part without a cycle block is as the one with the next block, or with the last one
    of_part = np.minimum(np.searchsorted(part_of_block[first], np.arange(parts)), len(found) - 1)
    return tuple(found[k] for k in of_part.tolist())
