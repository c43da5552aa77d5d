"""The learning curve of a training: what the agent scores in validation on the way, and where the time went.

It is a CSV file beside the policy, one line a validation.
"""

import csv
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from agents.tables import csv_of, csv_rows
from grind_env.errors import reason
from grind_env.policies.tuned import ConfigError, write_whole


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One point of the curve. Times are wall time since the training began, s."""

    steps: int
    """Environment steps."""
    seconds: float
    """Of the whole training, validation and checkpoints included."""
    reward: float
    """Mean reward of a step of the training episodes since the point before."""
    cost: float
    """Mean cost of the validation episodes, $."""
    score: float
    """Normalised score of these, estimated; see `agents.learning.validation`."""
    environment: float
    features: float
    policy: float
    """Inference and buffers."""
    optimisation: float
    aside: float
    """Validation, checkpoints and logs."""


SPENT = ("environment", "features", "policy", "optimisation", "aside")
"""What wall time is spent on: fields of `Point`."""


def curve_path(policy: Path) -> Path:
    """Where the curve of a policy lies."""
    return policy.with_suffix(".csv")


def write_curve(path: Path, points: Sequence[Point]) -> None:
    """Write the curve, whole or not at all."""
    write_whole(path, csv_of([field.name for field in fields(Point)], map(astuple, points)))


def read_curve(path: Path) -> list[Point]:
    """The points of a curve, in order.

    Raises:
        ConfigError: if the file is not there or is no curve.
    """
    try:
        rows = csv_rows(path)
        return [
            Point(steps=int(row["steps"]), **{name: float(row[name]) for name in row if name != "steps"})
            for row in rows
        ]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise ConfigError(
            f"{path} is no learning curve ({reason(error)}): train the agent anew with --fresh"
        ) from error


def seconds_to(points: Sequence[Point], share: float = 0.95) -> float:
    """Wall time from which on the score stays at or above that share of the final one, s.

    Of a score below 0 the rest of the share is how far below the final one the score may be.
    """
    reached, final = len(points) - 1, points[-1].score
    enough = final - (1.0 - share) * abs(final)
    while reached > 0 and points[reached - 1].score >= enough:
        reached -= 1
    return points[reached].seconds
