"""A simulation: N episodes of a problem side by side, without Gymnasium: reset, step, observe.

Policies, evaluations, trainings and environments use a problem only through the methods of this class, its `writer`
(`program_writer.py`) and its `viewer` (`picture_builder.py`). Every environment with E and D has a simulation,
`env.unwrapped.simulation`: the single environment steps one episode, the native vector environment and planners many.
Planners, beliefs and advisers also use its `branches`. Tasks (`blocks/task_simulation.py`) and users' programs
(`job/job_simulation.py`) differ in the draws of their episodes, in the script, and in how episodes are written and
shown.
"""

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Numbers, Table
from grind_env.envs.block_rollouts import Branches
from grind_env.envs.compiled_observations import Scaling, heat_column, observe_blocks
from grind_env.envs.cost import Outcome, Shop
from grind_env.envs.episode_state import Episodes, check_running
from grind_env.envs.noise_tape import AHEAD, BLOCKS, DRAWN, SOURCE, TapeRow
from grind_env.envs.observations import Reading, physical
from grind_env.envs.part_surfaces import NEW_PART
from grind_env.envs.past_readings import History
from grind_env.envs.picture_builder import Viewer
from grind_env.envs.program_writer import ProgramWriter
from grind_env.envs.reset_options import Given, with_machines
from grind_env.envs.step_arrays import STAGE_FIELDS, Scratch
from grind_env.envs.task_gauges import noisy
from grind_env.envs.tasks import Task
from grind_env.envs.transition import TOGETHER, step_of
from grind_env.kernel import MANY, MANY_ROWS, compile_at_once
from grind_env.machine.loops.cycle import PartState, Zone
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import SETTINGS
from grind_env.machine.script.script_tables import ScriptTables
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import Process, joined
from grind_env.process.stroke_types import WheelState

if TYPE_CHECKING:
    from grind_env.plants import Plant, Plants

BOOKED, VOLUME = History._fields.index("diameter"), History._fields.index("volume")
DIAMETER, LEAST_DIAMETER = WheelState._fields.index("ds"), Shop._fields.index("least_diameter")
NOTHING_GROUND = np.array(NEW_PART)
NOTHING_KNOWN = np.array(History(*[0.0] * len(History._fields))._replace(gauged=-1.0, survival=1.0))
NO_SETTINGS = np.empty((0, SETTINGS))

SimulationT = TypeVar("SimulationT", bound="Simulation")


class Simulation(ABC):
    """Dynamics of a problem: draws, steps and observes episodes."""

    task: Task  #: names and limits; made from the job for a part program
    entries: tuple[Reading, ...]  #: entries of the observation, the measured ones first
    constant_readings: Mapping[str, float]  #: readings left out of the observation because they never change, by name
    kinds: Table  #: numbers of the rows of its script, shape (rows, fields of `KindRow`)
    process: Process  #: the grinding process
    gauge: Gauge  #: the gauges
    plants: "Plants | None" = None  #: out-of-model machines, one for each episode; None for the model
    branches: Branches  #: further methods for planners, beliefs and advisers
    compiled: bool = True  #: whether steps are compiled, so that many branches can be tried before a choice
    pre_dress: bool = False  #: whether a choice has a third number: 1 for a dress before the first plunge
    unfixable: Mapping[str, str]  #: factors that a context cannot fix, each with the reason
    shops: Table  #: numbers of the task, shape (1, fields of `Shop`)
    whole_program: bool = False  #: as in `Episodes`; tapes are then always full
    tables: ScriptTables  #: tables of the script
    _generator: Any
    _scaling: Scaling
    _lead: Table  #: as in `step_arrays.Tables`, like the next ones
    _base: Table
    _cooler: Table
    _infeed: float = 0.0
    _approach: float = 0.0
    _covered: bool  #: whether the wheel covers the parts
    _extra_state: tuple[float, ...]  #: memory of process and gauge at the start
    _heat: int

    @property
    @abstractmethod
    def writer(self) -> ProgramWriter:
        """Writer of episodes as part programs."""

    @property
    @abstractmethod
    def viewer(self) -> Viewer:
        """Viewer of episodes in pictures."""

    def _grind_with(self, process: Process, gauge: Gauge, state: tuple[float, ...] | None = None) -> None:
        """Set the process, the gauge, and the memory of both at the start."""
        joint = joined(process.own, gauge.own)
        self.process, self.gauge, self._heat, self._scratch = process, gauge, heat_column(joint), Scratch()
        self._extra_state = tuple(joint()) if state is None else (*state, *gauge.own())

    def __getstate__(self) -> dict[str, Any]:
        """Leave out compiled objects of other machines, which are rebuilt from their names."""
        left_out = ("process", "gauge") if self.plants is not None else ()
        return {name: value for name, value in vars(self).items() if name not in left_out}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        if self.plants is not None:
            self.process, self.gauge = self.plants.first.process, noisy(self.plants.first.gauge)

    def start(
        self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None, *, full_tape: bool = True
    ) -> Episodes:
        """Return new episodes, one from each generator, with their fixed parts `given`; `full_tape` as for `room`."""
        if len(rngs) >= MANY:
            compile_at_once()
        episodes = self.empty_episodes(len(rngs), full_tape=full_tape)
        self.restart_all(episodes, range(len(rngs)), rngs, [Given()] * len(rngs) if given is None else given)
        return episodes

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """Replace the episodes at `index` with new ones, one from each generator, with their fixed parts `given`."""
        rows = np.array(index)
        given = with_machines(self, given, rngs)
        self._generator.begin(episodes, rows, rngs, given)
        self.clear(episodes, rows)
        if self.plants is not None:
            episodes.wheels[rows, OWN_FROM:] = [self._begun(each.plant.first) for each in given if each.plant]

    def _begun(self, plant: "Plant") -> tuple[float, ...]:
        """Return the memory at the start of a shift on a machine; exponents of a calibrated job stay."""
        begun = len(plant.of_process)
        return (*plant.of_process, *self._extra_state[begun : len(self.process.own._fields)], *plant.own[begun:])

    def empty_episodes(self, n: int, *, full_tape: bool = True) -> Episodes:
        """Return arrays for N episodes that have not been drawn.

        Tapes are full for a user's program or with `full_tape`; else they have rows for the coming blocks only.
        """
        blocks, zones = self.task.blocks, 0 if self._covered else len(self.tables.zones)
        rows = blocks if full_tape or self.whole_program else min(AHEAD, blocks)
        return Episodes(
            tape=np.empty((n, rows, len(TapeRow._fields))),
            block=np.zeros(n, np.int64),
            wheels=np.empty((n, OWN_FROM + len(self._extra_state))),
            parts=np.empty((n, len(PartState._fields))),
            memory=np.empty((n, len(History._fields))),
            source=np.zeros((n, SOURCE)),
            schedule=np.zeros((n, blocks), np.int16),
            stages=np.zeros((n, STAGE_FIELDS)),
            surfaces=np.empty((n, zones, len(Zone._fields))),
            machine=np.zeros(n, np.int64),
            forces=np.ones((n, 1)),
            whole_program=self.whole_program,
        )

    def with_full_tapes(self, episodes: Episodes) -> Episodes:
        """Return copies of the episodes with their full noise tapes; missing rows are drawn again."""
        copies = episodes.pick(np.arange(len(episodes.block)))
        if copies.tape.shape[1] < self.task.blocks:
            block, copies.block = copies.block, np.zeros_like(copies.block)
            copies.tape = np.empty((len(block), self.task.blocks, len(TapeRow._fields)))
            copies.source[:, DRAWN] = 0.0
            self._generator.draw(copies)
            copies.block = block
        return copies

    def clear(self, episodes: Episodes, index: Numbers) -> None:
        """Reset the episodes at `index`, shape (M,), to their start, except for their wheels."""
        episodes.wheels[index, OWN_FROM:] = self._extra_state
        episodes.block[index] = 0
        episodes.parts[index] = NOTHING_GROUND
        episodes.memory[index] = NOTHING_KNOWN
        episodes.memory[index, VOLUME] = self.task.start.volume
        episodes.memory[index, BOOKED] = episodes.wheels[index, DIAMETER]
        episodes.stages[index], episodes.machine[index], episodes.forces[index] = 0.0, 0, 1.0

    def applied_choice(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        """Return the choice as the coming blocks take it, each of shape (N,)."""
        return choice

    def step(
        self,
        episodes: Episodes,
        speeds: Table,
        executions: Table,
        pre_dresses: Table | None = None,
        *,
        settings: Table | None = None,
        active: NDArray[np.int64] | None = None,
    ) -> tuple[Table, Table]:
        """Grind the next block of the episodes in `active` (indices; all by default).

        Args:
            episodes: changed in place.
            speeds: E in mm/min, shape (N,).
            executions: D, shape (N,).
            pre_dresses: 1 for a dress before the first plunge, else 0, shape (N,); none by default.
            settings: J, L and dress settings in place of those of a user's program, shape (N, fields of
                `BlockSettings`); its E and D do not count. Not for tasks.
            active: indices of the episodes to step; they must not be over.

        Returns:
            Outcomes, shape (N, fields of `Outcome`), and results of the cycles, with all the time of their blocks,
            shape (N, fields of `Tally`); rows of other episodes are 0.

        Raises:
            EpisodeOver: an episode in `active` has run its last block.
            GrindError: a block cannot be run with these choices; all episodes are then unchanged.
        """
        n = len(episodes.block)
        none = np.zeros(n) if pre_dresses is None else pre_dresses
        choice = speeds, executions, none, NO_SETTINGS if settings is None else settings
        everyone = active is None or active.size == n
        room = self._scratch.take(min(n, TOGETHER) if everyone else n)
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
        step = step_of(self.process, self.gauge, self._covered)
        if active.size >= MANY_ROWS:
            compile_at_once()
        tables, state = self._tables(room), episodes.in_order()
        if active.size <= TOGETHER or active.size < n:
            step(tables, state, choice, active, results, outcomes)
            return outcomes, results
        for first in range(0, n, TOGETHER):  # one room for all chunks stays in the processor's cache
            some = slice(first, first + TOGETHER)
            state, chosen = (tuple(array[some] for array in arrays) for arrays in (episodes.in_order(), choice))
            step(tables, state, chosen, np.arange(len(state[0])), results[some], outcomes[some])
        return outcomes, results

    def _tables(self, room: Sequence[Any]) -> tuple[Any, ...]:
        """Return the tables of the compiled step, with room for N machines; the step itself writes motions of a G81."""
        *room, motions = room
        blocks, plans, own, rest_times, written, zones = self.tables
        motions = motions if self._infeed > 0.0 else written
        numbers = self.kinds, self._base, self._cooler, self.shops, self._generator.kinds, self._generator.spreads
        return blocks, plans, own, rest_times, motions, zones, *numbers, self._lead, self._infeed, self._approach, *room

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        """Return which episodes have ground their last block, shape (N,)."""
        return np.asarray(episodes.block >= episodes.source[:, BLOCKS])

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Return the observations of the coming blocks, shape (N, entries), float32.

        After the last block of an episode the coming block reads as zeros.
        """
        observations = np.zeros((len(episodes.block), len(self.entries)), np.float32)
        observe_blocks(
            self.kinds,
            self.task.blocks,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            self._heat,
            episodes.memory,
            self.shops,
            *self._scaling,
            observations,
        )
        return observations

    def read(self, observation: NDArray[np.float32]) -> dict[str, Table]:
        """Return observations in physical units, by name, each shape (N,), with readings that never change."""
        constant = {name: np.full(len(observation), value) for name, value in self.constant_readings.items()}
        seen = constant | physical(observation, self.entries[: observation.shape[1]])
        # on a part wider than the wheel, power belongs to the width of the wheel
        return seen | {"last_width": np.minimum(seen["last_width"], self.task.wheel.width)}


def without_wheel_changes(simulation: SimulationT) -> SimulationT:
    """Return a copy that never changes a worn wheel by itself."""
    twin = copy.copy(simulation)
    twin.shops = simulation.shops.copy()
    twin.shops[:, LEAST_DIAMETER] = 0.0
    return twin


def with_start_of(simulation: SimulationT, plant: "Plant") -> SimulationT:
    """Return a copy in which `clear` starts episodes with the memory of another machine of the same families."""
    twin = copy.copy(simulation)
    twin._extra_state = plant.own
    return twin


def advance(simulation: Simulation, episodes: Episodes, speeds: Table, executions: Table) -> tuple[Table, Table]:
    """Step the episodes that are not over, as `Simulation.step`; shapes are for all N."""
    running = ~simulation.over(episodes)
    return simulation.step(episodes, speeds, executions, active=None if running.all() else np.flatnonzero(running))
