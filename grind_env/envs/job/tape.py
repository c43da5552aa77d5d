"""What is random in an episode of the user's own job, all of it drawn at reset.

The spreads are those of the scenarios (section 3), or those that the job's `[lots]` names: every wheel, coolant and lot
of material differs somewhat from the catalogue, and gauges are noisy.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.hidden import FACTORS
from grind_env.envs.contexts import CONTEXT_FACTORS, Fixed, Given, from_ranges
from grind_env.envs.tape import TapeRow, log_normal, unless, write_row
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader
from grind_env.machine.job import JobError, Lots, PartConditions

WHEEL_SPREAD = {"kA": 0.20, "ra_scale": 0.07, "fc": 0.10, "Gref": 0.15, "hf": 0.15}
"""Logarithmic standard deviation of each factor that an episode draws once, by stroke parameter."""

WHEEL_FACTORS = {name: "wheel_kA" if name == "kA" else name for name in WHEEL_SPREAD}
"""What a context calls them."""

LOT_FACTORS = ("kA", "pm")
"""Factors that every lot of material draws, by stroke parameter."""

NOISES = tuple(
    TapeRow._fields.index(f"{name}_noise") for name in ("mean", "first", "peak", "size", "roughness", "wheel")
)
STOCK, NEW_LOT = TapeRow._fields.index("stock"), TapeRow._fields.index("new_lot")
FACTOR_COLUMNS = [TapeRow._fields.index(name) for name in FACTORS]
OF_NEW_WHEEL = ("kA", "ra_scale")
"""Factors that a new wheel has of its own."""
STATED = [
    TapeRow._fields.index(name) for name in ("stock", "gauged", *FACTORS, *(f"spare_{name}" for name in OF_NEW_WHEEL))
]
"""Columns in which stated parts differ."""

read_fixed = column_reader(Fixed)

LEAST_STOCK = 0.4
"""Of the nominal one; no part has less."""


@dataclass(frozen=True, slots=True, eq=False)
class JobTape:
    """The random numbers of an episode.

    Attributes:
        conditions: of each part.
        new_lot: whether each part begins a new lot.
        noise: of the readings of mean, first and highest power, size, roughness and wheel diameter after each block,
            standard normal times the spread, shape (blocks, 6).
    """

    conditions: tuple[PartConditions, ...]
    new_lot: tuple[bool, ...]
    noise: NDArray[np.float64]


def barred_factors(spread: float) -> dict[str, str]:
    """What a context of `grind_env.envs.contexts` cannot fix in a job, each with the reason."""
    fixable = {*WHEEL_FACTORS.values(), *LOT_FACTORS, *({"noise"} if spread > 0.0 else ())}
    others = [name for name in (*CONTEXT_FACTORS, "material", "sequence") if name not in fixable]
    why = "the program and the job of grind/Job-v0 say what is ground and with which wheel"
    return dict.fromkeys(others, why) | ({} if spread > 0.0 else {"noise": "with spread=0 the gauges are exact"})


class JobGenerator:
    """Draws the episodes of a job.

    Args:
        part_of_block: number of the part of each block, from 0.
        parts: how many parts the program grinds.
        lots: how lots and stocks differ.
        stocks: nominal stock of each part, mm.
        spread: factor on all standard deviations; 0 is the nominal job with exact gauges.
        wheel: as the first block finds it, shape (fields of `WheelState`,).
    """

    def __init__(
        self,
        part_of_block: Sequence[int],
        parts: int,
        lots: Lots,
        stocks: Sequence[float],
        spread: float,
        wheel: NDArray[Any],
    ) -> None:
        self.part_of_block, self.stocks = np.array(part_of_block), np.array(stocks)
        self.parts, self.lots, self.spread, self.wheel = parts, lots, spread, wheel
        self._wheel_sigmas = spread * np.array([*WHEEL_SPREAD.values()])
        self._lot_sigmas = spread * np.array([lots.growth, lots.pressure])

    def begin(
        self,
        tape: NDArray[np.float64],
        wheels: NDArray[np.float64],
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """Draw an episode from each of M generators, and write its tape and its first wheel.

        The count of random numbers depends on the program only, never on what they turn out to be.

        Args:
            tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
            wheels: shape (N, fields of `WheelState`); written likewise.
            index: rows of the new episodes, shape (M,).
            rngs: their generators.
            given: what is given of each.
        """
        m, blocks, lots = len(rngs), len(self.part_of_block), self.lots
        episode, drawn = np.empty((m, len(WHEEL_SPREAD))), np.empty((m, self.parts, len(LOT_FACTORS)))
        uniforms, noise = np.empty((m, self.parts)), np.empty((m, blocks, len(NOISES)))
        stocks, fixed = np.zeros((m, self.parts)), np.array([each.fixed for each in given])
        roughness = np.empty((m, self.parts))
        for j, (rng, each) in enumerate(zip(rngs, given, strict=True)):
            rng.standard_normal(out=episode[j])
            rng.standard_normal(out=drawn[j])
            rng.random(out=uniforms[j])
            rng.standard_normal(out=noise[j])
            rng.standard_normal(out=roughness[j])
            if lots.stock > 0.0:
                rng.standard_normal(out=stocks[j])
            if each.ranges:
                episode[j], drawn[j] = from_ranges(episode[j], each.ranges), from_ranges(drawn[j], each.ranges)
        fill_jobs(
            tape,
            index,
            self.part_of_block,
            self._wheel_sigmas,
            self._lot_sigmas,
            self.spread * lots.stock,
            self.spread * lots.roughness,
            self.spread,
            lots.probability,
            self.stocks,
            episode,
            drawn,
            uniforms,
            noise,
            stocks,
            roughness,
            fixed,
        )
        wheels[index, : self.wheel.size] = self.wheel


class StatedParts(JobGenerator):
    """Writes the episodes of a job that states how each part differs; only the noise of the gauges is drawn.

    Args:
        part_of_block: number of the part of each block, from 0.
        conditions: of each part.
        stocks: nominal stock of each part, mm.
        spread: factor on the noise.
        wheel: as the first block finds it, shape (fields of `WheelState`,).

    Raises:
        JobError: a factor that cannot differ from part to part here.
    """

    def __init__(
        self,
        part_of_block: Sequence[int],
        conditions: Sequence[PartConditions],
        stocks: Sequence[float],
        spread: float,
        wheel: NDArray[Any],
    ) -> None:
        alike = Lots(probability=0.0, growth=0.0, pressure=0.0, stock=0.0, roughness=0.0)
        super().__init__(part_of_block, len(conditions), alike, stocks, spread, wheel)
        self._wheel_sigmas = np.zeros(len(WHEEL_SPREAD))
        rows = [_stated(number, each, stocks[number - 1]) for number, each in enumerate(conditions, 1)]
        self._stated = np.array(rows)[self.part_of_block]

    def begin(
        self,
        tape: NDArray[np.float64],
        wheels: NDArray[np.float64],
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """As `JobGenerator.begin`."""
        super().begin(tape, wheels, index, rngs, given)
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
    part_of_block: Any,
    wheel_sigmas: Any,
    lot_sigmas: Any,
    stock_sigma: float,
    roughness_sigma: float,
    spread: float,
    probability: float,
    nominal: Any,
    episode: Any,
    lots: Any,
    uniforms: Any,
    noise: Any,
    stocks: Any,
    roughness: Any,
    fixed: Any,
) -> None:
    """Write the tapes of M episodes.

    Args:
        tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
        index: episodes that begin, shape (M,).
        part_of_block: number of the part of each block, shape (blocks,).
        wheel_sigmas: of the factors `WHEEL_SPREAD`, shape (5,).
        lot_sigmas: of the factors `LOT_FACTORS`, shape (2,).
        stock_sigma: of the stock, relative.
        roughness_sigma: of the roughness from part to part, logarithmic.
        spread: factor on all that is random.
        probability: that a part after the first begins a new lot.
        nominal: stock of each part, mm, shape (parts,).
        episode: standard normal numbers of the wheel, shape (M, 5).
        lots: of each part, should it begin a lot, shape (M, parts, 2).
        uniforms: of each part, shape (M, parts).
        noise: of the gauges after each block, shape (M, blocks, 6).
        stocks: of each part, shape (M, parts).
        roughness: of each part, shape (M, parts).
        fixed: what a context fixes, shape (M, fields of `Fixed`).
    """
    for j in range(index.size):
        given = read_fixed(fixed, j)
        # a lot that differs from the last one in nothing is no new lot
        same = spread == 0.0 or not (np.isnan(given.kA) or np.isnan(given.pm))
        fill_job(
            tape[index[j]],
            part_of_block,
            wheel_sigmas,
            lot_sigmas,
            stock_sigma,
            roughness_sigma,
            spread * unless(given.noise, 1.0),
            0.0 if same else probability,
            nominal,
            episode[j],
            lots[j],
            uniforms[j],
            noise[j],
            stocks[j],
            roughness[j],
            given,
        )


@inlined
def fill_job(
    tape: Any,
    part_of_block: Any,
    wheel_sigmas: Any,
    lot_sigmas: Any,
    stock_sigma: float,
    roughness_sigma: float,
    measurement: float,
    probability: float,
    nominal: Any,
    episode: Any,
    lots: Any,
    uniforms: Any,
    noise: Any,
    stocks: Any,
    roughness: Any,
    fixed: Fixed,
) -> None:
    """Write a tape.

    Args:
        tape: shape (blocks, fields of `TapeRow`); written.
        part_of_block: number of the part of each block, shape (blocks,).
        wheel_sigmas: of the factors `WHEEL_SPREAD`, shape (5,).
        lot_sigmas: of the factors `LOT_FACTORS`, shape (2,).
        stock_sigma: of the stock, relative.
        roughness_sigma: of the roughness from part to part, logarithmic.
        measurement: factor on the noise of the gauges.
        probability: that a part after the first begins a new lot.
        nominal: stock of each part, mm, shape (parts,).
        episode: standard normal numbers of the wheel, shape (5,).
        lots: of each part, should it begin a lot, shape (parts, 2).
        uniforms: of each part, shape (parts,).
        noise: of the gauges after each block, shape (blocks, 6).
        stocks: of each part, shape (parts,).
        roughness: of each part, shape (parts,).
        fixed: what a context fixes.
    """
    wheel_kA = unless(fixed.wheel_kA, log_normal(wheel_sigmas[0], episode[0]))
    wheel_ra = log_normal(wheel_sigmas[1], episode[1])
    fc = unless(fixed.fc, log_normal(wheel_sigmas[2], episode[2]))
    Gref = unless(fixed.Gref, log_normal(wheel_sigmas[3], episode[3]))
    hf = unless(fixed.hf, log_normal(wheel_sigmas[4], episode[4]))
    part, kA, pm, ra_scale, part_ra, stock = -1, 1.0, 1.0, 1.0, 1.0, nominal[0]
    for k in range(part_of_block.size):
        begins = False
        while part < part_of_block[k]:
            part += 1
            begins = part == 0 or uniforms[part] < probability
            if begins:
                kA = unless(fixed.kA, log_normal(lot_sigmas[0], lots[part, 0]))
                pm = unless(fixed.pm, log_normal(lot_sigmas[1], lots[part, 1]))
            part_ra = log_normal(roughness_sigma, roughness[part]) if np.isnan(fixed.ra_scale) else 1.0
            ra_scale = unless(fixed.ra_scale, wheel_ra * part_ra)
            stock = nominal[part] * max(LEAST_STOCK, 1.0 + stock_sigma * stocks[part])
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
            mean_noise=measurement * noise[k, 0],
            first_noise=measurement * noise[k, 1],
            peak_noise=measurement * noise[k, 2],
            size_noise=measurement * noise[k, 3],
            roughness_noise=measurement * noise[k, 4],
            wheel_noise=measurement * noise[k, 5],
            material=0.0,
            spare_kA=wheel_kA * kA,
            spare_ra_scale=ra_scale,
            due=0.0,
            work=0.0,
            is_due=0.0,
        )
        write_row(tape, k, row)


def job_tape(
    tape: NDArray[np.float64], part_of_block: NDArray[np.int64], parts: int, nominal: Sequence[float]
) -> JobTape:
    """What a tape, shape (blocks, fields of `TapeRow`), says of each part; its `nominal` stock in mm."""
    first = np.flatnonzero(np.diff(part_of_block, prepend=-1))
    rows = tape[first]
    factors = [dict(zip(FACTORS, row, strict=True)) for row in rows[:, FACTOR_COLUMNS].tolist()]
    drawn = zip(part_of_block[first].tolist(), rows[:, STOCK].tolist(), strict=True)
    stocks = [None if stock == nominal[part] else stock for part, stock in drawn]
    found = [PartConditions(stock=stock, factors=each) for stock, each in zip(stocks, factors, strict=True)]
    # a part without a cycle block is as the one with the next block, or with the last one
    of_part = np.minimum(np.searchsorted(part_of_block[first], np.arange(parts)), len(found) - 1)
    conditions = [found[k] for k in of_part.tolist()]
    return JobTape(tuple(conditions), tuple((rows[:, NEW_LOT] > 0.0).tolist()), tape[:, NOISES])
