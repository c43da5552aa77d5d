"""A shop's rule without a process model: it uses the readings of this machine only."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array, Numbers
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.handbook import USUAL_SPEED, handbook_speeds
from grind_env.policies.scripted.learned_laws import AIM, PartLaw, PowerLaw
from grind_env.process.stroke_types import StrokeParameters

SHARE = 0.88  #: planned share of the power limit
#: usual volume between two dresses, mm3/mm, over the conductivity of the work, W/(m K): 140 mm3/mm in hardened bearing
#: steel, 45 in a nickel alloy, which a dull wheel burns sooner
INTERVAL = 4.0
REGAINED = 1.02  #: factor by which a reduced usual volume grows again with every good part
FAR = 1.2  #: ratio of power to its limit above which the wheel gets two dress executions
SMOOTH = 0.8  #: ratio of the last Ra to its limit below which a faster table is allowed
#: factor on E from block to block, and least share of the first E, when two executions have not lowered the power
SLOWING, FLOOR = 0.9, 0.75
EFFUSIVITY, DIFFUSIVITY = (StrokeParameters._fields.index(name) for name in ("beta", "alpha"))


@dataclass(kw_only=True)
class EmpiricalRule:
    """Rule on readings alone: E as high as the readings allow; dresses by volume, by time or on an alarm.

    The rule begins at the E of the program, or else of the handbook. E then rises, by at most the factor `step` from
    block to block of a kind, until laws fitted to the readings expect `SHARE` of the spindle's power, or the limits of
    Ra and size. Power never lowers E below its first value, because slow tables burn, unless two dress executions have
    not helped.

    The wheel is dressed before a part that would exceed the usual volume, with enough executions to keep every section
    of the part within it (unless late for a due date). It is dressed before a part that would take longer than the mean
    part since the last dress, including the time of that dress. It is also dressed after a power beyond its limit, a
    part too thick, or a part nearly too thin, because it was hot. These parts reduce the usual volume for a while.

    Attributes:
        power: fitted law of the power readings.
        speeds: E of the last block of each kind, whichever policy chose it, mm/min, shape (N, kinds).
        kind: kind of the coming block, shape (N,).
        volumes: usual volume between two dresses, by kind of part, mm3/mm, shape (N, kinds).
    """

    step: float = 1.5  #: largest factor on E from block to block
    # usual volume between two dresses over the conductivity of the work, mm3/mm over W/(m K)
    interval: float = INTERVAL
    name: ClassVar[str] = "empirical_rule"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.simulation, self.first = simulation, first_speeds(simulation)
        kinds, zero, none = len(self.first), np.zeros(episodes), np.zeros(episodes, np.int64)
        # all kinds of block on a part share its gauged values
        self.part_of_kind = np.zeros(kinds, np.int64) if simulation.task.orders is None else np.arange(kinds)
        self.power, (Ra, size) = PowerLaw(episodes), np.zeros((2, kinds))
        parts = self.part_of_kind[simulation.branches.kind_of_row]
        row = KindRow(*simulation.kinds[: len(parts)].T)
        np.maximum.at(Ra, parts, row.roughness)
        np.maximum.at(size, parts, row.size)
        self.roughness = PartLaw(episodes, Ra, exponent=0.5, usual=0.5, memory=8.0)
        self.size = PartLaw(episodes, size, exponent=1.0, usual=0.25, memory=2.0)
        self.rows, self.kind, self.speeds = none, none, np.tile(self.first, (episodes, 1))
        self.part, self.made, self.begun = none, zero + 1.0, False
        # episodes whose last part was hot, and episodes in which two executions have not lowered the power
        self.hot, self.helpless = np.zeros((2, episodes), bool)
        self.met, self.dull, self.worn, self.gauged, self.sized, self.wanted, self.blocks = np.zeros((7, episodes))
        self.most = usual_volumes(simulation, self.interval)
        np.minimum.at(self.most, self.part_of_kind, self.most.copy())
        self.volumes = np.tile(self.most, (episodes, 1))
        self.dressing = simulation.branches.dress_price / simulation.branches.second_price
        self.taken = zero + self.dressing

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        self.update(observation)
        return self.decide(observation)

    def update(self, observation: NDArray[np.float32]) -> None:
        if self.begun:
            self._update(self.simulation.read(observation), np.arange(len(observation)))

    def decide(self, observation: NDArray[np.float32]) -> Decision:
        task, branches, n = self.simulation.task, self.simulation.branches, np.arange(len(observation))
        seen, helpless = self.simulation.read(observation), self.helpless
        self.rows = branches.coming_rows(seen)
        row, kind = self.row, branches.kind_of_row[self.rows]
        part, last, first = self.part_of_kind[kind], self.speeds[n, kind], self.first[kind]
        worn = seen["volume"] + row.length * seen.get("depth", row.stock * seen["stock"])
        area = row.pick * engaged(task, row)
        least = np.where(helpless, np.maximum(SLOWING * last, FLOOR * first), np.minimum(last, first))
        # where the table does not feed, E hardly changes the power, and a fast table keeps the part cool
        feeds = (area > 0.0) & (task.infeed == 0.0)
        rises = self.power.known & (feeds | (seen["peak_power"] < SHARE * row.power))
        most = np.where(rises, self.step * last, last)
        good = first * np.maximum(np.minimum(self.roughness.speed(part), self.size.speed(part)), FLOOR)
        # a slower table would make a hot part hotter; a faster table is tried if Ra is well below its limit
        faster = np.where(seen["roughness"] < SMOOTH, self.step, 1.0) * last
        good = np.where(self.hot, np.maximum(good, faster), good)
        driven = [60.0 * self.power.removal(SHARE * np.asarray(row.power), volume) / np.maximum(area, 1e-9)
                  for volume in (worn, 0.5 * (seen["volume"] + worn))]  # fmt: skip
        undressed, dressed = (np.minimum(np.where(feeds, np.clip(E, least, most), most), good) for E in driven)
        late = seen.get("slack", np.zeros(len(n))) < 0.0
        due = np.where(late, 0.0, np.ceil(worn / self.volumes[n, part]) - 1.0)
        longer = branches.seconds(self.rows, undressed) * self.blocks > self.taken
        wanted = np.maximum(self.wanted, np.where(seen["volume"] > 0.0, np.maximum(due, longer), 0.0))
        begins = seen.get("starts_part", row.starts_part) * seen.get("takes_dresses", np.ones(len(n))) > 0.5
        D = np.where(begins, np.minimum(wanted, task.action.executions), 0.0)
        E = nearest_speed(task, np.where(D > 0.0, dressed, undressed))
        self.kind, self.met, self.dull, self.begun = kind, seen["volume"], worn, True
        return Decision(E, D)

    def _update(self, seen: Mapping[str, Array], n: Numbers) -> None:
        row, power, executions = self.row, seen["peak_power"], np.round(seen.get("last_executions", 0.0 * n))
        width = np.minimum(seen["last_width"], engaged(self.simulation.task, row))
        removal = seen["last_pick"] * width * seen["last_speed"] / 60.0
        # the E that was ground counts, whichever policy chose it
        E, dressed = seen["last_speed"], executions > 0.0
        self.speeds[n, self.kind] = E
        self.wanted = np.where(dressed, 0.0, self.wanted)
        self.taken = np.where(dressed, executions * self.dressing, self.taken)
        self.taken = self.taken + self.simulation.branches.seconds(self.rows, E)
        self.blocks = np.where(dressed, 0.0, self.blocks) + 1.0
        # executions divide the depth of a block evenly: the wheel is dullest before the first or after the last one
        before = self.met + (self.dull - self.met) / (executions + 1.0)
        self.worn = np.where(dressed, np.maximum(before, seen["volume"]), seen["volume"])
        self.power.learn(power, removal, self.worn, (power > 0.0) & (removal > 0.0))
        # the Ra reading belongs to the part before
        told = (seen["roughness"] != self.gauged) & (seen["roughness"] > 0.0)
        self.roughness.learn(seen["roughness"], self.part, self.made, told)
        ended = np.asarray(row.ends_part) > 0.0
        self.gauged, self.part = seen["roughness"], np.where(ended, self.part_of_kind[self.kind], self.part)
        self.made = np.where(ended, self.speeds[n, self.kind] / self.first[self.kind], self.made)
        # a repeated size is the last size, of a part not gauged, or the end of the gauge's range
        told = (seen["size_error"] != self.sized) | (np.abs(seen["size_error"]) > row.size)
        gauged, self.sized = ended & (np.asarray(row.size) > 0.0) & told, seen["size_error"]
        size = np.where(gauged, seen["size_error"], 0.0) / np.maximum(row.size, 1e-9)
        self.size.learn(size, self.part, self.made, gauged)
        self.hot = np.where(gauged, size < -AIM, self.hot)
        off = gauged & ((size > 1.0) | (size < -AIM))
        self.volumes = np.minimum(np.where(ended & ~off, REGAINED, 1.0)[:, None] * self.volumes, self.most)
        # the wheel was too dull: dress it, and make a share of its volume the usual volume
        at = np.flatnonzero(off), self.part[off]
        self.volumes[at] = np.minimum(self.volumes[at], AIM * np.maximum(self.worn[off], 1.0))
        self.wanted = np.maximum(self.wanted, off)
        beyond = power / row.power
        self.wanted = np.maximum(self.wanted, np.where(beyond > FAR, 2.0, beyond > 1.0))
        self.helpless = np.asarray((beyond > FAR) & (executions >= 2.0))

    @property
    def row(self) -> KindRow:
        """Numbers of the last block, or of the coming block as soon as it is known."""
        return KindRow(*self.simulation.kinds[self.rows].T)


def engaged(task: Task, row: KindRow) -> Array:
    """Return the width that a stroke of each block grinds, mm, shape (N,)."""
    return np.asarray(row.width if task.cross_pick == 0.0 else np.minimum(row.width, task.cross_pick))


def usual_volumes(simulation: Simulation, interval: float) -> Array:
    """Return the usual volume between two dresses per kind of block, mm3/mm, as readings count it, shape (kinds,)."""
    p, row = simulation.branches.nominal, KindRow(*simulation.kinds.T)
    _, firsts = np.unique(simulation.branches.kind_of_row, return_index=True)
    # with cross feed, the leading edge of the wheel grinds the whole width
    share = (engaged(simulation.task, row) / row.width)[firsts]
    return np.asarray(interval * share * 1e-3 * p[:, EFFUSIVITY] * np.sqrt(p[:, DIFFUSIVITY]))


def first_speeds(simulation: Simulation) -> Array:
    """Return the first E of each kind of block, mm/min, shape (kinds,): from the program, or else from the handbook."""
    task, own = simulation.task, simulation.branches.own_speeds
    if own is not None:
        return nearest_speed(task, own)
    if task.infeed > 0.0 or task.cross_pick > 0.0:  # strokes are too light for the handbook's power limit
        return nearest_speed(task, np.full(len(task.kinds), USUAL_SPEED))
    return handbook_speeds(task)
