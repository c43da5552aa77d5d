"""What is random in an episode of the user's own job, all of it drawn at reset.

The spreads are those of the scenarios (section 3): every wheel, coolant and lot of material differs somewhat from
the catalogue, and gauges are noisy. The stock is what the job says: the wheel is touched off where the program
expects it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.tape import log_normal
from grind_env.kernel import entry
from grind_env.machine.part import PartConditions

WHEEL_SPREAD = {"kA": 0.20, "ra_scale": 0.07, "fc": 0.10, "Gref": 0.15, "hf": 0.15}
"""Logarithmic standard deviation of each factor that an episode draws once, by stroke parameter."""

LOT_SPREAD = {"kA": 0.45, "pm": 0.08}
"""The same of the factors that every lot of material draws."""

LOT_PROBABILITY = 1.0 / 6.0
"""That a part begins a new lot; the first one always does."""

FACTORS = ("kA", "pm", "hf", "fc", "Gref", "ra_scale")
"""Stroke parameters that differ from part to part or from episode to episode."""

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


def draw(rng: np.random.Generator, blocks: int, parts: int, spread: float) -> JobTape:
    """Draw an episode.

    The count of random numbers depends on the program only, never on what they turn out to be.

    Args:
        rng: the environment's generator.
        blocks: cycle blocks of the program.
        parts: parts that it grinds.
        spread: factor on all standard deviations; 0 is the nominal job with exact gauges.
    """
    episode = rng.standard_normal(len(WHEEL_SPREAD))
    lots = rng.standard_normal((parts, len(LOT_SPREAD)))
    begins = rng.random(parts) < LOT_PROBABILITY
    begins[:1] = True
    noise = spread * rng.standard_normal((blocks, len(GAUGES)))
    wheel = {
        name: float(log_normals(spread * sigma, episode[k : k + 1])[0])
        for k, (name, sigma) in enumerate(WHEEL_SPREAD.items())
    }
    columns = [
        log_normals(spread * sigma, np.ascontiguousarray(lots[:, k])) for k, sigma in enumerate(LOT_SPREAD.values())
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


def _factors(wheel: dict[str, float], lot: dict[str, float]) -> dict[str, float]:
    return {name: wheel.get(name, 1.0) * lot.get(name, 1.0) for name in FACTORS}
