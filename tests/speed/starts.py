"""The time up to the first result, in fresh processes with an empty cache: part of `make speed`."""

from rich.table import Table

from tests.speed_public import cold


def table() -> Table:
    """CPU times beside what is aimed at."""
    result = Table(title="First results")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    for name, taken in cold().items():
        result.add_row(name, f"{taken:.2f} s", "<= 1.2" if name.startswith("grind run") else "<= 1.5")
    return result
