"""Settings of a cycle block of a script: its words E, D, J and L, and the values of its dress program."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.control import CyclePlan
from grind_env.kernel.row_accessors import column_reader
from grind_env.machine.dress.dress_run import NO_DRESS, DressPlan


class BlockSettings(NamedTuple):
    """The settings of a cycle block. A G81 has no J and no L; without a dress program there are no passes."""

    E: float  #: table speed, mm/min
    D: float  #: number of auto-dress executions
    J: float  #: plunge pick, mm; also Q in a block without a Q
    L: float  #: number of spark-out passes
    dress_passes: float  #: number of diamond passes of one execution
    dress_feed: float  #: traverse feed of the diamond, mm/s
    dress_depth: float  #: mean infeed of a pass, mm
    dress_seconds: float  #: time of one execution, s


class Ranges(NamedTuple):
    """Lowest and highest values of words that may be chosen in the blocks of a script.

    A word without a range keeps its value; with any range, D may be chosen, too.
    """

    E: Sequence[float] = ()  #: table speed, mm/min
    J: Sequence[float] = ()  #: plunge pick, mm
    L: Sequence[int] = ()


OWN_WORDS = Ranges()

read_settings = column_reader(BlockSettings)
SETTINGS = len(BlockSettings._fields)
#: columns of the settings in a table, shape (N, `SETTINGS`)
E, D, J, L, DRESS_PASSES, DRESS_FEED, DRESS_DEPTH, DRESS_SECONDS = range(SETTINGS)


def own_settings(plan: CyclePlan, dress: DressPlan | None) -> BlockSettings:
    """Return the settings of a block in its program."""
    dress = dress or NO_DRESS
    return BlockSettings(
        E=plan.feed,
        D=float(plan.dresses),
        J=plan.primary_pick,
        L=float(plan.spark_out),
        dress_passes=float(dress.passes),
        dress_feed=dress.feed,
        dress_depth=dress.depth,
        dress_seconds=dress.seconds,
    )
