"""A function that waits for other processes, even on a busy machine."""

import time
from collections.abc import Callable

PATIENCE = 1800.0  #: seconds after which a wait fails; even a busy machine never takes that long


def wait_until(condition: Callable[[], object]) -> None:
    """Return as soon as a condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
