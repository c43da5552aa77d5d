"""Episodes of parts that are wider than the wheel: the control runs a program of G83 blocks, one block a step.

Strokes, strips and wheel are those of `machine.run`; cost and memory are those of `envs.step.settle`.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.control import read
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.contexts import Given
from grind_env.envs.form import check_width
from grind_env.envs.observations import SIZE_NOISE, Reading, readings
from grind_env.envs.program import CycleBlock, coming_block, conditions, job_from_surface
from grind_env.envs.program_episode import BlockRun, ProgramEpisode, step_all
from grind_env.envs.rows import KindRow, Memory, Outcome
from grind_env.envs.simulation import Episodes, Simulation, Table
from grind_env.envs.step import Choices, Tables, settle
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Task, TaskError
from grind_env.envs.wide_plates.program import chosen_words, part_program
from grind_env.machine.cycle import Cycle, PartState
from grind_env.machine.tally import NOTHING, POWER_WINDOW, Tally
from grind_env.process.catalogue import materials
from grind_env.process.state import StrokeParameters, WheelState

TAPER_NOISE = SIZE_NOISE * 2.0**0.5
"""um; standard deviation of a taper, the difference of two sizes."""

LOAD, STOCK, TARGET = (
    KindRow._fields.index("load"),
    TapeRow._fields.index("stock"),
    Cycle._fields.index("target"),
)


@dataclass(slots=True)
class CrossEpisodes(Episodes):
    """The state of N episodes under way.

    `programs` are those under execution; `taper` of the last finished part in um as gauged, shape (N,);
    `taper_noise` of each part in um, shape (N, blocks).
    """

    programs: list[ProgramEpisode]
    taper: Table
    taper_noise: Table

    def pick(self, index: ArrayLike) -> "CrossEpisodes":
        """Copies of the episodes at `index` (which may repeat); each runs its program anew up to where it is."""
        chosen = np.asarray(index)
        arrays = {f.name: getattr(self, f.name)[chosen] for f in fields(self) if f.name != "programs"}
        return CrossEpisodes(programs=[copy.deepcopy(self.programs[i]) for i in chosen.tolist()], **arrays)


class CrossSimulation(Simulation):
    """Steps episodes of a task whose parts are wider than the wheel; arguments as for `Simulation`.

    Raises:
        TaskError: the task does not have one kind of block, a whole part wider than the wheel, or no cross pick.
    """

    def __init__(self, task: Task, *, full: bool = False, pre_dress: bool = False) -> None:
        check_width(task, "G83")
        if len(task.kinds) > 1 or not (task.kinds[0].starts_part and task.kinds[0].ends_part):
            raise TaskError(f"{task.name} has several kinds of blocks; a G83 task has one, which is a whole part")
        if not task.cross_pick > 0.0:
            raise TaskError(f"{task.name}: cross_pick is {task.cross_pick:g}, but must be above 0 mm for a G83")
        super().__init__(task, full=full, pre_dress=pre_dress)
        # the time of a part in the record includes its loading
        self._judged = self.kinds.copy()
        self._judged[:, LOAD] = 0.0
        self._job = job_from_surface(task)

    def start(self, rngs: Sequence[np.random.Generator], given: Sequence[Given] | None = None) -> CrossEpisodes:
        """New episodes, one from each generator, with what is given of each."""
        n = len(rngs)
        episodes = CrossEpisodes(
            np.empty((n, self.task.blocks, len(TapeRow._fields))),
            np.zeros(n, np.int64),
            np.empty((n, len(WheelState._fields))),
            np.empty((n, len(PartState._fields))),
            np.empty((n, len(Memory._fields))),
            [],
            np.zeros(n),
            np.empty((n, self.task.blocks)),
        )
        self.restart_all(episodes, range(n), rngs, [Given()] * n if given is None else given)
        return episodes

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """Put new episodes at `index`, whether there is a program yet or not; else as `Simulation.restart_all`."""
        cross = _cross(episodes)
        super().restart_all(cross, index, rngs, given)
        for i, rng, each in zip(index, rngs, given, strict=True):
            noise = 1.0 if np.isnan(each.fixed.noise) else each.fixed.noise
            cross.taper[i] = 0.0
            spread = noise * self.task.spread.measurement * TAPER_NOISE
            cross.taper_noise[i] = spread * rng.standard_normal(self.task.blocks)
            cross.programs[i : i + 1] = [self._program(cross.tape[i], WheelState(*cross.wheels[i].tolist()))]

    def step(
        self,
        episodes: Episodes,
        speeds: Table,
        executions: Table,
        pre_dresses: Table | None = None,
        *,
        active: NDArray[np.int64] | None = None,
    ) -> tuple[Table, Table]:
        """Grind the next part of the episodes in `active`; as `Simulation.step`.

        The part is judged where it is farthest from its size, as in the record.

        Raises:
            GrindError: a part cannot be ground so; every episode is then as it was before.
        """
        cross, n = _cross(episodes), len(episodes.block)
        active = np.arange(n) if active is None else active
        pre = np.zeros(n) if pre_dresses is None else pre_dresses
        outcomes, results = np.zeros((n, len(Outcome._fields))), np.zeros((n, len(Tally._fields)))
        cycles, parameters = np.zeros((n, len(Cycle._fields))), np.zeros((n, len(StrokeParameters._fields)))
        blocks = {i: coming_block(self.task, cross, i, speeds[i], executions[i], pre[i]) for i in active.tolist()}
        for i, run in step_all(cross.programs, {i: chosen_words(block) for i, block in blocks.items()}).items():
            part, program = run.finished[0], cross.programs[i]
            stock = float(part["stock"])
            results[i] = result_of(run, blocks[i].kind.pick)
            cycles[i, TARGET] = stock
            parameters[i] = program.run.part.p
            cross.wheels[i] = np.array(program.run.wheel)
            cross.parts[i] = PartState(Z=stock, S=stock - 0.001 * float(part["worst_error"]), Rs=float(part["Ra"]))
            cross.taper[i] = float(part["taper"]) + cross.taper_noise[i, cross.block[i]]
        tables = Tables(self._judged, self.base, self.shop, len(materials()))
        choices = Choices(speeds, executions, pre)
        settle(tables, cross.arrays(), choices, active, cycles, parameters, results, outcomes)
        return outcomes, results

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Observations of the coming blocks, shape (N, entries), float32; the taper is the last entry."""
        reading = self.entries[-1]
        taper = np.clip((_cross(episodes).taper - reading.offset) / reading.scale, reading.low, reading.high)
        observations = super().observe(episodes)
        observations[:, -1] = taper
        return observations

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """Those of the task with the size where it is worst, and the taper, which only a part ground in strips has."""
        return (*(_at_worst(entry) for entry in readings(task, full=full, pre_dress=pre_dress)), taper_reading(task))

    def _program(self, tape: Table, wheel: WheelState) -> ProgramEpisode:
        """The program of an episode at its first block; E and D stand in it to be replaced."""
        kind, start = self.task.kinds[0], self.task.start
        found = replace(
            self._job.wheel,
            diameter=wheel.ds,
            diamond_flat=wheel.wd,
            wear_flat_area=start.wear_flat_area,
            volume_since_dress=start.volume,
        )
        blocks = [CycleBlock(kind, 0.0, stock, 1.0, 0, False, 0) for stock in tape[:, STOCK].tolist()]
        programs = read(part_program(self.task, blocks))
        return ProgramEpisode(programs, replace(self._job, wheel=found), conditions(self.task, tape))


def taper_reading(task: Task) -> Reading:
    """The entry of the observation that only a part ground in strips has."""
    factor = task.spread.measurement
    noise = f"{TAPER_NOISE * factor:.2g} um" if factor > 0.0 else "exact"
    meaning = "range of the size across the last finished part"
    return Reading("taper", "um", 0.0, max(task.kinds[0].tolerance, 1.0), 0.0, 5.0, noise, meaning)


def result_of(run: BlockRun, pick: float) -> Tally:
    """What the cycle of a whole part leaves behind, its loading included in the seconds.

    Args:
        run: from its cycle block to the next one.
        pick: J, mm; strokes that go as much deeper count as full plunges.
    """
    part, power = run.finished[0], run.strokes["power"]
    full = np.flatnonzero(run.increments >= pick - DEPTH_TOLERANCE)
    first, last = full[: int(POWER_WINDOW)], full[-int(POWER_WINDOW) :]
    last = last[last >= (run.dresses["after"][-1] if run.dresses.size else 0)]
    return NOTHING._replace(
        seconds=float(part["seconds"]),
        strokes=float(part["strokes"]),
        dresses=float(part["dresses"]),
        first_power=float(power[first].sum()),
        first_count=float(first.size),
        power_1=float(power[last].sum()),
        last_count=float(last.size),
        peak_power=float(part["peak_power"]),
        plunge_rise=float(part["rise"]),
        finish_rise=float(part["rise"]),
        burn_ratio=float(part["burn_ratio"]),
        worn=float(part["worn"]),
        dressed_off=float(part["dressed_off"]),
    )


def _at_worst(entry: Reading) -> Reading:
    if entry.name != "size_error":
        return entry
    return entry._replace(meaning="stock left on the last finished part where it is farthest from its size")


def _cross(episodes: Episodes) -> CrossEpisodes:
    assert isinstance(episodes, CrossEpisodes)
    return episodes
