"""Two threads, and the time up to the first call: part of `make speed`.

Wall times: two threads want an idle machine, the start-up times are those of fresh processes.
"""

import os
import tempfile
import time

import numpy as np
from rich.table import Table

from tests.batches import grind_cycles
from tests.speed.kernel import cycles
from tests.speed.turns import fresh_process
from tests.speed_public import cold as first_results

MACHINES = 16384
"""Of the call that two threads share."""

START = """
import time; begin = time.perf_counter()
from tests.speed.kernel import cycles
from tests.batches import grind_cycles
loaded = time.perf_counter(); grind_cycles(*cycles(1)); print(time.perf_counter() - loaded, loaded - begin)
"""


def wall_of_threads(threads: int) -> float:
    """Wall time of one batched call, s."""
    best = np.inf
    for _ in range(5):
        table, parameters, wheels, parts = cycles(MACHINES)
        begin = time.perf_counter()
        grind_cycles(table, parameters, wheels, parts, threads=threads)
        best = min(best, time.perf_counter() - begin)
    return best


def table() -> Table:
    """Times and their ratio."""
    one, two = wall_of_threads(1), wall_of_threads(2)
    with tempfile.TemporaryDirectory() as folder:
        cold, _ = fresh_process(START, NUMBA_CACHE_DIR=folder)
        warm, imports = fresh_process(START, NUMBA_CACHE_DIR=folder)
    result = Table(title=f"Threads and starts ({os.cpu_count()} cores)")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    result.add_row(f"two threads over one, N = {MACHINES}", f"{one / two:.2f}", ">= 1.7, idle machine")
    result.add_row("first call, cold cache", f"{cold:.1f} s", "")
    result.add_row("first call, warm cache", f"{warm:.2f} s", "")
    result.add_row("imports before it", f"{imports:.2f} s", "")
    for name, taken in first_results().items():
        result.add_row(name, f"{taken:.2f} s", "<= 1.2" if name.startswith("grind run") else "<= 1.5")
    return result
