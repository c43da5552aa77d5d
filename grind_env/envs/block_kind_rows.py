"""Numbers of the kinds of blocks for the compiled step: a row for every kind in every material."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.tasks import Kind, Task
from grind_env.kernel.row_accessors import column_reader


class KindRow(NamedTuple):
    """The numbers of a block kind that a step needs; see `tasks.Kind`.

    `stock`, `pick`, `width` and `length` are mm, `scrap` is $. `sparkout` is the number of strokes. `starts_part` and
    `ends_part` are 1 if so, else 0. The limits are `rise` in K, `power` in W, `roughness` and `size` in um.
    """

    stock: float
    pick: float
    sparkout: float
    width: float
    length: float
    scrap: float
    starts_part: float
    ends_part: float
    counts_all: float  #: 1 if heat counts over all plunges, because a rise allowance is given
    rise: float
    power: float
    roughness: float
    size: float


read_kind = column_reader(KindRow)


def kind_row(task: Task, kind: Kind) -> KindRow:
    """Return the numbers of a block kind."""
    return KindRow(
        stock=kind.stock,
        pick=kind.pick,
        sparkout=float(kind.sparkout),
        width=kind.width,
        length=kind.length,
        scrap=kind.scrap,
        starts_part=float(kind.starts_part),
        ends_part=float(kind.ends_part),
        counts_all=float(kind.rise_allowance > 0.0),
        **task.limits(kind)._asdict(),
    )


def kind_table(task: Task) -> NDArray[np.float64]:
    """Return the numbers of every kind in every material, shape (kinds x materials, fields of `KindRow`)."""
    return np.array([kind_row(task, kind) for kind in _variants(task)])


def parameter_table(task: Task) -> NDArray[np.float64]:
    """Return nominal parameters of kinds in all materials, shape (kinds x materials, fields of `StrokeParameters`)."""
    return np.array([task.parameters(kind) for kind in _variants(task)])


def _variants(task: Task) -> list[Kind]:
    return [replace(kind, material=name) for kind in task.kinds for name in task.materials]
