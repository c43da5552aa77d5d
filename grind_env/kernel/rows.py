"""Named tuples of floats as rows of a table and as lanes of a buffer.

A lane buffer is one flat array: row k of a record holds field k of all lanes side by side, so that a loop over
the lanes reads and writes whole vector registers. numba needs the fields spelled out, hence the generated code.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.kernel.compile import inlined


def dtype_of(record: type[NamedTuple]) -> np.dtype[np.void]:
    """The structured dtype with one float64 per field of a named tuple."""
    return np.dtype([(name, np.float64) for name in record._fields])


def lane_reader(record: type[Any], first_row: int, lanes: int) -> Callable[[Any, int], Any]:
    """Compiled `read(rows, lane) -> record`, for a record that begins at `first_row` of the buffer."""
    fields = ", ".join(f"rows[{(first_row + k) * lanes} + lane]" for k in range(len(record._fields)))
    return _compile(f"def function(rows, lane):\n    return record({fields})", record)


def lane_writer(record: type[Any], first_row: int, lanes: int) -> Callable[[Any, int, Any], None]:
    """Compiled `write(rows, lane, value)`, the counterpart of `lane_reader`."""
    lines = (f"    rows[{(first_row + k) * lanes} + lane] = value.{name}" for k, name in enumerate(record._fields))
    return _compile("def function(rows, lane, value):\n" + "\n".join(lines), record)


def column_reader(record: type[Any]) -> Callable[[Any, int], Any]:
    """Compiled `read(table, i) -> record` from row i of a two-dimensional array, one field a column."""
    fields = ", ".join(f"table[i, {k}]" for k in range(len(record._fields)))
    return _compile(f"def function(table, i):\n    return record({fields})", record)


def column_writer(record: type[Any]) -> Callable[[Any, int, Any], None]:
    """Compiled `write(table, i, value)`, the counterpart of `column_reader`."""
    lines = (f"    table[i, {k}] = value.{name}" for k, name in enumerate(record._fields))
    return _compile("def function(table, i, value):\n" + "\n".join(lines), record)


def _compile(source: str, record: type[Any]) -> Callable[..., Any]:
    namespace: dict[str, Any] = {"record": record}
    exec(source, namespace)
    function: Callable[..., Any] = namespace["function"]
    return inlined(function)
