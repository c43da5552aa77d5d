"""Arrays of a step: tables of the script, states of the episodes, choices, and room for the running step."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.envs.cost import Shop
from grind_env.envs.noise_tape import TapeRow
from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.loops.concurrent_strokes import FeedMotion
from grind_env.machine.loops.machine_lanes import CYCLE_FIELDS
from grind_env.machine.script.block_settings import BlockSettings
from grind_env.machine.script.replay import BlockPlace
from grind_env.process.stroke_types import StrokeParameters

KIND, MATERIAL, STOCK = (TapeRow._fields.index(name) for name in ("kind", "material", "stock"))


class StageSoFar(NamedTuple):
    """Results of a part since its last judgement, and times of the machine."""

    torque: float  #: ratio of the highest torque of a stroke to the torque at which the spindle stalls
    rise: float  #: highest temperature rise that counts, K
    gone: float  #: time of the program since the last part was taken off, s
    gauged: float  #: 1 if the wear of the wheel is known, else 0
    rested: float  #: time since the last stroke, or since a wheel change after this stroke, s


read_stage, write_stage = column_reader(StageSoFar), column_writer(StageSoFar)
with_stage, gone_on = replacer(StageSoFar, "torque", "rise", "gauged"), replacer(StageSoFar, "gone", "rested")
STAGE_FIELDS = len(StageSoFar._fields)


class Tables(NamedTuple):
    """A script, the numbers of its task or job, and room for N machines. The first six are those of `ScriptTables`."""

    blocks: Any
    plans: Any
    own_settings: Any
    rest_times: Any
    motions: Any
    zones: Any
    kinds: Any  #: numbers of the kind of each row, shape (rows, fields of `KindRow`)
    base: Any  #: parameters of each possible machine, shape (machines, 1 or rows, fields of `StrokeParameters`)
    cooler: Any  #: limits of temperature of each machine less those of the rows, K, shape (machines, 1 or rows)
    shops: Any  #: numbers of the task or job, shape (1, fields of `Shop`)
    drawn: Any  #: numbers of the kinds for draws of tape rows, shape (kinds, fields of `DrawnKind`)
    spreads: Any  #: spreads for draws of tape rows, shape (1, fields of `Sigmas`)
    #: depth below the surface at which the cycle of a row begins that grinds the stock on the tape, mm, shape (rows,);
    #: negative for a row with depths in the script
    lead: Any
    infeed: float  #: F of a G81 that grinds the stock on the tape, mm/s; else 0
    approach: float  #: time of the program up to its first block, s
    parameters: Any  #: room for the parameters of the machines, shape (N, fields of `StrokeParameters`)
    places: Any  #: room for the places of the blocks, shape (N, fields of `BlockPlace`)
    rows: Any  #: room for the script rows of the blocks, shape (N,), int64
    settings: Any  #: room for the settings of the blocks, shape (N, fields of `BlockSettings`)
    cycles: Any  #: room for the cycles of the blocks, shape (N, `CYCLE_FIELDS`)


class EpisodeArrays(NamedTuple):
    """The state of N episodes, as in `Episodes`; all but schedule, machine and forces are updated."""

    tape: Any  #: shape (N, rows, fields of `TapeRow`)
    block: Any  #: number of the coming block, shape (N,), int64
    wheels: Any  #: shape (N, fields of `WheelState`, of `own` of the process, and of `own` of the gauge)
    parts: Any  #: parts as gauged, shape (N, fields of `PartState`)
    memory: Any  #: shape (N, fields of `History`)
    source: Any  #: shape (N, SOURCE)
    schedule: Any  #: shape (N, blocks), int16
    stages: Any  #: shape (N, fields of `StageSoFar`)
    surfaces: Any  #: surfaces of parts in zones, shape (N, zones, fields of `Zone`)
    machine: Any  #: number of the machine of each episode, shape (N,), int64
    forces: Any  #: factor on the forces in each row of the script, shape (N, 1 or rows)


class Choices(NamedTuple):
    """Choices for the coming block of N episodes; each of shape (N,) but for the settings."""

    speeds: Any  #: E, mm/min
    executions: Any  #: D
    pre_dresses: Any  #: 1 for a dress before the first plunge, else 0
    #: all settings, shape (N, fields of `BlockSettings`); no rows if the other words are those of the script
    settings: Any


class Scratch:
    """Reusable arrays of steps, because the system maps tens of MB slowly; each running step has its own arrays.

    Each machine has room for `motions` motions of a G81, which the step writes.
    """

    def __init__(self, motions: int = 0) -> None:
        self.motions = motions
        self._free: list[tuple[Any, ...]] = []

    def __reduce__(self) -> tuple[type["Scratch"], tuple[int]]:
        return Scratch, (self.motions,)

    def take(self, n: int) -> tuple[Any, ...]:
        """Return arrays of N rows or more: the fields of `Tables` from `parameters` on, and the motions."""
        try:  # two threads may take the last arrays at the same time
            room = self._free.pop()
        except IndexError:
            room = ()
        if room and len(room[0]) >= n:
            return room
        records = StrokeParameters, BlockPlace, BlockSettings
        parameters, places, settings = (np.empty((n, len(record._fields))) for record in records)
        motions = np.empty((n * self.motions, len(FeedMotion._fields)))
        return parameters, places, np.empty(n, np.int64), settings, np.empty((n, CYCLE_FIELDS)), motions

    def give_back(self, room: tuple[Any, ...]) -> None:
        """Free arrays for another step."""
        self._free.append(room)


@inlined
def row_of(episodes: Any, i: int, place: int, shop: Shop) -> int:
    """Return the row of the script for the coming block of episode i."""
    return int(episodes.tape[i, place, KIND]) * int(shop.materials) + int(episodes.tape[i, place, MATERIAL])
