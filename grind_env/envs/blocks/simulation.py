"""Episodes of a task whose steps are cycle blocks: its program has holes for E and D, and its tape says the stocks."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers, Table
from grind_env.control import read
from grind_env.envs.blocks.branches import BlockBranches
from grind_env.envs.blocks.episode import EpisodeGenerator
from grind_env.envs.blocks.observe import heat_column, observe_blocks
from grind_env.envs.blocks.program import (
    block_text,
    coming_block,
    conditions,
    job_of,
    program_of,
    request_times,
)
from grind_env.envs.blocks.script import task_script
from grind_env.envs.contexts import Given, drawn, without_effect
from grind_env.envs.cost import Outcome, Shop, shop_row
from grind_env.envs.episodes import Episodes, EpisodesT, check_running
from grind_env.envs.gauge import GAUGE, noisy
from grind_env.envs.history import ShopMemory
from grind_env.envs.observations import Reading, constant_readings, physical, readings, scaling
from grind_env.envs.simulation import Written
from grind_env.envs.tables import kind_table
from grind_env.envs.tape import AHEAD, BLOCKS, DRAWN, SOURCE, TapeRow
from grind_env.envs.tasks import Task
from grind_env.envs.transition import NEW_PART, STAGE_FIELDS, Scratch, Tables, step_of
from grind_env.envs.view import view_of
from grind_env.kernel import MANY, MANY_ROWS, compile_at_once
from grind_env.machine.grind import grind
from grind_env.machine.job import WheelStart
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.feeding import Feeding
from grind_env.machine.loops.rows import OWN_FROM, RULES_FROM
from grind_env.machine.loops.strips import Zone
from grind_env.machine.loops.tally import Tally
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script.settings import SETTINGS
from grind_env.process.gauge import Gauge
from grind_env.process.process import PROCESS, Process, joined
from grind_env.process.state import WheelState
from grind_env.render.view import EpisodePicture

if TYPE_CHECKING:
    from grind_env.plants import Plant, Plants

BOOKED, VOLUME = ShopMemory._fields.index("diameter"), ShopMemory._fields.index("volume")
DIAMETER, LEAST_DIAMETER = WheelState._fields.index("ds"), Shop._fields.index("least_diameter")
CYCLES = Tables._fields.index("cycles") - Tables._fields.index("parameters")
NO_SETTINGS = np.empty((0, SETTINGS))
NOTHING_GROUND = np.array(NEW_PART)
NOTHING_KNOWN = np.array(ShopMemory(*[0.0] * len(ShopMemory._fields))._replace(gauged=-1.0, survival=1.0))

SimulationT = TypeVar("SimulationT", bound="BlockSimulation")


class BlockSimulation:
    """Steps episodes of one task; the methods are those of `Simulation`.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        pre_dress: whether a choice has a dress before the first plunge, and observations show the last one.
        process: what grinds.
        gauge: what is measured of it.
        plants: machines that are not the model, in place of both; each episode has one of them.

    Attributes:
        task: the task.
        process: as given, like the next one.
        gauge: as given, like the next one.
        plants: None for the model.
        entries: of the observation, the measured ones first.
        kinds: numbers of the kinds of blocks, shape (rows, fields of `KindRow`).
        branches: of its blocks.
        pre_dress: as given.
        barred: what a context cannot fix.
        usual: readings that the environment does not show because they never change, by name.
    """

    compiled: ClassVar[bool] = True

    def __init__(
        self,
        task: Task,
        *,
        full: bool = False,
        pre_dress: bool = False,
        process: Process = PROCESS,
        gauge: Gauge = GAUGE,
        plants: "Plants | None" = None,
    ) -> None:
        if plants is not None:
            process, gauge = plants.first.process, noisy(plants.first.gauge)
        self.task, self.pre_dress, self.barred = task, pre_dress, without_effect(task)
        own = joined(process.own, gauge.own)
        self.plants = plants
        self.process, self.gauge, self._own, self._heat = process, gauge, tuple(own()), heat_column(own)
        self.entries = readings(task, full=full, pre_dress=pre_dress)
        self.kinds, self.branches = kind_table(task), BlockBranches(task)
        script = task_script(task, self.kinds)
        self._lead, self._whole = script.lead, script.whole
        self._script, self._base, self._cooler = script.tables, self.branches.base[None], np.zeros((1, 1))
        self._zones = 0 if script.whole else len(script.tables.zones)
        self._infeed = task.infeed / 60.0
        self.usual: Mapping[str, float] = constant_readings(task, pre_dress=pre_dress)
        self._shops = np.array([shop_row(task)])
        self._materials = len(task.materials)
        self._scaling = scaling(task, self.entries)
        self._generator = EpisodeGenerator(task)
        self._scratch = Scratch()

    def __getstate__(self) -> dict[str, Any]:
        """What grinds and shows other machines is found again by their name."""
        left_out = ("process", "gauge") if self.plants is not None else ()
        return {name: value for name, value in vars(self).items() if name not in left_out}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        if self.plants is not None:
            self.process, self.gauge = self.plants.first.process, noisy(self.plants.first.gauge)

    @property
    def most_steps(self) -> int:
        return self.task.blocks

    def start(
        self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None, *, whole: bool = True
    ) -> Episodes:
        if len(rngs) >= MANY:
            compile_at_once()
        episodes = self.room(len(rngs), whole=whole)
        self.restart_all(episodes, range(len(rngs)), rngs, [Given()] * len(rngs) if given is None else given)
        return episodes

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        rows = np.array(index)
        given = drawn(self, given, rngs)
        self._generator.begin(episodes, rows, rngs, given)
        self.clear(episodes, rows)
        if self.plants is not None:
            seat(episodes, rows, given)

    def room(self, n: int, *, whole: bool = True) -> Episodes:
        return Episodes(**self._room(n, whole))

    def _room(self, n: int, whole: bool) -> dict[str, Any]:
        blocks = self.task.blocks
        return room_for(n, blocks, blocks if whole else min(AHEAD, blocks), self._own, self._zones)

    def whole(self, episodes: EpisodesT) -> EpisodesT:
        """As `Simulation.whole`; what has not been kept of the tapes is drawn again."""
        copies = episodes.pick(np.arange(len(episodes.block)))
        if copies.tape.shape[1] < self.task.blocks:
            block, copies.block = copies.block, np.zeros_like(copies.block)
            copies.tape, copies.source[:, DRAWN] = self._room(len(block), True)["tape"], 0.0
            self._generator.draw(copies)
            copies.block = block
        return copies

    def tape(self, episodes: Episodes, i: int) -> Table:
        """The whole tape of episode i, shape (blocks, fields of `TapeRow`)."""
        return np.asarray(self.whole(episodes.pick([i])).tape[0])

    def clear(self, episodes: Episodes, index: Numbers) -> None:
        forget(episodes, index, self.task.start.volume, self._own)

    def without_wheel_changes(self: SimulationT) -> SimulationT:
        twin = copy.copy(self)
        twin._shops = without_least_diameter(self._shops)
        return twin

    def holding(self: SimulationT, plant: "Plant") -> SimulationT:
        """The same, in which whatever begins without being drawn is on a machine of the same families."""
        twin = copy.copy(self)
        twin._own = plant.own
        return twin

    def taken(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        return choice

    def step(
        self,
        episodes: Episodes,
        speeds: Table,
        executions: Table,
        pre_dresses: Table | None = None,
        *,
        active: NDArray[np.int64] | None = None,
    ) -> tuple[Table, Table]:
        n = len(episodes.block)
        choice = speeds, executions, np.zeros(n) if pre_dresses is None else pre_dresses
        room = self._scratch.take(n)
        results = self._run(episodes, choice, np.arange(n) if active is None else active, room)
        self._scratch.give_back(room)
        return results

    def _run(
        self, episodes: Episodes, choice: tuple[Table, ...], active: NDArray[np.int64], room: tuple[Any, ...]
    ) -> tuple[Table, Table]:
        """Step the episodes in `active` and leave the cycles of the blocks in `room`."""
        check_running(episodes, active, episodes.source[:, BLOCKS])
        n = len(episodes.block)
        outcomes, results = np.zeros((n, len(Outcome._fields))), np.zeros((n, len(Tally._fields)))
        step = step_of(self.process, self.gauge, self._whole)
        if active.size >= MANY_ROWS:
            compile_at_once()
        step(self._tables(room), episodes.in_order(), (*choice, NO_SETTINGS), active, results, outcomes)
        return outcomes, results

    def _tables(self, room: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return the tables of the compiled step, with room for N machines; of a G81 the step writes the motions."""
        blocks, plans, own, ways, motions, zones = self._script
        if self._infeed > 0.0:
            most = 2 * (self.task.action.executions + 1)
            motions = np.empty((len(room[0]) * most, motions.shape[1]))
        script = blocks, plans, own, ways, motions, zones
        drawn = self._generator.kinds, self._generator.spreads
        numbers = self.kinds, self._base, self._cooler, self._shops, *drawn, self._lead, self._infeed, 0.0
        return *script, *numbers, *room

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        return episodes.block >= self.task.blocks

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        observations = np.zeros((len(episodes.block), len(self._scaling.offset)), np.float32)
        observe_blocks(
            self.kinds,
            self.task.blocks,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            self._heat,
            episodes.memory,
            self._shops,
            *self._scaling,
            observations,
        )
        return observations

    def read(self, observation: NDArray[np.float32]) -> dict[str, Table]:
        seen = readings_of(observation, self.entries, self.usual)
        # power is spent on the width of the wheel, of a part that is wider
        return seen | {"last_width": np.minimum(seen["last_width"], self.task.wheel.width)}

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> Any:
        block = coming_block(self.task, episodes, i, speed, executions, pre_dress)
        if self._infeed == 0.0 or self.process.before is None:
            return block
        # how long a stroke takes on a table with a speed of its own, a copy shows
        room = self._scratch.take(1)
        choice = tuple(np.array([number]) for number in (speed, executions, pre_dress))
        self._run(episodes.pick([i]), choice, np.arange(1), room)
        found = Feeding(*room[CYCLES][0, RULES_FROM : RULES_FROM + len(Feeding._fields)].tolist())
        self._scratch.give_back(room)
        return block._replace(stroke=(found.travel, found.dwell))

    def text(self, block: Any) -> str:
        return block_text(self.task, block)

    def program(self, blocks: Sequence[Any]) -> str:
        return program_of(self.task, blocks)

    def written(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> Written:
        program, found, start = self.program(blocks), blocks[0].wheel, self.task.start
        wheel = WheelStart(
            diameter=found.ds,
            diamond_flat=found.wd,
            wear_flat_area=None if start.wear_flat_area is None else found.A,
            volume_since_dress=None if start.wear_flat_area is None else found.V,
        )
        parts, own = conditions(self.task, self.tape(episodes, i)), blocks[0].own[: len(self.process.own._fields)]
        shop = replace(job_of(self.task, blocks), wheel=wheel, parts=tuple(parts), process=self.process, own=own)
        return Written(program, shop, request_times(read(program), shop))

    def record(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> GrindingRecord:
        program, shop, requests = self.written(episodes, i, blocks)
        return grind(read(program), shop, control=replace(shop.control, operator_dress_at=requests))

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        return view_of(self.task, episodes, i, blocks, outcomes, self.text(blocks[-1]) if blocks else "")


def room_for(n: int, blocks: int, rows: int, own: tuple[float, ...], zones: int) -> dict[str, Any]:
    """Arrays for N episodes of that many blocks, by name.

    Tapes have so many `rows`, and `own` is what process and gauge remember at the start; parts have so many `zones`, or
    none that the wheel covers.
    """
    return {
        "tape": np.empty((n, rows, len(TapeRow._fields))),
        "block": np.zeros(n, np.int64),
        "wheels": np.empty((n, OWN_FROM + len(own))),
        "parts": np.empty((n, len(PartState._fields))),
        "memory": np.empty((n, len(ShopMemory._fields))),
        "source": np.zeros((n, SOURCE)),
        "schedule": np.zeros((n, blocks), np.int16),
        "stages": np.zeros((n, STAGE_FIELDS)),
        "surfaces": np.empty((n, zones, len(Zone._fields))),
        "machine": np.zeros(n, np.int64),
        "forces": np.ones((n, 1)),
    }


def forget(episodes: Episodes, index: Numbers, volume: float, own: tuple[float, ...]) -> None:
    """Let the episodes at `index`, shape (M,), begin with their wheels, which have ground `volume`, mm3/mm.

    `own` is what process and gauge then remember besides.
    """
    episodes.wheels[index, OWN_FROM:] = own
    episodes.block[index] = 0
    episodes.parts[index] = NOTHING_GROUND
    episodes.memory[index] = NOTHING_KNOWN
    episodes.memory[index, VOLUME] = volume
    episodes.memory[index, BOOKED] = episodes.wheels[index, DIAMETER]
    episodes.stages[index], episodes.machine[index], episodes.forces[index] = 0.0, 0, 1.0


def seat(episodes: Episodes, index: Numbers, given: Sequence[Given]) -> None:
    """Let the episodes at `index`, shape (M,), begin on the machines that are given."""
    episodes.wheels[index, OWN_FROM:] = [each.plant.first.own for each in given if each.plant is not None]


def without_least_diameter(shops: Table) -> Table:
    """The numbers of a shop, shape (1, fields of `Shop`), in which no wheel is too small."""
    shops = shops.copy()
    shops[:, LEAST_DIAMETER] = 0.0
    return shops


def readings_of(
    observation: NDArray[np.float32], entries: tuple[Reading, ...], usual: Mapping[str, float]
) -> dict[str, Table]:
    """What observations say in physical units, and what is usual where they do not, by name, each shape (N,)."""
    constant = {name: np.full(len(observation), value) for name, value in usual.items()}
    return constant | physical(observation, entries[: observation.shape[1]])
