"""Speed of the compiled loops, measured in alternation with the C reference: part of `make speed`."""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import llvmlite.binding
import numpy as np

from grind_env.array_types import Array
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE, motion_time
from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.envs.block_kind_rows import kind_row
from grind_env.envs.episode_generator import EpisodeGenerator
from grind_env.envs.programmed_infeed import infeed_of, write_motions
from grind_env.envs.tasks import Task, load_task, read_task
from grind_env.kernel import compile_at_once
from grind_env.machine.loops.concurrent_strokes import FeedMotion
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.machine_lanes import NO_MOTIONS, longest_first_of
from grind_env.machine.loops.row_io import RULES_FROM
from grind_env.machine.loops.table_speed import Pace, pace_of
from grind_env.machine.loops.zone_layout import strip_centres, strip_zones
from tests.batches import CYCLE, FEEDS, PARAMETERS, PART, PLUNGES, TALLY, TRAVERSES, WHEEL, as_table, cold, feeding_row
from tests.speed.c_reference import LANES, Loop, compiled, compiler
from tests.speed.turns import Ratios, in_turns, over
from tests.speed_envs import seconds

TURN = 2048  #: number of machines in one measurement, about
SECONDS = 8.0  #: duration of all measurements of the loops together, about, s

FEW_ZONES, MANY_ZONES, CROSSOVER = 8, 64, 20.0  #: numbers of zones of a part, and length of the crossover, mm


def machines_of(task: Task, machines: int) -> tuple[np.ndarray, ...]:
    """Return parameters, wheels and parts of machines at the start of episodes of a task."""
    parameters = np.full(machines, np.array(tuple(task.parameters(task.kinds[0])), PARAMETERS))
    wheels = np.full(machines, np.array(cold(EpisodeGenerator(task).wheel(0.0)), WHEEL))
    return parameters, wheels, np.full(machines, np.array(tuple(PartState(0.0, 0.0, 1.6)), PART))


def cycles(machines: int, seed: int = 0) -> tuple[np.ndarray, ...]:
    """Return random G82 cycles of about 55 strokes, with their machines: arguments of a `Loop`, without tallies."""
    rng = np.random.default_rng(seed)
    task = load_task("power_limited")
    kind = task.kinds[0]
    table = np.zeros(machines, CYCLE)
    speeds = rng.uniform(100.0, 400.0, machines)
    table["stroke_seconds"] = [motion_time(360.0, speed, 1000.0) + 0.15 for speed in speeds]
    paces = np.array([pace_of(speed, 360.0, kind.length, 0.0, 1000.0) for speed in speeds])
    for name, numbers in zip(Pace._fields, paces.T, strict=True):
        table[name] = numbers
    table["first_seconds"] = table["stroke_seconds"]
    table["depth"] = table["bottom"] = table["finish"] = rng.uniform(0.1, 1.0, machines)
    table["primary_pick"] = table["secondary_pick"] = 0.01
    table["full_plunge"] = 0.01 - DEPTH_TOLERANCE
    table["at_depth"] = 1.0 + rng.integers(0, 4, machines)
    table["executions"] = rng.integers(0, 4, machines)
    table["width"], table["length"] = kind.width, kind.length
    table["dress_passes"], table["dress_depth"] = task.dress.passes, task.dress.depth
    table["dress_feed"], table["dress_seconds"] = task.dress_feed, task.dress_seconds
    return table, *machines_of(task, machines)


def plunges(*tables: np.ndarray) -> None:
    """Grind G82 cycles in lanes, including the sorting."""
    order = np.empty(len(tables[0]), np.int64)
    longest_first_of(PlungeCycle)(tables[0], np.arange(len(tables[0])), order)
    PLUNGES.lanes(*tables, NO_MOTIONS, order, 0, 1)


def feedings(machines: int, seed: int = 0) -> tuple[tuple[np.ndarray, ...], Loop]:
    """Return tables of random G81 blocks, and a loop that grinds them with their table of feed motions."""
    rng = np.random.default_rng(seed)
    task = read_task("reciprocation")
    kind, rate, stroke = kind_row(task, task.kinds[0]), task.infeed / 60.0, task.stroke_length(task.kinds[0])
    dress = {"dress_passes": float(task.dress.passes), "dress_feed": task.dress_feed}
    dress |= {"dress_depth": task.dress.depth, "dress_seconds": task.dress_seconds}
    most, rows = 3, []
    motions = np.zeros((2 * (most + 1) * machines, len(FeedMotion._fields)))
    for first in range(0, len(motions), 2 * (most + 1)):
        speed, executions = rng.uniform(3000.0, 30_000.0), float(rng.integers(0, most + 1))
        table = task.machine.reversal_dwell, executions, task.machine.acceleration, rate
        infeed = infeed_of(stroke, kind.sparkout, kind.stock, speed, *table)
        write_motions(motions, first, infeed)
        rows.append(feeding_row(infeed, speed, first, 0.0, kind._asdict() | dress))

    def feeds(*tables: np.ndarray) -> None:
        FEEDS.lanes(*tables, motions, np.arange(machines), 0, 1)

    return (np.array(rows), *machines_of(task, machines)), feeds


def crossings(strips: int, machines: int = 256) -> tuple[tuple[np.ndarray, ...], Loop]:
    """Return tables of G83 cycles over parts with `strips` zones of 1 mm, and a loop that grinds them on new parts."""
    cycle = TraverseCycle(
        depth=0.1,
        primary_pick=0.02,
        secondary_pick=0.02,
        width=CROSSOVER,
        primary_cross_pick=5.0,
        secondary_cross_pick=5.0,
        at_depth=2.0,
        executions=0.0,
        pre_dress=0.0,
    )
    table, *others = cycles(machines)
    table["cross_end"], table["width"] = CROSSOVER, strips
    rows = np.hstack([as_table(table)[:, :RULES_FROM], np.tile(cycle, (machines, 1))])
    zones = strip_zones(strip_centres(0.0, float(strips)))

    def crosses(
        cycles: np.ndarray, parameters: np.ndarray, wheels: np.ndarray, _: np.ndarray, tallies: np.ndarray
    ) -> None:
        parts = np.tile(zones, (machines, 1, 1))
        TRAVERSES.lanes(cycles, parameters, wheels, parts, tallies, NO_MOTIONS, np.arange(machines), 0, 1)

    return (rows, *others), crosses


G82, G81 = "G82 in lanes, N = 256", "G81 in lanes, N = 256"
FEW, MANY = "G82 in lanes, N = 16", "G82 in lanes, N = 4096"
CROSSES = "G83 on {} zones, N = 256"
IN_C = "G82 in C of {} lanes, N = 256"
compile_at_once()


def ns_per_stroke(loop: Loop, tables: tuple[np.ndarray, ...]) -> float:
    """Return the CPU time of a loop, ns per stroke, over enough calls for about `TURN` machines."""
    machines = len(tables[0])
    tallies, spent, strokes = np.empty(machines, TALLY), 0.0, 0.0
    for _ in range(-(-TURN // machines)):
        tallies[:] = 0.0
        spent += seconds(process_time, loop, *(as_table(each.copy()) for each in tables), as_table(tallies))
        strokes += tallies["strokes"].sum()
    return 1e9 * spent / strokes


def vector_width() -> str:
    """Return the name of the widest vector registers of this machine."""
    features = llvmlite.binding.get_host_cpu_features()
    return next((name for name, flag in (("AVX-512", "avx512f"), ("AVX2", "avx2")) if features.get(flag)), "SSE2")


def strokes() -> dict[str, Array]:
    """Return the ns per stroke of every loop, one value per round."""
    fed, feeds = feedings(256)
    loops: dict[str, tuple[Loop, tuple[np.ndarray, ...]]] = {
        G82: (plunges, cycles(256)),
        G81: (feeds, fed),
        FEW: (plunges, cycles(16)),
        MANY: (plunges, cycles(4096)),
    }
    for zones in (FEW_ZONES, MANY_ZONES):
        crossed, crosses = crossings(zones)
        loops[CROSSES.format(zones)] = crosses, crossed
    with TemporaryDirectory() as folder:
        if compiler():
            loops |= {IN_C.format(lanes): (compiled(Path(folder), lanes), cycles(256)) for lanes in LANES}
        sides = {
            name: lambda loop=loop, tables=tables: ns_per_stroke(loop, tables) for name, (loop, tables) in loops.items()
        }
        return in_turns(sides, SECONDS)


def ratios(ns: Mapping[str, Array]) -> Ratios:
    """Return the ratios between the times per stroke of the loops, one value per round."""
    found = {
        f"stroke in lanes over that in C, {lanes} lanes": over(ns[G82], ns[name])
        for lanes in LANES
        if (name := IN_C.format(lanes)) in ns
    }
    zone = (ns[CROSSES.format(MANY_ZONES)] - ns[CROSSES.format(FEW_ZONES)]) / (MANY_ZONES - FEW_ZONES)
    return found | {
        "stroke of G81 over one of G82": over(ns[G81], ns[G82]),
        "100 zones of a G83 over a stroke of G82": over(100.0 * zone, ns[G82]),
        "stroke at N = 16 over one at N = 4096": over(ns[FEW], ns[MANY]),
    }
