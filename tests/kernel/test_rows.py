"""Records in tables and lane buffers: compiled code gives the same results as plain Python."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numba.core import event

from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import column_reader, column_writer, lane_reader, lane_writer, replacer

LANES, FIRST = 4, 2


class Point(NamedTuple):
    x: float
    y: float
    z: float


class Other(NamedTuple):
    x: float
    y: float
    z: float


read_row, write_row = column_reader(Point), column_writer(Point)
get_lane, put_lane = lane_reader(Point, FIRST, LANES), lane_writer(Point, FIRST, LANES)


def move_row(source: Any, target: Any, i: Any) -> None:
    point = read_row(source, i)
    write_row(target, i, Point(point.z, point.x, 1))


def move_lane(source: Any, target: Any, lane: Any) -> None:
    point = get_lane(source, lane)
    put_lane(target, lane, Point(point.z, point.x, 1))


def numbers(shape: tuple[int, ...]) -> Any:
    return np.random.default_rng(0).random(shape)


TABLES = {
    "rows": numbers((5, 4)),
    "columns": np.asfortranarray(numbers((5, 4))),
    "every other": numbers((10, 8))[::2, ::-2],
    "float32": numbers((5, 4)).astype(np.float32),
}


@pytest.mark.parametrize("number", [int, np.uint64, np.int32, np.uint8])
@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_rows_are_read_and_written_as_in_plain_python(table: Any, number: Callable[[int], Any]) -> None:
    compiled = numba.njit(move_row)
    for i in range(5):
        here, there = np.zeros((5, 4)), np.zeros((5, 4))
        compiled(table, here, number(i))
        move_row(table, there, i)
        assert np.array_equal(here, there)
        assert list(here[i]) == [table[i, 2], table[i, 0], 1.0, 0.0]
        assert np.count_nonzero(here) == 3


def test_lanes_are_read_and_written_as_in_plain_python() -> None:
    compiled, rows = numba.njit(move_lane), numbers((6 * LANES,))
    for lane in range(LANES):
        here, there = np.zeros(6 * LANES), np.zeros(6 * LANES)
        compiled(rows, here, lane)
        move_lane(rows, there, lane)
        assert np.array_equal(here, there)
        fields = [FIRST * LANES + lane, (FIRST + 1) * LANES + lane, (FIRST + 2) * LANES + lane]
        assert list(here[fields]) == [rows[fields[2]], rows[fields[0]], 1.0]
        assert np.count_nonzero(here) == 3


def test_compiled_readers_return_the_record() -> None:
    assert numba.njit(lambda table, i: read_row(table, i))(TABLES["rows"], 1) == Point(*TABLES["rows"][1, :3])
    assert isinstance(numba.njit(lambda rows: get_lane(rows, 0))(np.arange(6.0 * LANES)), Point)


turned = replacer(Point, "z", "x")


def turn(point: Point) -> Point:
    return turned(point, (point.x, 7))


def test_fields_are_replaced_by_name_as_in_plain_python() -> None:
    for found in (numba.njit(turn)(Point(1.0, 2.0, 3.0)), turn(Point(1.0, 2.0, 3.0))):
        assert isinstance(found, Point) and found == Point(x=7.0, y=2.0, z=1.0)
    with pytest.raises(ValueError, match="not in tuple"):
        replacer(Point, "nothing")


@pytest.mark.parametrize(
    ("old", "numbers"),
    [(Other(1.0, 2.0, 3.0), (1.0, 2.0)), (Point(1.0, 2.0, 3.0), (1.0,)), ((1.0, 2.0, 3.0), (1.0, 2.0))],
)
def test_replacing_refuses_another_record_or_a_wrong_number_of_values(old: Any, numbers: Any) -> None:
    with pytest.raises(numba.TypingError):
        numba.njit(lambda old, numbers: turned(old, numbers))(old, numbers)


READ_ONLY = numbers((5, 4))
READ_ONLY.flags.writeable = False

REFUSED: dict[str, tuple[Callable[..., None], Any, Any]] = {
    "another record into a row": (write_row, numbers((5, 4)), Other(1.0, 2.0, 3.0)),
    "another record into a lane": (put_lane, numbers((6 * LANES,)), Other(1.0, 2.0, 3.0)),
    "a row of a lane buffer": (write_row, numbers((6 * LANES,)), Point(1.0, 2.0, 3.0)),
    "a lane of a table": (put_lane, numbers((5, 4)), Point(1.0, 2.0, 3.0)),
    "a row that is only read": (write_row, READ_ONLY, Point(1.0, 2.0, 3.0)),
}


@pytest.mark.parametrize(("write", "array", "value"), REFUSED.values(), ids=REFUSED)
def test_writers_refuse_a_wrong_record_or_array(write: Callable[..., None], array: Any, value: Any) -> None:
    with pytest.raises(numba.TypingError):
        numba.njit(lambda array, value: write(array, 0, value))(array, value)


@inlined
def swapped(point: Point) -> Point:
    return Point(point.z, point.y, point.x)


def test_readers_and_writers_need_no_compilation_of_their_own() -> None:
    read, write = column_reader(Point), column_writer(Point)
    get, put = lane_reader(Point, FIRST, LANES), lane_writer(Point, FIRST, LANES)

    @numba.njit
    def kernel(table: Any, rows: Any) -> None:
        write(table, 0, get(rows, 0))
        put(rows, 1, read(table, 1))

    with event.install_recorder("numba:compile") as recorder:
        kernel(np.ones((2, 3)), np.ones(6 * LANES))
    assert sum(happened.is_start for _, happened in recorder.buffer) == 1


def test_an_inlined_function_can_be_called_from_python_and_from_compiled_code() -> None:
    @entry
    def kernel(table: Any) -> Point:
        return swapped(read_row(table, 0))

    table = np.array([[1.0, 2.0, 3.0]])
    for _ in range(2):
        assert kernel(table) == swapped(Point(1.0, 2.0, 3.0)) == Point(3.0, 2.0, 1.0)
        assert swapped(Point(1, 2.0, 3)) == Point(3, 2.0, 1)
