"""The ``#`` variables of paramacros: local, common and system ones (20-13; numbers of system variables D)."""

from collections.abc import Iterator, Mapping
from decimal import Decimal
from typing import Protocol, TypeAlias

from grind_env.control.macro_formulas import Value, VariableFault, rounded

LOCALS = range(1, 34)
COMMON = (range(100, 200), range(500, 1000))
ALARM = 3000
LARGEST_VALUE = 1e30  #: largest value of a variable at the start
DEEPEST_MACRO = 4  #: levels of macros called by G65 (20-13)

KINDS = "#1 to #33 are local, #100 to #199 and #500 to #999 common variables"

Values: TypeAlias = Mapping[int, float]
Notes: TypeAlias = Mapping[tuple[int, int], Value]  #: values of variables by level (-1 for common variables) and number


class System(Protocol):
    """Data of the control that a program can read and write."""

    def read(self, number: int) -> Decimal: ...

    def write(self, number: int, value: Decimal) -> None: ...


class Variables:
    """The variables of an execution."""

    def __init__(self, given: Values, system: System) -> None:
        # level of the macro under execution, 0 in the main program and in subprograms called by M98; number of reads
        # of system variables, whose values may change between two reads
        self.system, self.level, self.system_reads = system, 0, 0
        self._locals: list[dict[int, Decimal]] = [{} for _ in range(DEEPEST_MACRO + 1)]
        self._common: dict[int, Decimal] = {}
        self._found: dict[tuple[int, int], Value] | None = None
        self._written: set[tuple[int, int]] = set()
        self._unread: dict[tuple[int, int], bool] = {}
        self._dressed: set[tuple[int, int]] = set()
        self.dependent: int | None = None  # first variable read outside of a dress that a dress has assigned
        for number, value in given.items():
            self.write(number, rounded(Decimal(repr(float(value)))))
        self._unread = {self._key(number): False for number in given}  # True once overwritten

    def read(self, number: int) -> Value:
        """Return the value of a variable; None if it is vacant, as #0 always is."""
        held = self._values_with(number)
        if held is None:
            self.system_reads += number != 0
            return None if number == 0 else self.system.read(number)
        value, key = held.get(number), self._key(number)
        if self._unread.get(key) is False:
            del self._unread[key]
        if self._found is None:
            if key in self._dressed:
                self.dependent = self.dependent or number
        elif key not in self._written:
            self._found[key] = value
        return value

    def write(self, number: int, value: Value) -> None:
        held = self._values_with(number)
        if number == 0:
            raise VariableFault(f"#0 cannot be assigned; {KINDS}")
        if held is None:
            if value is None:
                raise VariableFault(f"#{number} cannot be made vacant; {KINDS}")
            self.system.write(number, value)
        else:
            key = self._key(number)
            self._written.add(key)
            if self._found is None:
                self._dressed.discard(key)
            if key in self._unread:
                self._unread[key] = True
            if value is None:
                held.pop(number, None)
            else:
                held[number] = value

    def begin_notes(self) -> None:
        """Begin a dress: note the values that it reads and has not assigned itself, and those that it leaves."""
        self._found, self._written = {}, set()

    def end_notes(self) -> Notes:
        read, self._found = self._found or {}, None
        self._dressed |= self._written
        return read | {(level, number): self._values_of(level).get(number) for level, number in self._written}

    def agree(self, notes: Notes) -> bool:
        return all(self._values_of(level).get(number) == value for (level, number), value in notes.items())

    def unread(self) -> Iterator[str]:
        for (_, number), overwritten in self._unread.items():
            found = "the program assigns another one before it reads it" if overwritten else "nothing has read it"
            yield f"#{number} was given a value at the start, but {found}; leave it out, or mend its number"

    def enter(self, arguments: Mapping[int, Decimal]) -> None:
        """Begin a macro: local variables of its level that no argument assigns keep their values (20-13)."""
        self.level += 1
        self._locals[self.level].update(arguments)

    def leave(self) -> None:
        self.level -= 1

    def ahead(self, system: System) -> "Variables":
        copy = Variables({}, system)
        copy.level = self.level
        copy._locals, copy._common = [dict(each) for each in self._locals], dict(self._common)
        return copy

    @property
    def state(self) -> tuple[object, ...]:
        return dict(self._common), *map(dict, self._locals)

    @property
    def values(self) -> Values:
        """Values of the common variables and of the local ones of the present level, by number."""
        return {number: float(value) for number, value in (self._common | self._locals[self.level]).items()}

    def _values_with(self, number: int) -> dict[int, Decimal] | None:
        return self._values_of(self._key(number)[0]) if number in LOCALS or is_common(number) else None

    def _key(self, number: int) -> tuple[int, int]:
        return (self.level if number in LOCALS else -1), number

    def _values_of(self, level: int) -> dict[int, Decimal]:
        return self._common if level < 0 else self._locals[level]


class Foreseen:
    """System variables for the look-ahead, where their values are not yet known: each access is an error."""

    def __init__(self) -> None:
        self.asked = False

    def read(self, number: int) -> Decimal:
        self.asked = True
        raise VariableFault(f"#{number} is read where the radius compensation looks ahead; copy it before G41 or G42")

    def write(self, number: int, value: Decimal) -> None:
        self.asked = True
        raise VariableFault(f"#{number} is assigned where the radius compensation looks ahead; do so before G41 or G42")


def is_common(number: int) -> bool:
    """Return whether all programs share a variable."""
    return any(number in numbers for numbers in COMMON)
