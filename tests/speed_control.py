"""Speed and memory of the control on a long program, and of `grind run`: part of `make speed`."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rich.table import Table

import grind_env
from grind_env.control import Control, Motion, execute, read_file

PLATE = Path(grind_env.__file__).parent / "examples" / "plate_g82.nc"
PARTS = 3000


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


def write_parts(path: Path, parts: int = PARTS) -> None:
    """The example plate, again and again, with a dress so shallow that the wheel lasts."""
    _, text, _ = PLATE.read_text(encoding="utf-8").split("%\n")
    assert "N100 M30\n" in text
    calls = f"M98 P2001 L{parts // 4}\n" * 4  # L is 999 at most
    text = text.replace("N100 M30\n", "N100 M00\nM99\n").replace("Y-.02 F60.", "Y-.005 F60.")
    path.write_text(calls + "M30\n" + text, encoding="utf-8")


def seconds_of_run(program: Path) -> float:
    """CPU time of `grind run` with the job of the plate, its start and imports included."""
    command = [sys.executable, "-m", "grind_env", "run", program, "--job", PLATE.with_suffix(".toml")]
    begin = sum(os.times()[2:4])  # of children
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return sum(os.times()[2:4]) - begin


def table(fresh_process: Callable[..., list[float]]) -> Table:
    """Blocks per second and memory of 20 000 and 200 000 blocks, and the time of `grind run`."""
    result = Table(title="Control and programs")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    call = "from tests.speed_control import measure; measure({}, {})"
    _, _, few = fresh_process(call.format(20_000, False))
    seconds, _, many = fresh_process(call.format(200_000, False))
    slow, _, _ = fresh_process(call.format(200_000, True))
    result.add_row("200 000 blocks, read and executed", f"{200_000 / seconds:,.0f} blocks/s", "")
    result.add_row("the same under radius compensation", f"{200_000 / slow:,.0f} blocks/s", "")
    result.add_row("memory over that of 20 000 blocks", f"{many - few:.1f} MB", "bounded")
    result.add_row("grind run of one plate", f"{min(seconds_of_run(PLATE) for _ in range(3)):.2f} s", "by BASE")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "parts.nc"
        write_parts(path)
        result.add_row(f"grind run of {PARTS:,} plates", f"{seconds_of_run(path):.1f} s", "<= 3 s")
    return result
