"""A user-defined process, hooks and a gauge in one file: grinding and readings follow them.

The head of the machine warms up with the spindle power, grows towards the part and cools down again. Grains pull out in
bursts once the flats have grown enough. Through the shift the wheel dulls faster, and the table lags behind its E and
rests longer. The meter lags.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from grind_env.array_types import Array
from grind_env.control import read
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.past_readings import History
from grind_env.envs.program_writer import Written
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_gauges import GAUGE
from grind_env.envs.tasks import read_task
from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.machine.job import Job
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_loops import loops_of
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.program_run import GrindingRun
from grind_env.process.gauge_readings import Gauge, GaugeReadings
from grind_env.process.process_interface import PROCESS, Drive, Hook, Moment, Nothing, PartHeat, Process, composed
from grind_env.process.stroke_and_dress import dress_wheel, grind_stroke
from grind_env.process.stroke_types import StrokeConstants, StrokeParameters, StrokeResult, WheelState
from tests.machine.harness import DRESS, job, machine_after

WARMS, COOLS, GROWS = 2e-6, 1.0 / 600.0, 2e-4  # K/J, 1/s, mm/K
BURST, PULLED = 0.001, 0.5  # threshold, fraction of the wheel surface; share that pulls out
SLOWER, RESTS, DULLS, LAGS = 0.03, 0.02, 0.5, 200.0  # share, s, 1/h, s


class Warm(NamedTuple):
    """Memory of the process besides the wheel."""

    heat: float = 0.0  #: temperature of the head above the hall, K
    grown: float = 0.0  #: growth of the flats since grains last pulled out, fraction of the wheel surface


class Dulling(NamedTuple):
    """Memory of the hook."""

    blocks: float = 0.0


class Lag(NamedTuple):
    """Memory of the meter."""

    showed: float = 0.0  #: last reading, W
    at: float = 0.0  #: time of the last reading, s


remember, dull, showing = replacer(None, "heat", "grown"), replacer(None, "blocks"), replacer(None, "showed", "at")
pull_out, nearer = replacer(WheelState, "A", "W"), replacer(WheelState, "W")
faster, shown_as = replacer(StrokeParameters, "kA"), replacer(GaugeReadings, "peak_power")


@inlined
def toy_idle(wheel: WheelState, own: Any, p: StrokeParameters, seconds: float, loads: bool) -> tuple[WheelState, Any]:
    """Cool the head down."""
    heat = own.heat * exp(-COOLS * seconds)
    return nearer(wheel, (wheel.W - GROWS * (heat - own.heat),)), remember(own, (heat, own.grown))


@inlined
def toy_stroke(
    wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
) -> tuple[WheelState, Any, StrokeResult]:
    """Grind a stroke of the package, with bursts and a head that warms up."""
    after, stroke = grind_stroke(wheel, S, Rs, Z, b, k)
    grown = own.grown + max(after.A - wheel.A, 0.0)
    bursts = grown > BURST
    heat = own.heat * exp(-COOLS * seconds) + WARMS * stroke.power * seconds
    A = after.A - PULLED * grown if bursts else after.A
    after = pull_out(after, (A, after.W - GROWS * (heat - own.heat)))
    return after, remember(own, (heat, 0.0 if bursts else grown)), stroke


@inlined
def toy_dress(
    wheel: WheelState, own: Any, passes: float, lead: float, depth: float, p: StrokeParameters
) -> tuple[WheelState, Any, float]:
    """Dress as the package does; the grains are fresh afterwards."""
    wheel, removed = dress_wheel(wheel, passes, lead, depth, p)
    return wheel, remember(own, (own.heat, 0.0)), removed


@inlined
def worn_table(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Reach less of a high E, and rest longer towards the end of the table."""
    share = drive.share * (1.0 - SLOWER * moment.E / 30_000.0)
    return wheel, own, p, Drive(share=share, dwell=drive.dwell + RESTS * moment.place / 100.0)


@inlined
def dulling(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Dull the wheel faster through the shift and from block to block."""
    factor = 1.0 + DULLS * moment.seconds / 3600.0 + 0.01 * own.blocks
    return wheel, dull(own, (own.blocks + 1.0,)), faster(p, (p.kA * factor,)), drive


@inlined
def lagging(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    """Read as the package does, but with a lagging peak without noise."""
    kept = exp((own.at - seconds) / LAGS)
    peak = truth.peak_power + kept * (own.showed - truth.peak_power)
    shown, own = GAUGE.read(truth, own, seconds, noise)
    return shown_as(shown, (peak,)), showing(own, (peak, seconds))


BARE = Process(Warm, StrokeConstants, PROCESS.constants, toy_stroke, toy_dress, toy_idle)
TOY = composed(BARE, Hook(worn_table), Hook(dulling, Dulling))
METER = Gauge(lagging, Lag)
FIELDS = (*Warm._fields, *Dulling._fields)


PLUNGES = """G71 G94 G90 G19
G00 Y20.
G00 X-30. Z-2.5
G01 Y0 F500.
G82 X230. I-30. Y-.06 J-.012 L2 F100. E18000. P9100 D2
G80
G00 Y20.
M00
G00 X-30. Z-2.5
G01 Y0 F500.
G82.1 X230. I-30. Y-.09 J-.01 Q-.004 L1 F100. E24000. P9100 D1
G80
G00 Y20.
M30
"""
INFEED = """M01
G00 X-30.
G01 Y-.05 F500.
G81.1 X230. I-30. E9000. P9100
G01 Y-.08 F.8
G04 X2.5
G80
G00 Y20.
M00
"""
MIXED = PLUNGES.replace("G80\nG00 Y20.\nM00\n", f"G80\n{INFEED}")
GROOVE = "G71 G94 G90 G18\nG00 X1. Z0\nG77 X-1. Z-50. I.7 K40. D0 F6.\nM00\n"
WIDE = PLUNGES.replace("Z-2.5", "Z0.").replace("Y-.06 ", "Y-.06 Z15. K6. R6. ").replace("Q-.004", "Q-.004 Z11.3 K9.2")
ALIKE, NEAR = 0.0, 1e-12
#: program text, width of the part, mm, and relative tolerance of its replay
PROGRAMS: dict[str, tuple[str, float, float]] = {
    "a script of plunges": (PLUNGES, 20.0, ALIKE),
    "a script with an infeed beside the table": (MIXED, 20.0, NEAR),
    "a script in zones": (WIDE.replace("G82", "G83").replace("F100.", "F1500."), 40.0, NEAR),
    "a program that the control executes": (GROOVE + MIXED, 20.0, NEAR),
}


def toy_job(**part: float) -> Job:
    """Return the job of the programs on the toy process."""
    return replace(job(stock=0.1, **part), process=TOY)


def ground(written: Written, *, whole: bool = True) -> GrindingRun:
    """Return the machine after a program; the control passes cycles whole or stroke by stroke."""
    programs, shop = read(written.program), written.job
    control = replace(shop.control, operator_dress_at=written.requests, whole_cycles=whole)
    return machine_after(programs, shop, control)


class Played(NamedTuple):
    """Episode after some blocks."""

    wheel: Array  #: the wheel and the memory besides it
    memory: History
    written: Written
    outcomes: Outcome  #: fields of shape (blocks,), also in `tallies`
    tallies: Tally


def play(simulation: Simulation, choices: Sequence[tuple[float, float]], seed: int = 3) -> Played:
    """Play an episode with these E (mm/min) and D beside another episode."""
    episodes = simulation.start([np.random.default_rng(seed), np.random.default_rng(seed + 1)])
    blocks, outcomes, tallies = [], [], []
    for E, D in choices:
        blocks.append(simulation.writer.block(episodes, 0, E, D))
        outcome, tally = simulation.step(episodes, np.array([E, 7000.0]), np.array([D, 1.0]))
        outcomes.append(outcome[0])
        tallies.append(tally[0])
    memory, written = History(*episodes.memory[0].tolist()), simulation.writer.written(episodes, 0, blocks)
    return Played(episodes.wheels[0], memory, written, Outcome(*np.array(outcomes).T), Tally(*np.array(tallies).T))


def assert_ground_alike(played: Played, run: GrindingRun, within: float) -> None:
    """Assert that episode and machine end with equal wheel and memory."""
    assert run.wheel is not None
    found = played.wheel[: OWN_FROM + len(FIELDS)]
    np.testing.assert_allclose(found, [*run.wheel, *run.mount.own[0]], rtol=within, atol=0.01 * within)


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize(("text", "width", "within"), PROGRAMS.values(), ids=list(PROGRAMS))
def test_the_interpreter_grinds_a_program_as_its_replay(text: str, width: float, within: float, whole: bool) -> None:
    simulation = JobSimulation(read(text + DRESS), toy_job(width=width), 0.0, gauge=METER)
    assert (simulation.script is None) == ("G77" in text)
    choices = [(18_000.0, 2.0), *([(9000.0, 0.0)] if "G81" in text else []), (24_000.0, 1.0)]
    played = play(simulation, choices)
    run = ground(played.written, whole=whole)
    assert_ground_alike(played, run, within)
    strokes = run.record().strokes
    assert len(strokes) == played.tallies.strokes.sum()
    reached = {(1.0 - SLOWER * E / 30_000.0) * E for E, _ in choices}
    assert {*strokes["E"][strokes["groove"] == 0].tolist()} == reached
    assert run.mount.own[0, FIELDS.index("blocks")] == len(choices)


TASKS = ("power_limited", "reciprocation", "wide_plates")


def simulation_of(name: str, process: Process = TOY, gauge: Gauge = METER) -> BlockSimulation:
    task = read_task(name)
    return BlockSimulation(task, process=process, gauge=gauge)


CHOICES = [(9000.0, 0.0), (21_000.0, 2.0), (14_000.0, 0.0), (6000.0, 1.0), (12_000.0, 0.0)]  #: E and D of some parts


@pytest.mark.parametrize("name", TASKS)
def test_the_interpreter_grinds_the_program_of_an_episode_as_the_environment(name: str) -> None:
    played = play(simulation_of(name), CHOICES)
    run = ground(played.written)
    assert_ground_alike(played, run, NEAR)
    assert len(run.record().strokes) == played.tallies.strokes.sum()
    assert run.record().seconds == pytest.approx(played.outcomes.seconds.sum(), rel=1e-9)


@pytest.mark.nightly
@pytest.mark.bits
def test_lanes_of_the_toy_process_do_not_affect_each_other() -> None:
    simulation, n = simulation_of("power_limited"), 19
    episodes = simulation.start([np.random.default_rng(seed) for seed in range(n)])
    each = [episodes.pick([i]) for i in range(n)]
    E, D = np.linspace(5000.0, 25_000.0, n), np.arange(n) % 3.0
    _, tallies = simulation.step(episodes, E, D)
    for i, alone in enumerate(each):
        _, tally = simulation.step(alone, E[i : i + 1], D[i : i + 1])
        assert tally.tobytes() == tallies[i].tobytes()
        assert alone.wheels.tobytes() == episodes.wheels[i].tobytes()
        assert alone.parts.tobytes() == episodes.parts[i].tobytes()


PLUNGE = """G00 Y20.
G00 X-30. Z-2.5
G01 Y0 F500.
G82 X230. I-30. Y-.08 J-.01 L2 F100. E6000. P9100 D0
G80
G00 Y20.
"""
SIX_PARTS = "G71 G94 G90 G19\n" + "M00\n".join([PLUNGE] * 6) + "M30\n"


def test_each_effect_of_the_toy_process_shows_in_the_run() -> None:
    def machine(process: Process) -> GrindingRun:
        return ground(Written(SIX_PARTS + DRESS, replace(job(stock=0.08), process=process)))

    plain, bare, cold, duller, slower = (
        machine(process)
        for process in (
            PROCESS,
            BARE,
            PROCESS._replace(grown=None),
            composed(PROCESS, Hook(dulling, Dulling)),
            composed(PROCESS, Hook(worn_table)),
        )
    )
    sizes = {name: run.record().parts["size_error"] for name, run in (("bare", bare), ("plain", plain), ("cold", cold))}
    assert bare.wheel.A < plain.wheel.A - 0.5 * PULLED * BURST  # grains have pulled out
    assert bare.mount.own[0, Warm._fields.index("heat")] > 0.0
    assert (sizes["bare"] < sizes["cold"]).all()  # the head has grown towards the part
    assert (sizes["plain"] < sizes["cold"]).all()  # and the part towards the head
    assert duller.wheel.A > plain.wheel.A
    assert (slower.record().parts["seconds"] > plain.record().parts["seconds"]).all()


def test_time_alone_cools_the_head() -> None:
    def heat(load: float) -> float:
        shop = replace(toy_job(), times=replace(toy_job().times, load=load))
        return float(ground(Written(PLUNGES + DRESS, shop)).mount.own[0, 0])

    assert 0.0 < heat(3600.0) < heat(20.0)


def test_a_lagging_meter_delays_readings_but_does_not_change_grinding() -> None:
    choices = [(8000.0, 0.0), (24_000.0, 0.0), (24_000.0, 0.0)]
    shown, true = [], []
    for blocks in range(1, 4):
        lags, exact = (play(simulation_of("power_limited", TOY, gauge), choices[:blocks]) for gauge in (METER, GAUGE))
        assert lags.outcomes.cost.tolist() == exact.outcomes.cost.tolist()
        assert lags.memory._replace(peak_power=0.0) == exact.memory._replace(peak_power=0.0)
        shown.append(lags.memory.peak_power)
        true.append(lags.tallies.peak_load[-1])
    assert 0.0 < shown[0] < shown[1] < shown[2]
    assert shown[0] < true[0] and shown[1] < true[1]
    assert lags.wheel[-2:].tolist() == [shown[2], pytest.approx(lags.memory.clock)]


def room_of(process: Process) -> int:
    """Return how many numbers a lane has for the wheel and the memory besides it."""
    return int(simulation_of("power_limited", process, GAUGE).empty_episodes(1).wheels.shape[1])


def test_the_standard_process_remembers_part_heat_only_and_loops_are_cached() -> None:
    assert composed(PROCESS) is PROCESS and PROCESS.own() == PartHeat(0.0, 0.0, 0.0, 0.0)
    assert room_of(PROCESS) == OWN_FROM + 4
    assert composed(PROCESS, Hook(worn_table)).own() == PROCESS.own()  # a hook that remembers nothing adds no room
    assert composed(PROCESS, Hook(dulling, Dulling)).own._fields == (*PartHeat._fields, "blocks")
    course = CYCLE_KERNELS["G82"]
    assert loops_of(course) is loops_of(course, PROCESS) and loops_of(course, TOY) is loops_of(course, TOY)
    assert loops_of(course) is not loops_of(course, TOY)


@inlined
def forgetful_stroke(
    wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
) -> tuple[WheelState, Any, StrokeResult]:
    """Grind a stroke of the package on a part that stays cold."""
    after, stroke = grind_stroke(wheel, S, Rs, Z, b, k)
    return after, own, stroke


def test_a_process_without_memory_needs_no_room_and_grinds_a_cold_part() -> None:
    forgetful = Process(Nothing, StrokeConstants, PROCESS.constants, forgetful_stroke, PROCESS.dress)
    assert room_of(forgetful) == OWN_FROM
    choices = [(9000.0, 0.0), (12_000.0, 1.0)]
    found, cold = (
        play(simulation_of("power_limited", process, GAUGE), choices)
        for process in (forgetful, PROCESS._replace(grown=None))
    )
    np.testing.assert_allclose(found.wheel, cold.wheel[:OWN_FROM], rtol=NEAR)
    np.testing.assert_allclose(found.outcomes, cold.outcomes, rtol=NEAR)


def test_two_hooks_with_an_equal_field_name_are_rejected() -> None:
    with pytest.raises(ValueError, match=r"names of their own, but here they are .*'blocks', 'blocks'"):
        composed(TOY, Hook(dulling, Dulling))
