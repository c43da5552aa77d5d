"""Waiting for what other processes do, on a machine that may be busy with something else."""

import time
from collections.abc import Callable

PATIENCE = 1800.0
"""s after which something hangs; no busy machine takes as long for what these tests wait for."""


def wait_until(condition: Callable[[], object]) -> None:
    """Return as soon as a condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
