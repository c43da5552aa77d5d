"""What is random in an episode of the user's own job, all of it drawn at reset.

The spreads are those of the scenarios (section 3): every wheel, coolant and lot of material differs somewhat from
the catalogue, and gauges are noisy. The stock is what the job says: the wheel is touched off where the program
expects it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.contexts import CONTEXT_FACTORS, Given, from_ranges
from grind_env.envs.tape import FACTORS, log_normal
from grind_env.kernel import entry
from grind_env.machine.part import PartConditions

WHEEL_SPREAD = {"kA": 0.20, "ra_scale": 0.07, "fc": 0.10, "Gref": 0.15, "hf": 0.15}
"""Logarithmic standard deviation of each factor that an episode draws once, by stroke parameter."""

WHEEL_FACTORS = {name: "wheel_kA" if name == "kA" else name for name in WHEEL_SPREAD}
"""What a context calls them."""

LOT_SPREAD = {"kA": 0.45, "pm": 0.08}
"""The same of the factors that every lot of material draws."""

LOT_PROBABILITY = 1.0 / 6.0
"""Probability that a part begins a new lot; the first part always does."""

NOTHING = Given()
"""Everything is drawn."""

GAUGES = ("mean_power", "first_power", "peak_power", "size_error", "roughness")
"""Readings with noise."""


@dataclass(frozen=True, slots=True, eq=False)
class JobTape:
    """The random numbers of an episode.

    Attributes:
        conditions: factors of each part.
        new_lot: whether each part begins a new lot.
        noise: of the readings `GAUGES` after each block, standard normal times the spread, shape (blocks, 5).
    """

    conditions: tuple[PartConditions, ...]
    new_lot: tuple[bool, ...]
    noise: NDArray[np.float64]


def barred_factors(spread: float) -> dict[str, str]:
    """What a context of `grind_env.envs.contexts` cannot fix in a job, each with the reason."""
    fixable = {*WHEEL_FACTORS.values(), *LOT_SPREAD, *({"noise"} if spread > 0.0 else ())}
    others = [name for name in (*CONTEXT_FACTORS, "material", "sequence") if name not in fixable]
    why = "the program and the job of grind/Job-v0 say what is ground and with which wheel"
    return dict.fromkeys(others, why) | ({} if spread > 0.0 else {"noise": "with spread=0 the gauges are exact"})


def draw(rng: np.random.Generator, blocks: int, parts: int, spread: float, given: Given = NOTHING) -> JobTape:
    """Draw an episode.

    The count of random numbers depends on the program only, never on what they turn out to be.

    Args:
        rng: the environment's generator.
        blocks: cycle blocks of the program.
        parts: parts that it grinds.
        spread: factor on all standard deviations; 0 is the nominal job with exact gauges.
        given: what is given of the episode.
    """
    fixed = given.fixed
    episode = rng.standard_normal(len(WHEEL_SPREAD))
    lots = rng.standard_normal((parts, len(LOT_SPREAD)))
    # a lot that differs from the last one in nothing is no new lot
    same = spread == 0.0 or not any(math.isnan(getattr(fixed, name)) for name in LOT_SPREAD)
    begins = rng.random(parts) < (0.0 if same else LOT_PROBABILITY)
    begins[:1] = True
    noise = spread * (1.0 if math.isnan(fixed.noise) else fixed.noise) * rng.standard_normal((blocks, len(GAUGES)))
    if given.ranges:
        episode, lots = from_ranges(episode, given.ranges), from_ranges(lots, given.ranges)
    wheel = {
        name: float(_or_drawn(getattr(fixed, WHEEL_FACTORS[name]), log_normals(spread * sigma, episode[k : k + 1]))[0])
        for k, (name, sigma) in enumerate(WHEEL_SPREAD.items())
    }
    columns = [
        _or_drawn(getattr(fixed, name), log_normals(spread * sigma, np.ascontiguousarray(lots[:, k])))
        for k, (name, sigma) in enumerate(LOT_SPREAD.items())
    ]
    # a part goes on with the lot of the last part that began one
    lot = np.maximum.accumulate(np.where(begins, np.arange(parts), 0))
    conditions = tuple(
        PartConditions(
            factors=_factors(wheel, {name: float(c[k]) for name, c in zip(LOT_SPREAD, columns, strict=True)})
        )
        for k in lot.tolist()
    )
    return JobTape(conditions, tuple(begins.tolist()), noise)


@entry
def log_normals(sigma: float, normals: Any) -> Any:
    """`tape.log_normal` of each standard normal number."""
    factors = np.empty_like(normals)
    for i in range(normals.size):
        factors[i] = log_normal(sigma, normals[i])
    return factors


def _or_drawn(fixed: float, drawn: NDArray[np.float64]) -> NDArray[np.float64]:
    return drawn if math.isnan(fixed) else np.full_like(drawn, fixed)


def _factors(wheel: dict[str, float], lot: dict[str, float]) -> dict[str, float]:
    return {name: wheel.get(name, 1.0) * lot.get(name, 1.0) for name in FACTORS}
