"""Trials of a program with other words: cost and used shares of the limits, always on the same lots."""

import copy
import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import partial
from time import monotonic
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.control import Programs, execute
from grind_env.control.control_settings import BLOCK_BUDGET
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation, ranges_of
from grind_env.envs.job.program_outline import BlockOutline, JobProgramError
from grind_env.envs.job.repeated_program import Batch, batch_of
from grind_env.errors import GrindError
from grind_env.machine.job import Job, JobError
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.script.block_settings import DRESS_SECONDS, D, E, Ranges, own_settings
from grind_env.machine.script.repeated_script import SAMPLE_RUNS, is_straight, repeated, with_job
from grind_env.machine.script.script import Script, script_of
from grind_env.machine.script.script_tables import BlockRow
from grind_env.policies.score_statistics import Interval, resampled_means
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.search_options import CONFIDENCE

#: function called between two blocks of a program that the control executes; an error from it ends the run
Between: TypeAlias = Callable[[], object]

Lots: TypeAlias = NDArray[np.int64]  #: indices of lots
Ground: TypeAlias = tuple[Array, Array, Array]  #: result of `Trials._ground`: shares, sums and peaks


class LotUse(IntEnum):
    """Purpose of lots; each purpose has lots of its own."""

    BASE = 0
    SEARCH = 1
    COMPARISON = 2
    JUDGEMENT = 3
    SWEEP = 4


#: number of cores that replay candidates side by side; with more cores the lock of the interpreter is the limit
CORES = min(os.cpu_count() or 1, 8)
ROWS_AT_ONCE = 150_000  #: greatest number of episodes times blocks that a core replays together; bounds the memory
DRIFT = 1  #: number appended to the seed of a lot to give the seed of its drift
#: greatest permitted `risk` with and without a calibration: the cost of a part over its old cost, on a bad machine.
#: Machines without a calibration may differ so much that hardly any words are without risk on one machine in twenty
CALIBRATED, UNCALIBRATED = 1.05, 1.2
SAME = 1e-6  #: relative difference up to which settings count as equal, because of rounding

_COST, _GOOD, _SECONDS, _POWER, _LOAD, _RA, _ERROR, _HANDOVER = (
    Outcome._fields.index(name)
    for name in ("cost", "good", "seconds", "peak_power", "power_ratio", "roughness", "size_error", "handover_cost")
)
_PLUNGE_RISE, _FINISH_RISE = Tally._fields.index("plunge_rise"), Tally._fields.index("finish_rise")


class Measures(NamedTuple):
    """Results of C candidates on N lots: means of a part, shape (C, N), and limits."""

    cost: Array  #: $, including scrap and the dull wheel at the end
    seconds: Array
    Ra: Array  #: um
    power: Array  #: highest spindle power above idle, kW; at most the limit of the spindle
    rise: Array  #: highest temperature rise that counts in the last stage, K
    highest_rise: Array  #: highest temperature rise that counts in any stage, K
    size_error: Array  #: absolute size error, um
    scrap: Array  #: share of scrapped parts
    # share of each of `LIMITS` that parts stay below with the confidence; 0 without a limit; shape (C, 4)
    ratios: Array

    def violation(self, margins: Array) -> Array:
        """Return the excess over shares of the limits, shape (C, 4); 0 for none."""
        return np.asarray(np.maximum(self.ratios / margins - 1.0, 0.0))


@dataclass(frozen=True, slots=True)
class Trials:
    """Trials of a program for a batch of parts, on lots that are the same for all candidates."""

    simulation: JobSimulation  #: simulation of the batch
    runs: int  #: runs of the program in the batch
    seeds: tuple[tuple[int, ...], ...]  #: seeds of the lots
    all_blocks: tuple[BlockOutline, ...]  #: the cycle blocks of all runs as they stand in the program
    # whether all runs have the same blocks with the same settings, unlike a program that counts its parts
    alike: bool
    execution: float  #: time that the control needs to execute one run of the program, s
    drift: float = 0.0  #: logarithmic standard deviation of a step of the forces from part to part
    confidence: float = CONFIDENCE  #: probability that parts of any lot on any machine keep the limits

    @property
    def lots(self) -> int:
        """Return the number of lots; 1 if the job states how each part differs."""
        return 1 if self.simulation.job.parts else len(self.seeds)

    @property
    def machine(self) -> NDArray[np.int64]:
        """Return the machine number of each lot; lots are spread evenly over the machines."""
        return np.arange(len(self.seeds)) % len(self.simulation.machines.jobs)

    def of_one(self, values: Array) -> Interval:
        """Return mean and interval for one machine from a value for each lot, shape (lots,); see `each_of_one`."""
        return self.each_of_one(values[None])[0]

    def each_of_one(self, values: Array) -> list[Interval]:
        """Return means and intervals for one machine from k quantities of each lot, shape (k, lots).

        Each end is exceeded with probability one minus the confidence. On a known machine only the lots vary. A
        calibrated model has further errors: the interval is widened by its held-out error.
        """
        tail, draws, means = 100.0 * (1.0 - self.confidence), self.by_machine(values), values.mean(axis=1)
        if draws.shape[1] == 1:
            draws = resampled_means(values).T
        lows, highs = np.percentile(draws, [tail, 100.0 - tail], axis=1)
        known = self.simulation.job.uncertainty
        missed = 0.0 if known is None else known.residual
        lows, highs = lows - missed * np.abs(lows), highs + missed * np.abs(highs)
        # a few bad machines may put the mean beyond the percentiles
        ends = (means, np.minimum(lows, means), np.maximum(highs, means))
        return [Interval(*each) for each in np.array(ends).T.tolist()]

    def by_machine(self, values: Array) -> Array:
        """Return the mean of each machine, shape (C, machines), of the values of each lot, shape (C, lots)."""
        count = min(len(self.simulation.machines.jobs), values.shape[1])
        return np.array([values[:, k::count].mean(axis=1) for k in range(count)]).T

    @property
    def blocks(self) -> tuple[BlockOutline, ...]:
        """Return the blocks of one run, or of all runs if these differ."""
        return self.all_blocks[: len(self.all_blocks) // self.runs] if self.alike else self.all_blocks

    @property
    def own(self) -> Array:
        """Return the settings of the unchanged program in all runs, shape (blocks, fields of `BlockSettings`)."""
        return _settings_of(self.all_blocks)

    @property
    def run_of_block(self) -> NDArray[np.int64]:
        """Number of the run of each block of all runs, from 0."""
        return np.asarray(self.simulation.part_of_block // (self.simulation.parts // self.runs))

    def as_written(self, programs: Programs) -> JobSimulation:
        """Return the simulation with its blocks as they stand in the program."""
        simulation = copy.copy(self.simulation)
        simulation.programs, simulation.blocks = programs, self.blocks
        return simulation

    @property
    def at_once(self) -> int:
        """Return how many candidates run together: one for a program that is executed step by step."""
        rows = len(self.seeds) * len(self.simulation.blocks)
        return CORES * max(ROWS_AT_ONCE // rows, 1) if self.simulation.compiled else 1

    def spread_by(self, factor: float) -> "Trials":
        """Return a copy with `factor` times the variation of lots and parts."""
        return replace(self, simulation=self.simulation.with_spread(factor * self.simulation.spread))

    def with_job(self, job: Job) -> "Trials":
        """Return a copy for a job with other requirements on its parts, or with a stronger spindle."""
        simulation, script = self.simulation, self.simulation.script
        assert script is not None  # only compiled programs come here, and they have a script
        _, picks, spark_outs = script.ranges
        asked = JobSimulation(
            simulation.programs,
            job,
            simulation.spread,
            picks=picks,
            spark_outs=spark_outs,
            script=with_job(script, job),
        )
        return replace(self, simulation=asked)

    def with_lots(self, seeds: Sequence[tuple[int, ...]], machines: Sequence[Job] = (), drift: float = 0.0) -> "Trials":
        """Return a copy on other lots, spread over machines in turn; on the job's machine if none are given."""
        simulation = self.simulation.on_machines(machines or [self.simulation.job])
        most = len(machines) or 1
        seeds = tuple(seeds[:most] if simulation.job.parts else seeds)
        return replace(self, simulation=simulation, seeds=seeds, drift=drift)

    def _forces(self, seeds: Sequence[tuple[int, ...]]) -> Array:
        """Return the factors on the forces in each block of some lots, shape (lots, 1 or blocks)."""
        if self.drift == 0.0:
            return np.ones((len(seeds), 1))
        parts = self.simulation.parts
        steps = np.array([np.random.default_rng((*seed, DRIFT)).standard_normal(parts) for seed in seeds])
        walks = np.exp(self.drift * (np.cumsum(steps, axis=1) - steps[:, :1]))
        return np.asarray(walks[:, self.simulation.part_of_block])

    def measure(
        self, settings: Array, *, other_settings: bool = False, handover: bool = True, between: Between = lambda: None
    ) -> Measures:
        """Return the results of candidates; settings are of all runs, shape (C, blocks, fields of `BlockSettings`).

        `other_settings`: whether J, L and dress settings differ from the program's; `handover`: whether the dull
        wheel at the end is charged for; `between` as in `trials_of`.
        """
        every = range(0, len(settings), self.at_once)
        ground = partial(self._ground, other_settings=other_settings, handover=handover, between=between)
        parts = [self._measure(settings[begin : begin + self.at_once], ground) for begin in every]
        return Measures(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _measure(self, settings: Array, ground: Callable[[Array, Lots], Ground]) -> Measures:
        lots, count = len(self.seeds), len(settings)
        pieces = self._in_pieces(settings, ground)
        worst, sums, peaks = (np.concatenate(each, axis=1) for each in zip(*pieces, strict=True))
        parts = worst.shape[2]
        cost, seconds, good = sums.reshape(3, count, lots) / parts
        power, *means = peaks.mean(axis=2).reshape(5, count, lots)
        shares = np.quantile(worst.reshape(4, count, lots * parts), self.confidence, axis=2).T
        rise, highest_rise, roughness, error = means
        return Measures(cost, seconds, roughness, power / 1000.0, rise, highest_rise, error, 1.0 - good, shares)

    def _in_pieces(self, settings: Array, ground: Callable[[Array, Lots], Ground]) -> list[Ground]:
        """Grind candidates, or the lots of one candidate, in a piece on each core; the control grinds lot by lot."""
        every = np.arange(len(self.seeds))
        if not self.simulation.compiled:
            return [ground(settings, every[k : k + 1]) for k in range(len(every))]
        if len(settings) > 1:
            pieces = [(each, every) for each in np.array_split(settings, CORES) if len(each)]
        else:
            pieces = [(settings, each) for each in np.array_split(every, CORES) if len(each)]
        with ThreadPoolExecutor(CORES) as pool:  # compiled code releases the lock of the interpreter
            return list(pool.map(ground, *zip(*pieces, strict=True)))

    def _ground(self, settings: Array, every: Lots, other_settings: bool, handover: bool, between: Between) -> Ground:
        """Return shares, sums, shape (3, n), and peaks of candidates on some lots, n in total, as in `_ScriptParts`."""
        simulation, lots, count = self.simulation, len(every), len(settings)
        seeds, machine = [self.seeds[k] for k in every.tolist()], self.machine[every]
        start = simulation.start_on([np.random.default_rng(seed) for seed in seeds], machine, self._forces(seeds))
        episodes = start if count == 1 else start.pick(np.tile(np.arange(lots), count))
        n = count * lots
        sums = np.zeros((3, n))
        parts = _ScriptParts(simulation, n, np.tile(simulation.machines.cooler[machine], (count, 1)))
        for k in range(len(simulation.blocks)):
            if not simulation.compiled:
                between()
            chosen = np.repeat(settings[:, k], lots, axis=0)
            outcomes, tallies = simulation.step(
                episodes, chosen[:, E].copy(), chosen[:, D].copy(), settings=chosen if other_settings else None
            )
            sums += outcomes[:, [_COST, _SECONDS, _GOOD]].T
            sums[0] -= 0.0 if handover else outcomes[:, _HANDOVER]
            if simulation.compiled:
                parts.add(k, outcomes, tallies)
        if simulation.compiled:
            return parts.shares, sums, parts.peaks
        shares, peaks = zip(*(_parts_of_run(program.run) for program in episodes.programs), strict=True)
        return np.stack(shares, axis=1), sums, np.stack(peaks, axis=1)


class _ScriptParts:
    """Results of the parts of n episodes of a script, block by block; `cooler` is from `Machines`."""

    def __init__(self, simulation: JobSimulation, n: int, cooler: Array) -> None:
        self.simulation, self.cooler = simulation, cooler
        self.shares = np.zeros((4, n, simulation.parts))  # used share of each of `LIMITS`
        self.peaks = np.zeros((5, n, simulation.parts))  # power, rise of the last stage, highest rise, Ra, size error
        self._rise = np.zeros(n)  # highest rise in the stage so far, K

    def add(self, k: int, outcomes: Array, tallies: Array) -> None:
        """Add block k, with the limits of its stage."""
        row, part = BlockRow(*self.simulation.tables.blocks[k].tolist()), self.simulation.part_of_block[k]
        shares, peaks = self.shares[:, :, part], self.peaks[:, :, part]
        rise = tallies[:, _PLUNGE_RISE if row.counts_all > 0.0 else _FINISH_RISE]
        self._rise = np.maximum(self._rise, rise)
        peaks[0] = np.maximum(peaks[0], outcomes[:, _POWER])
        peaks[2] = np.maximum(peaks[2], rise)
        most_rise = row.rise + self.cooler[:, min(k, self.cooler.shape[1] - 1)]
        ratios = [outcomes[:, _LOAD], rise / most_rise]
        if row.judged > 0.0:
            error = np.abs(outcomes[:, _ERROR])
            peaks[1], peaks[3], peaks[4] = self._rise, outcomes[:, _RA], error
            self._rise = np.zeros_like(rise)
            ratios += [_share(outcomes[:, _RA], row.roughness), _share(error, row.size)]
        for share, ratio in zip(shares, ratios, strict=False):
            np.maximum(share, ratio, out=share)


def _parts_of_run(run: GrindingRun) -> tuple[Array, Array]:
    """Return shares and peaks, as in `_ScriptParts`, of the parts of one run that the control has executed."""
    parts, strokes = run.parts.table(), run.strokes.table()
    shares = np.zeros((4, len(parts)))
    np.maximum.at(shares[0], strokes["part"] - 1, strokes["load"] / run.job.limits.power)
    for stages, share in zip(run.stages, shares.T, strict=True):
        for stage in stages:
            limits, error = stage.limits, abs(stage.worst_error)
            ratios = stage.rise / limits.rise, _share(stage.Ra, limits.roughness), _share(error, limits.size)
            share[1:] = np.maximum(share[1:], ratios)
    names = "peak_power", "rise", "highest_rise", "Ra", "worst_error"
    return shares, np.abs([parts[name] for name in names])


def _share(value: Any, limit: float) -> Any:
    """Return the used share of a limit, which may be absent."""
    return value / limit if limit > NO_LIMIT else 0.0 * value


def trials_of(
    programs: Programs,
    job: Job,
    runs: int,
    seeds: Sequence[tuple[int, ...]],
    *,
    picks: Sequence[float] = (),
    spark_outs: Sequence[int] = (),
    spread: float = 1.0,
    between: Between = lambda: None,
) -> Trials:
    """Return trials of a program that is run several times with one wheel.

    Picks (mm) and spark-outs are the lowest and highest permitted J and L; `spread` is a factor on all random
    deviations; `between` is called between two blocks of the first executions, and an error from it ends them.
    """
    if runs < 1:
        raise GrindError(f"{programs.name} cannot be run for {runs} parts; choose --parts 1 or more")
    if job.parts and runs > len(job.parts):
        raise JobError(
            f"{programs.name}, run {runs} times, grinds more parts than the {len(job.parts)} that have conditions; "
            f"choose --parts {len(job.parts)} or fewer, or give [[parts]] for every part or for none",
            "parts",
        )
    began = monotonic()
    batch, script = _batch_of_few(programs, job, runs, ranges_of(job, picks, spark_outs))
    execution = (monotonic() - began) / SAMPLE_RUNS
    try:
        simulation = JobSimulation(
            batch.programs, job, spread, picks=picks, spark_outs=spark_outs, between=between, script=script
        )
    except GrindError:
        if runs > 1:
            JobSimulation(programs, job, spread, picks=picks, spark_outs=spark_outs)  # this error names the line
        raise
    if simulation.parts % runs:
        raise JobProgramError(f"{programs.name} does not grind as many parts in every run; choose --parts 1 for it")
    blocks = tuple(replace(each, block=batch.origin(each.block)) for each in simulation.blocks)
    if script is None:
        execution = (monotonic() - began) / runs
    return Trials(simulation, runs, (), blocks, _alike(blocks, runs), execution).with_lots(seeds)


def _batch_of_few(programs: Programs, job: Job, runs: int, ranges: Ranges) -> tuple[Batch, Script | None]:
    """Return a batch of all runs; if all runs are alike, a batch of a few runs and the script of all runs."""
    if runs > SAMPLE_RUNS and is_straight(programs) and not (job.parts or job.stations):
        few = batch_of(programs, SAMPLE_RUNS, job.variables)
        with suppress(GrindError):  # the batch of all runs reports the error
            # up to half the block budget: a longer program is executed in full, which shows where it exceeds the budget
            _require_budget(few.programs, job, SAMPLE_RUNS * BLOCK_BUDGET // (2 * runs))
            script = repeated(script_of(few.programs, job, ranges), runs)
            if script is not None:
                return few, script
    return batch_of(programs, runs, job.variables), None


def _require_budget(programs: Programs, job: Job, blocks: int) -> None:
    """Execute a program of at most `blocks` blocks and strokes; errors as in `execute`."""
    events = execute(programs, replace(job.control, whole_cycles=True, block_budget=blocks))
    events.set_wheel_radius(0.5 * job.setup.wheel.diameter)
    deque(events, maxlen=0)


def _alike(blocks: Sequence[BlockOutline], runs: int) -> bool:
    count, left = divmod(len(blocks), runs)
    if left or any(blocks[k].block.source != blocks[k % count].block.source for k in range(len(blocks))):
        return False
    settings = np.delete(_settings_of(blocks), DRESS_SECONDS, axis=1)  # the way to the diamond may differ
    return np.allclose(settings, np.tile(settings[:count], (runs, 1)), rtol=SAME, atol=0.0)


def _settings_of(blocks: Sequence[BlockOutline]) -> Array:
    return np.array([own_settings(block.plan, block.dress) for block in blocks])


def most_risk(job: Job) -> float:
    """Return the permitted risk on the machines of a job."""
    return UNCALIBRATED if job.uncertainty is None else CALIBRATED


def risk(trials: Trials, found: Measures, old: Measures, quantity: str = "cost") -> Array:
    """Return the cost of C candidates relative to the cost `old` of the unchanged program, shape (C,).

    The value is for a machine as bad as the confidence allows.
    """
    less, before = (trials.by_machine(getattr(each, quantity)) for each in (found, old))
    return np.asarray(np.quantile(less / before[0], trials.confidence, axis=1))


def lots_of(seed: int, use: LotUse, count: int) -> tuple[tuple[int, ...], ...]:
    """Return the seeds of some lots for a use."""
    if seed < 0:
        raise GrindError(f"the seed is {seed}; choose --seed 0 or more")
    return tuple((seed, int(use), k) for k in range(count))


def lots_text(count: int, what: str = "lots") -> str:
    """Return a text for the lots of a program, or for the parts stated by a job."""
    return f"{count} {what}" if count > 1 else "the parts that the job states"
