"""The simulation of a user's part program: N episodes side by side, without Gymnasium.

A program that has a script is replayed in compiled code; the control executes any other, one machine after the other.
Both are judged and remembered by the same compiled functions.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Numbers, Table
from grind_env.control import Programs
from grind_env.control.cycles import list_codes
from grind_env.envs.block_rollouts import ProgramBranches
from grind_env.envs.block_settling import price_of_handover, settle_of
from grind_env.envs.compiled_observations import scaling
from grind_env.envs.cost import Found, Outcome, Shop
from grind_env.envs.episode_state import Episodes, check_running
from grind_env.envs.job.cost_inputs import kind_of, machines_of, shop_of, tally_of
from grind_env.envs.job.job_noise_tape import JobGenerator, conditions_of, unfixable_factors
from grind_env.envs.job.job_observation import action_of, coming, constant_readings, job_readings, job_task, kinds_of
from grind_env.envs.job.program_outline import (
    INCH,
    JobChoice,
    JobProgramError,
    course_of,
    outline_of_runs,
    outline_of_script,
    parts_of,
    refuse_many,
    refuse_more,
)
from grind_env.envs.job.writer import JobWriter
from grind_env.envs.noise_tape import BLOCKS
from grind_env.envs.past_readings import FOUND
from grind_env.envs.picture_builder import ProgramViewer, Viewer
from grind_env.envs.program_episode import BlockRun, ProgramEpisode, Words, step_all
from grind_env.envs.program_writer import ProgramWriter
from grind_env.envs.reset_options import Given, with_machines
from grind_env.envs.simulation import DIAMETER, Simulation
from grind_env.envs.step_arrays import KIND, EpisodeArrays
from grind_env.envs.task_gauges import GAUGE, noisy
from grind_env.machine.job import Job, PartConditions, require_conditions
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import D, E, Ranges, own_settings
from grind_env.machine.script.script import Script, script_of
from grind_env.machine.script.script_block import ScriptError
from grind_env.machine.script.script_tables import is_covered, tables_of
from grind_env.machine.script.settings_completion import complete_settings
from grind_env.process.gauge_readings import Gauge

if TYPE_CHECKING:
    from grind_env.plants import Plants

CHANGE_SECONDS = Shop._fields.index("change_seconds")
COST, STROKES = Outcome._fields.index("cost"), Tally._fields.index("strokes")


def ranges_of(job: Job, picks: Sequence[float] = (), spark_outs: Sequence[int] = ()) -> Ranges:
    """Return the ranges of choices in the blocks of a program.

    Args:
        job: the job.
        picks: lowest and highest J, mm; none to keep the J of the program.
        spark_outs: lowest and highest L; none to keep the L of the program.
    """
    return Ranges(E=action_of(job).speed_ends, J=picks, L=spark_outs)


class JobSimulation(Simulation):
    """Simulation of a part program.

    Args:
        programs: the program.
        job: the job.
        spread: factor on all random deviations.
        full: whether observations show the hidden state.
        picks: lowest and highest J to choose from, mm; none to keep the J of the program.
        spark_outs: lowest and highest L to choose from; none to keep the L of the program.
        name: name in tables and folders; the file name without suffix if None.
        file: file of the program; empty for a program of the package.
        gauge: the gauges; the process comes from the job.
        plants: out-of-model machines in place of gauge and process; each episode has one of them.
        between: called between two blocks while the control executes the program; an error in it ends the execution.
        script: script of the program, or of more runs of it; None to make it.
        once: the original program, if `programs` is a batch of it.

    Raises:
        GrindError: the program cannot be run, or there is nothing to choose in it.
    """

    branches: ProgramBranches
    whole_program = True

    def __init__(
        self,
        programs: Programs,
        job: Job,
        spread: float,
        *,
        full: bool = False,
        picks: Sequence[float] = (),
        spark_outs: Sequence[int] = (),
        name: str | None = None,
        file: str = "",
        between: Callable[[], object] = lambda: None,
        gauge: Gauge = GAUGE,
        plants: "Plants | None" = None,
        script: Script | None = None,
        once: Programs | None = None,
    ) -> None:
        if plants is not None:
            job, gauge = replace(job.on(plants.first), own=()), noisy(plants.first.gauge)
        self.plants = None  # the reference cost is the cost on the model
        self.unread = refuse_many(programs, job)  # a sentence for each variable of the job that the program ignores
        self._grind_with(job.process, gauge, job.own_at_start)
        task = job_task(name or Path(programs.name).stem, job, spread, file)
        self.programs, self.job, self.spread = programs, job, spread
        self.once = once or programs
        self.unfixable = unfixable_factors(spread)
        self.why: ScriptError | None = None  # why the control must execute the program; None if it has a script
        self.script: Script | None = None
        try:
            self.script = script_of(programs, job, ranges_of(job, picks, spark_outs)) if script is None else script
            refuse_more(programs, len(self.script.blocks))
            self.tables, self._approach = tables_of(self.script), self.script.approach
            self.job = job = self.script.job
        except ScriptError as error:
            self.why, self.script = error, None
            if job.stations:
                remedy = "with [[stations]] that is for grind run alone, and others need each part finished in turn"
                raise JobProgramError(f"{error}; {remedy}") from None
        if self.script is None:
            (low, high), most = task.action.speed_ends, task.action.executions
            trials = [JobChoice(low, most), JobChoice(high, 0), JobChoice(high, most)]
            self.blocks = outline_of_runs(programs, job, trials, between)
        else:
            self.blocks = outline_of_script(self.script, self.tables)
        if not self.blocks:
            raise JobProgramError(
                f"{programs.name} makes no stroke: it has no cycle block {list_codes('or')} and no feed move along the "
                "table over the part, and no E, F or D to choose"
            )
        self.compiled = self.script is not None
        self._covered = self.script is None or is_covered(self.script, self.tables)
        self.part_of_block = np.array([block.part for block in self.blocks])
        self.parts = parts_of(self.blocks)
        require_conditions(job.parts, self.parts, programs.name)
        kind_of_block, kinds = kinds_of(task, self.blocks, job)
        self.branches = ProgramBranches(self.blocks, job, kind_of_block, task.wheel_revolutions)
        sequence = tuple(kinds[number].name for number in kind_of_block.tolist())
        self.task = replace(task, blocks=len(self.blocks), kinds=kinds, sequence=sequence)
        constant = constant_readings(self.blocks, job, spread, picks=bool(picks))
        self.entries = job_readings(task, constant, full=full)
        self._stocks = [job.of_part(number).part.stock for number in range(1, self.parts + 1)]
        engaged = min(job.part.width, job.setup.wheel.width)
        self.constant_readings = {"last_width": engaged, "stock": 1.0, "tolerance": job.part.tolerance, **constant}
        self.kinds = np.array([kind_of(block, job.of_part(block.part + 1)) for block in self.blocks])
        self._settings = np.array([own_settings(block.plan, block.dress) for block in self.blocks])
        self.shops, self._lead = np.array([shop_of(job, 1.0)]), np.full(len(self.blocks), -1.0)
        self._said_of = coming(self.blocks, self.entries)
        self._said = np.flatnonzero(np.isfinite(self._said_of).all(axis=0))
        # each block has a row of its own in `kinds`, and the material is that of the job
        scaled = scaling(task, self.entries)
        self._scaling = scaled._replace(layout=scaled.layout._replace(materials=np.array([-1])))
        self._takes_dresses = np.array([float(block.takes_dresses) for block in self.blocks])
        self._inch = np.array([block.inch for block in self.blocks])
        self._generator = self._generator_of(0.0)
        self._set_machines([job])
        cost = self._nominal_cost(between)
        if not cost > 0.0:
            raise JobProgramError(
                f"{programs.name} costs nothing with this job; give its machine an hourly_rate above 0"
            )
        self.task, self.shops = replace(self.task, reference_cost=cost), np.array([shop_of(job, cost)])
        self._generator, self.plants = self._generator_of(spread), plants

    def _generator_of(self, spread: float) -> JobGenerator:
        job, blocks = self.job, self.part_of_block.tolist()
        return JobGenerator(blocks, job.lots, self._stocks, spread, self.branches.wheel, job.parts[: self.parts])

    def with_spread(self, spread: float) -> "JobSimulation":
        """Return a copy with another factor on all random deviations: 0 for nominal parts."""
        twin = copy.copy(self)
        twin._generator = self._generator_of(spread)
        return twin

    def on_machines(self, jobs: Sequence[Job]) -> "JobSimulation":
        """Return a copy on other machines with the same process, for `start_on`."""
        twin = copy.copy(self)
        twin._set_machines(jobs)
        twin._grind_with(jobs[0].process, self.gauge, jobs[0].own_at_start)
        return twin

    def _set_machines(self, jobs: Sequence[Job]) -> None:
        self.machines = machines_of(jobs, self.blocks, self.job)
        self._base, self._cooler = self.machines.base, self.machines.cooler

    def _nominal_cost(self, between: Callable[[], object]) -> float:
        """Return the cost of the unchanged program on nominal parts, $ per cycle block."""
        episodes, total = self.start([np.random.default_rng(0)]), 0.0
        strokes = []
        for block in self.blocks:
            outcomes, tallies = self.step(episodes, np.array([block.plan.feed]), np.array([float(block.plan.dresses)]))
            total += float(outcomes[0, COST])
            strokes.append(float(tallies[0, STROKES]))
            if self.script is None:
                between()
        self.branches.strokes = np.array(strokes)
        if not any(strokes):
            raise JobProgramError(f"{self.programs.name} makes no stroke: a G81 needs motions or dwells before its G80")
        return float(total / len(self.blocks))

    def start_on(self, rngs: Sequence[np.random.Generator], machine: Numbers, forces: Table) -> Episodes:
        """Return new episodes on machines given by number, with factors on the forces in each block.

        Args:
            rngs: generator of each episode.
            machine: number of the machine of each episode in `machines`, shape (N,).
            forces: factors on the forces, shape (N, 1 or blocks).
        """
        episodes = self.start(rngs)
        episodes.machine, episodes.forces = machine, forces
        starts = self.machines.starts[machine]
        episodes.wheels[:, : starts.shape[1]] = starts
        if self.script is None:
            first = np.minimum(np.searchsorted(self.part_of_block, np.arange(self.parts)), forces.shape[1] - 1)
            for i, number in enumerate(machine.tolist()):
                job = self.machines.jobs[number]
                parts = zip(self.conditions(episodes, i), forces[i, first].tolist(), strict=True)
                job = replace(job, parts=tuple(each.forced(factor) for each, factor in parts))
                episodes.programs[i] = ProgramEpisode(self.programs, job, course_of(self.blocks))
        return episodes

    @property
    def writer(self) -> ProgramWriter:
        return JobWriter(self.programs, self.job, self.blocks, self.conditions)

    @property
    def viewer(self) -> Viewer:
        return ProgramViewer(self.programs.name, self.task, self.job, self.blocks, self.parts, self.writer.text)

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        given = with_machines(self, given, rngs)
        super().restart_all(episodes, index, rngs, given)
        for i, each in zip(index, given, strict=True) if self.script is None else ():
            job = self.job if each.plant is None else self.job.on(each.plant.first)
            job = replace(job, parts=self.conditions(episodes, i))
            episodes.programs[i : i + 1] = [ProgramEpisode(self.programs, job, course_of(self.blocks))]

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self.process = self.job.process  # with the exponents of a calibrated job

    def conditions(self, episodes: Episodes, i: int) -> tuple[PartConditions, ...]:
        """Return the conditions of the parts of episode i."""
        stated = self.job.parts[: self.parts]
        return stated or conditions_of(episodes.tape[i], self.part_of_block, self.parts, self._stocks)

    def applied_choice(self, episodes: Episodes, choice: tuple[Table, ...]) -> tuple[Table, ...]:
        # E is rounded as a word of the program; only some blocks take a D
        speeds, executions = choice
        number = self._rows(episodes)
        inches = np.round(speeds / INCH, 4) * INCH
        said = np.where(self._inch[number], inches, np.rint(speeds))
        said = np.where(speeds == self._settings[number, E], speeds, said)
        return said, executions * self._takes_dresses[number]

    def words(self, block: int, speed: float, executions: float) -> Words:
        """Return the words for a choice in a block."""
        return self.blocks[block].words(JobChoice(speed, int(executions)))

    def _rows(self, episodes: Episodes) -> Numbers:
        """Return the numbers of the coming blocks (at the end: of the last blocks), shape (N,)."""
        at = np.minimum(episodes.block, episodes.tape.shape[1] - 1)
        if episodes.tape.shape[1] == len(self.blocks):
            return np.asarray(at)
        return np.asarray(episodes.tape[np.arange(len(at)), at, KIND]).astype(np.int64)

    def own_settings(self, episodes: Episodes) -> Table:
        """Return the settings of the unchanged program, shape (N, fields of `BlockSettings`)."""
        return self._settings[self._rows(episodes)]

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
        active = np.arange(len(episodes.block)) if active is None else active
        speeds, executions = self.applied_choice(episodes, (speeds, executions))
        if settings is None and self.script is not None:
            return super().step(episodes, speeds, executions, active=active)
        check_running(episodes, active, episodes.source[:, BLOCKS])
        chosen = self.own_settings(episodes)
        if settings is not None:
            if self.script is None:
                why = f"J, L and dress settings can be chosen in programs with a script only: {self.why}"
                raise JobProgramError(why)
            chosen[active] = complete_settings(self.script, self.tables, episodes.block[active], settings[active])
        chosen[:, E], chosen[:, D] = speeds, executions
        if self.script is None:
            return self._execute(episodes, chosen, active)
        return super().step(episodes, speeds, executions, settings=chosen, active=active)

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        observations = super().observe(episodes)
        observations[:, self._said] = self._said_of[episodes.block][:, self._said]
        return observations

    def _execute(self, episodes: Episodes, chosen: Table, active: NDArray[np.int64]) -> tuple[Table, Table]:
        """Let the control execute the next block of programs without a script."""
        outcomes, tallies = (np.zeros((len(chosen), len(record._fields))) for record in (Outcome, Tally))
        programs, found = episodes.programs, np.zeros((len(chosen), len(Found._fields)))
        before = episodes.wheels[active, DIAMETER]
        words = {i: self.words(episodes.block[i], chosen[i, E], chosen[i, D]) for i in active.tolist()}
        changes = {i: programs[i].run.mount.changes for i in words}
        for i, run in step_all(programs, words).items():
            machine = programs[i].run
            change = machine.mount.changes - changes[i]
            tally = tally_of(run, self.job, self.blocks[episodes.block[i]].finish)
            tallies[i] = tally._replace(seconds=tally.seconds - change * float(self.shops[0, CHANGE_SECONDS]))
            finished = run.finished
            error = finished["worst_error"][-1] if finished.size else 1000.0 * machine.part.left
            roughness = finished["Ra"][-1] if finished.size else (run.strokes["Ra"][-1] if run.strokes.size else 0.0)
            over = programs[i].block is None
            found[i] = Found(
                good=float(finished["survival"].mean()) if finished.size else 1.0,
                size_error=float(error),
                change=float(change),
                handover=self._handover(programs[i], run) if over else 0.0,
                pick=float(run.increments[run.strokes["groove"] == 0].max(initial=0.0)),
            )
            own = machine.mount.own[0]
            episodes.wheels[i, :OWN_FROM], episodes.wheels[i, OWN_FROM : OWN_FROM + own.size] = machine.wheel, own
            episodes.parts[i] = PartState(Z=machine.part.deepest, S=machine.part.stock - 0.001 * error, Rs=roughness)
        episodes.memory[active, FOUND] = before
        state = EpisodeArrays(*episodes.in_order())
        _, settle = settle_of(self.process, self.gauge)
        settle(self.kinds, self.shops, state, chosen, active, tallies, found, outcomes)
        return outcomes, tallies

    def _handover(self, program: ProgramEpisode, run: BlockRun) -> float:
        number, machine = run.plan.program, program.run
        if machine.wheel is None:
            return 0.0
        own = own_settings(run.plan, None if number is None else machine.dressing.plans[number])
        return price_of_handover(own, Shop(*self.shops[0].tolist()), machine.wheel, machine.part.p)
