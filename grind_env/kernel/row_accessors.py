"""Readers and writers of named tuples of floats, as rows of a table or lanes of a buffer.

A lane buffer is one flat array: row k of a record holds field k of all lanes side by side, so that a loop over
the lanes reads and writes whole vector registers.

A call of a reader or writer becomes one load or store per field. As separate compiled functions, readers and writers
took a third of the compile time. Numbers of lanes and rows count from 0; negative numbers are not allowed.

`numba.np.arrayobj` is imported only where code is generated, because kernels from disk do not need it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar, overload

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.typing import signature
from numba.extending import lower_builtin, type_callable

Record = TypeVar("Record")

#: function of LLVM's builder and a lane or row number; returns the array indices of the fields of that record
Indices: TypeAlias = Callable[[Any, Any], list[tuple[Any, ...]]]

LANES, ROWS = 1, 2  #: number of dimensions of a lane buffer, and of a table


class Replace(Protocol):
    """Function `replace(old, numbers)` for any record with the fields."""

    def __call__(self, old: Record, numbers: tuple[Any, ...], /) -> Record:
        """Return the record with these numbers."""


def dtype_of(*records: type[NamedTuple]) -> np.dtype[np.void]:
    """Return the structured dtype with one float64 for each field of the named tuples, in their order."""
    return np.dtype([(name, np.float64) for record in records for name in record._fields])


def lane_reader(record: type[Any], first_row: int, lanes: int) -> Callable[[Any, int], Any]:
    """Return the compiled `read(rows, lane) -> record`, for a record that begins at `first_row` of the buffer."""
    fields = _lane_fields(record, first_row, lanes)

    def read(rows: Any, lane: int) -> Any:
        return record(*(rows[start + lane] for start in fields))

    return _loads(read, record, LANES, _in_lane(fields))


def lane_writer(record: type[Any], first_row: int, lanes: int) -> Callable[[Any, int, Any], None]:
    """Return the compiled `write(rows, lane, value)`, the counterpart of `lane_reader`."""
    fields = _lane_fields(record, first_row, lanes)

    def write(rows: Any, lane: int, value: Any) -> None:
        for start, number in zip(fields, value, strict=True):
            rows[start + lane] = number

    return _stores(write, record, LANES, _in_lane(fields))


def column_reader(record: type[Any], first: int = 0) -> Callable[[Any, int], Any]:
    """Return the compiled `read(table, i) -> record`: row i of a 2-D array, one field a column from `first` on."""
    fields = tuple(range(first, first + len(record._fields)))

    def read(table: Any, i: int) -> Any:
        return record(*(table[i, column] for column in fields))

    return _loads(read, record, ROWS, _in_row(fields))


def column_writer(record: type[Any], first: int = 0) -> Callable[[Any, int, Any], None]:
    """Return the compiled `write(table, i, value)`, the counterpart of `column_reader`."""
    fields = tuple(range(first, first + len(record._fields)))

    def write(table: Any, i: int, value: Any) -> None:
        for column, number in zip(fields, value, strict=True):
            table[i, column] = number

    return _stores(write, record, ROWS, _in_row(fields))


@overload
def replacer(record: None, *names: str) -> Replace: ...


@overload
def replacer(record: type[Record], *names: str) -> Callable[[Record, tuple[Any, ...]], Record]: ...


def replacer(record: type[Any] | None, *names: str) -> Callable[[Any, tuple[Any, ...]], Any]:
    """Return the compiled `replace(old, numbers) -> record`: the fields `names` get the `numbers`, in this order.

    If `record` is None, `replace` takes any record with these fields. numba does not support `_replace`.
    """
    if record is not None:
        _places(record, names)

    def replace(old: Any, numbers: tuple[Any, ...]) -> Any:
        return old._replace(**dict(zip(names, numbers, strict=True)))

    def typed(old: Any, numbers: Any) -> Any:
        named = isinstance(old, types.NamedUniTuple)
        same = named and ({*names} <= {*old.fields} if record is None else old.instance_class is record)
        return old if same and isinstance(numbers, types.BaseTuple) and len(numbers) == len(names) else None

    def lower(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        old, kinds = sig.args
        found = cgutils.unpack_tuple(builder, arguments[0])
        numbers = cgutils.unpack_tuple(builder, arguments[1])
        for place, number, given in zip(_places(old.instance_class, names), numbers, kinds, strict=True):
            found[place] = context.cast(builder, number, given, old.dtype)
        return context.make_tuple(builder, sig.return_type, found)

    type_callable(replace)(lambda _: typed)
    lower_builtin(replace, types.BaseTuple, types.BaseTuple)(lower)
    return replace


def blend(one: Record, other: Record, share: float) -> Record:
    """Return `one + share * (other - one)` for every field of two records of the same kind."""
    numbers = zip(one, other, strict=True)  # type: ignore[call-overload]
    return one._make(a + share * (b - a) for a, b in numbers)  # type: ignore[attr-defined, no-any-return]


def _blend(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
    ones, others = (cgutils.unpack_tuple(builder, numbers) for numbers in arguments[:2])
    ways = (builder.fmul(arguments[2], builder.fsub(b, a)) for a, b in zip(ones, others, strict=True))
    return context.make_tuple(builder, sig.return_type, [builder.fadd(*pair) for pair in zip(ones, ways, strict=True)])


type_callable(blend)(lambda _: lambda one, other, share: one if one == other else None)
lower_builtin(blend, types.BaseTuple, types.BaseTuple, types.Float)(_blend)


def _places(record: Any, names: tuple[str, ...]) -> list[int]:
    """Return the positions of named fields in a record."""
    return [record._fields.index(name) for name in names]


def _lane_fields(record: type[Any], first_row: int, lanes: int) -> tuple[int, ...]:
    """Return the buffer indices of the fields of lane 0."""
    return tuple((first_row + k) * lanes for k in range(len(record._fields)))


def _in_lane(fields: tuple[int, ...]) -> Indices:
    return lambda builder, lane: [(builder.add(lane, lane.type(start)),) for start in fields]


def _in_row(fields: tuple[int, ...]) -> Indices:
    return lambda builder, i: [(i, i.type(column)) for column in fields]


def _loads(read: Callable[..., Any], record: type[Any], dimensions: int, indices: Indices) -> Callable[..., Any]:
    """Tell numba the return type of a reader, and how to load the record at the call."""

    def typed(array: Any, place: Any) -> Any:
        if _is_place(array, place, dimensions):
            return types.BaseTuple.from_types((array.dtype,) * len(record._fields), record)
        return None

    def load(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        from numba.np.arrayobj import load_item

        pointers = _pointers(context, builder, sig, arguments, indices)
        numbers = [load_item(context, builder, sig.args[0], pointer) for pointer in pointers]
        return context.make_tuple(builder, sig.return_type, numbers)

    type_callable(read)(lambda _: typed)
    lower_builtin(read, types.Array, types.Integer)(load)
    return read


def _stores(write: Callable[..., Any], record: type[Any], dimensions: int, indices: Indices) -> Callable[..., Any]:
    """Tell numba the argument types of a writer, and how to store the record at the call."""

    def typed(array: Any, place: Any, value: Any) -> Any:
        is_record = getattr(value, "instance_class", None) is record
        if is_record and _is_place(array, place, dimensions) and array.mutable:
            return signature(types.none, array, place, value)
        return None

    def store(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        from numba.np.arrayobj import store_item

        array, _, kinds = sig.args
        numbers = cgutils.unpack_tuple(builder, arguments[2])
        pointers = _pointers(context, builder, sig, arguments, indices)
        for number, kind, pointer in zip(numbers, kinds, pointers, strict=True):
            store_item(context, builder, array, context.cast(builder, number, kind, array.dtype), pointer)
        return context.get_dummy_value()

    type_callable(write)(lambda _: typed)
    lower_builtin(write, types.Array, types.Integer, types.BaseTuple)(store)
    return write


def _is_place(array: Any, place: Any, dimensions: int) -> bool:
    """Return whether these are the types of an array and of a lane or row number."""
    return isinstance(array, types.Array) and array.ndim == dimensions and isinstance(place, types.Integer)


def _pointers(context: Any, builder: Any, sig: Any, arguments: Any, indices: Indices) -> list[Any]:
    """Return pointers to the fields of the record."""
    kind, place_kind = sig.args[:2]
    array = context.make_array(kind)(context, builder, arguments[0])
    place = context.cast(builder, arguments[1], place_kind, types.intp)
    return [cgutils.get_item_pointer(context, builder, kind, array, index) for index in indices(builder, place)]
