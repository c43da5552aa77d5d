"""Speed and memory of the control on a long program: part of `make speed`."""

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rich.table import Table

from grind_env.control import Control, Motion, execute, read_file


def write_program(path: Path, blocks: int, compensated: bool) -> None:
    """A zigzag of short lines in ZX, as a profile of a form wheel is written."""
    with path.open("w", encoding="utf-8") as file:
        file.write(f"G18 G90 G94 {'G41' if compensated else 'G40'} F600.\n")
        for number in range(blocks):
            file.write(f"N{number % 100_000} G01 Z{number % 30_000}.5 X{number % 2}.25\n")
        file.write("M30\n")


def measure(blocks: int, compensated: bool) -> None:
    """Execute such a program and print seconds, motions and the most memory of the process, MB."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.nc"
        write_program(path, blocks, compensated)
        begin = time.perf_counter()
        programs = read_file(path)
        control = Control(radius=0.1, block_budget=2 * blocks + 10)
        motions = sum(isinstance(event, Motion) for event in execute(programs, control))
        seconds = time.perf_counter() - begin
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e3 if sys.platform == "linux" else 1e6)
    print(seconds, motions, most)


def table(fresh_process: Callable[..., list[float]]) -> Table:
    """Blocks per second and memory of 20 000 and 200 000 blocks."""
    result = Table(title="Control")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    call = "from tests.speed_control import measure; measure({}, {})"
    _, _, few = fresh_process(call.format(20_000, False))
    seconds, _, many = fresh_process(call.format(200_000, False))
    slow, _, _ = fresh_process(call.format(200_000, True))
    result.add_row("200 000 blocks, read and executed", f"{200_000 / seconds:,.0f} blocks/s", "")
    result.add_row("the same under radius compensation", f"{200_000 / slow:,.0f} blocks/s", "")
    result.add_row("memory over that of 20 000 blocks", f"{many - few:.1f} MB", "bounded")
    return result
