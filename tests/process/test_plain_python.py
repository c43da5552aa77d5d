"""The process model has the same bits in compiled code and in plain Python."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from grind_env.process.stroke import grind_stroke
from tests.process.harness import grinder, parameters

pytestmark = pytest.mark.bits

ROOT = Path(__file__).resolve().parents[2]


SETUPS = (
    (parameters(), 12.0),
    (parameters("inconel_718", "b126", fluid="oil"), 5.0),
    (parameters(fluid="dry", dresser="rotary", constant_surface_speed=True), 30.0),
    (parameters("ti_6al_4v", "a120k", power=1500.0), 30.0),  # the spindle slows and stalls
)


def report() -> list[str]:
    """How the stroke runs, then every number of some strokes and dresses, bit by bit."""
    lines = ["compiled" if isinstance(grind_stroke, numba.core.dispatcher.Dispatcher) else "plain"]
    for p, table_speed in SETUPS:
        machine = grinder(p, table_speed)
        for part in range(3):
            machine.new_part()
            for downfeed in [0.012] * 8 + [0.0] * 4 + [-0.010]:
                numbers = (*machine.stroke(downfeed), *machine.wheel)
                lines.append(" ".join(map(float.hex, numbers)))
            lines.append(machine.dress(2.0 + part).hex())
            lines.append(" ".join(map(float.hex, machine.wheel)))
    return lines


def test_plain_python_gives_the_bits_of_compiled_code() -> None:
    plain = subprocess.run(
        [sys.executable, "-m", "tests.process.test_plain_python"],
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    compiled = report()
    assert (plain[0], compiled[0]) == ("plain", "compiled")
    assert len(compiled) == 1 + len(SETUPS) * 3 * 15
    assert plain[1:] == compiled[1:]


if __name__ == "__main__":
    print("\n".join(report()))
