"""Speed of the kernel, as ratios measured in one run: `make speed`.

Only ratios travel between machines. Times are process CPU time (the best of several runs) except for two threads,
which needs an idle machine, and the start-up times, which are wall time of fresh processes.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import llvmlite.binding
import numpy as np
from rich.console import Console
from rich.table import Table

from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.control.rules import DEPTH_TOLERANCE, motion_time
from grind_env.envs.blocks.episode import EpisodeGenerator
from grind_env.envs.infeed.infeed import write_motions
from grind_env.envs.infeed.step import feeding_of, infeed_of, infeed_stroking
from grind_env.envs.tables import kind_row, shop_row
from grind_env.envs.tasks import Task, load_task, read_task
from grind_env.machine.loops.batch import NO_MOTIONS, longest_plunges
from grind_env.machine.loops.feeding import FeedMotion
from grind_env.machine.loops.rows import RULES_FROM
from grind_env.machine.loops.zones import strip_centres, strip_zones
from tests import speed_control, speed_envs, speed_training
from tests.batches import CYCLE, FEEDS, PARAMETERS, PART, PLUNGES, TALLY, TRAVERSES, WHEEL, as_table, cold, grind_cycles

SECONDS = 0.5
"""Measured of each loop and number of machines, about."""

MACHINES = 16384
"""Of the call that two threads share."""

FEW_ZONES, MANY_ZONES, CROSSOVER, PAIRS = 8, 64, 20.0, 5
"""Zones of a part, from one end of the crossover to the other in mm, and how often both parts are measured."""

Loop = Callable[..., None]
"""Grinds on the tables of cycles, parameters, wheels, parts and tallies."""

START = """
import time; begin = time.perf_counter()
from tests.speed import cycles
from tests.batches import grind_cycles
loaded = time.perf_counter(); grind_cycles(*cycles(1)); print(time.perf_counter() - loaded, loaded - begin)
"""


def machines_of(task: Task, machines: int) -> tuple[np.ndarray, ...]:
    """Machines as episodes of a task begin: parameters, wheels, parts."""
    parameters = np.full(machines, np.array(tuple(task.parameters(task.kinds[0])), PARAMETERS))
    wheels = np.full(machines, np.array(cold(EpisodeGenerator(task).wheel(0.0)), WHEEL))
    return parameters, wheels, np.full(machines, np.array((0.0, 0.0, 1.6), PART))


def cycles(machines: int, seed: int = 0) -> tuple[np.ndarray, ...]:
    """Random G82 cycles, about 55 strokes each: arguments of `grind_cycles`."""
    rng = np.random.default_rng(seed)
    task = load_task("power_limited")
    kind = task.kinds[0]
    table = np.zeros(machines, CYCLE)
    table["speed"] = rng.uniform(100.0, 400.0, machines)
    table["stroke_seconds"] = [motion_time(360.0, speed, 1000.0) + 0.15 for speed in table["speed"]]
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
    """G82 in lanes, with the sorting."""
    order = np.empty(len(tables[0]), np.int64)
    longest_plunges(tables[0], np.arange(len(tables[0])), order)
    PLUNGES.lanes(*tables, NO_MOTIONS, order, 0, 1)


def plunges_alone(*tables: np.ndarray) -> None:
    """G82 machine by machine, without a log."""
    PLUNGES.scalar(*tables, NO_MOTIONS, np.empty((len(tables[0]), 0, 0)))


def feedings(machines: int, seed: int = 0) -> tuple[tuple[np.ndarray, ...], Loop]:
    """Random G81 blocks of their task: tables, and lanes that look the strokes up in the motions of these blocks."""
    rng = np.random.default_rng(seed)
    task = read_task("reciprocation")
    kind, shop, rate = kind_row(task, task.kinds[0]), shop_row(task), task.infeed / 60.0
    most, rows = 3, []
    motions = np.zeros((2 * (most + 1) * machines, len(FeedMotion._fields)))
    for first in range(0, len(motions), 2 * (most + 1)):
        speed, executions = rng.uniform(3000.0, 30_000.0), float(rng.integers(0, most + 1))
        infeed = infeed_of(kind, kind.stock, speed, shop.dwell, executions, shop.acceleration, rate)
        write_motions(motions, first, infeed)
        rows.append((*infeed_stroking(kind, shop, speed, infeed), *feeding_of(infeed, 0.0, first)))

    def feeds(*tables: np.ndarray) -> None:
        FEEDS.lanes(*tables, motions, np.arange(machines), 0, 1)

    return (np.array(rows), *machines_of(task, machines)), feeds


def crossings(strips: int, machines: int = 256) -> tuple[tuple[np.ndarray, ...], Loop]:
    """G83 cycles over parts of so many strips of 1 mm, each a zone: tables, and lanes that lay the parts anew."""
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


def ns_per_zone() -> np.ndarray:
    """CPU time that a zone more of a part takes in a stroke, ns; one number a pair of measurements."""
    (few, few_cross), (many, many_cross) = crossings(FEW_ZONES), crossings(MANY_ZONES)
    pairs = [(ns_per_stroke(few_cross, few), ns_per_stroke(many_cross, many)) for _ in range(PAIRS)]
    return np.array([(long - short) / (MANY_ZONES - FEW_ZONES) for short, long in pairs])


def ns_per_stroke(loop: Loop, tables: tuple[np.ndarray, ...]) -> float:
    """CPU time of a loop, ns per stroke."""
    best, tallies = np.inf, np.zeros(len(tables[0]), TALLY)
    for _ in speed_envs.rounds(time.perf_counter() + SECONDS):
        tallies[:] = 0.0
        arguments = [as_table(each.copy()) for each in tables]
        begin = time.process_time()
        loop(*arguments, as_table(tallies))
        best = min(best, (time.process_time() - begin) / tallies["strokes"].sum())
    return 1e9 * best


def wall_of_threads(threads: int) -> float:
    """Wall time of one batched call, s."""
    best = np.inf
    for _ in range(5):
        table, parameters, wheels, parts = cycles(MACHINES)
        begin = time.perf_counter()
        grind_cycles(table, parameters, wheels, parts, threads=threads)
        best = min(best, time.perf_counter() - begin)
    return best


def fresh_process(code: str, **environment: str) -> list[float]:
    """Numbers that a fresh Python prints."""
    root = Path(__file__).resolve().parents[1]
    run = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        cwd=root,
        check=True,
        capture_output=True,
        text=True,
    )
    return [float(word) for word in run.stdout.split()]


def vector_width() -> str:
    """Widest vector registers of this machine."""
    features = llvmlite.binding.get_host_cpu_features()
    return next((name for name, flag in (("AVX-512", "avx512f"), ("AVX2", "avx2")) if features.get(flag)), "SSE2")


def main() -> None:
    """Measure and print."""
    scalar = ns_per_stroke(plunges_alone, cycles(256))
    block = {n: ns_per_stroke(plunges, cycles(n)) for n in (1, 16, 256, 4096)}
    tables, feeds = feedings(256)
    fed = ns_per_stroke(feeds, tables)
    python = "from tests.speed import *; print(ns_per_stroke(plunges_alone, cycles(1)))"
    (plain,) = fresh_process(python, NUMBA_DISABLE_JIT="1")
    one, two = wall_of_threads(1), wall_of_threads(2)
    with tempfile.TemporaryDirectory() as folder:
        cold, _ = fresh_process(START, NUMBA_CACHE_DIR=folder)
        warm, imports = fresh_process(START, NUMBA_CACHE_DIR=folder)

    table = Table(title=f"Kernel speed ({vector_width()}, {os.cpu_count()} cores)")
    for name in ("measure", "value", "target"):
        table.add_column(name, justify="left" if name == "measure" else "right")
    table.add_row("G82 in lanes, N = 256", f"{block[256]:.1f} ns/stroke", "")
    table.add_row("G82 in the scalar loop", f"{scalar:.1f} ns/stroke", "")
    table.add_row("G81 in lanes, N = 256", f"{fed:.1f} ns/stroke", "")
    table.add_row("G81 over G82 in lanes, N = 256", f"{fed / block[256]:.2f}", "<= 1.5")
    table.add_row(f"G83: a zone in a stroke, of {MANY_ZONES}", speed_envs.quartiles(ns_per_zone(), " ns"), "<= 0.5 ns")
    table.add_row("lanes over scalar loop, N = 256", f"{scalar / block[256]:.2f}", ">= 4 (AVX2: 2.5)")
    table.add_row("lanes over scalar loop, N = 4096", f"{scalar / block[4096]:.2f}", ">= 4 (AVX2: 2.5)")
    table.add_row("ns per stroke, N = 16 over N = 4096", f"{block[16] / block[4096]:.2f}", "<= 1.25")
    table.add_row("ns per stroke, N = 1 over N = 4096", f"{block[1] / block[4096]:.2f}", "")
    table.add_row("lanes over the same source in plain Python", f"{plain / block[256]:.0f}", ">= 30")
    table.add_row(f"two threads over one, N = {MACHINES}", f"{one / two:.2f}", ">= 1.7, idle machine")
    table.add_row("first call, cold cache", f"{cold:.1f} s", "")
    table.add_row("first call, warm cache", f"{warm:.2f} s", "")
    table.add_row("imports before it", f"{imports:.2f} s", "")
    Console().print(table)
    Console().print(speed_control.table(fresh_process))
    Console().print(speed_envs.table(fresh_process))
    Console().print(speed_training.table(fresh_process))


if __name__ == "__main__":
    main()
