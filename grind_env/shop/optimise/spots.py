"""Where the number of a word stands: in the word itself, or in the assignment of the variable that the word reads."""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from typing import NamedTuple

from grind_env.control import Programs
from grind_env.control.source import SourceText
from grind_env.control.variables import LOCALS
from grind_env.control.words import Word
from grind_env.errors import listed
from grind_env.shop.optimise.editing import WordEdit, added_word, other_number, other_value, value_text, word_of

_COMMENT = re.compile(r"\([^()]*\)")
_READ = re.compile(r"[-+]?\[?[-+]?#([0-9]+)\]?")
_ANY = re.compile(r"#[ \t]*([0-9]+)")
_ASSIGNED = re.compile(r"#[ \t]*([0-9]+)[ \t]*=")
_WORKED_OUT = re.compile(r"#[ \t]*[\[#]")
_TURN = re.compile(r"GOTO|WHILE|DO[ \t]*[0-9]|M[ \t]*0*99(?![0-9])", re.IGNORECASE)
_MACRO = re.compile(r"[Gg][ \t]*0*65(?![0-9.])")


class Spot(NamedTuple):
    """Where the number of a word of a cycle block stands, or would stand."""

    source: SourceText
    letter: str
    form: str  # Its number as it is written, or what a new one is to look like
    missing: bool
    # The one that the block assigns and the word reads; None if the number stands in the word
    variable: int | None = None

    @property
    def place(self) -> str:
        """The variable and the line that assigns it, as tables show them."""
        return f"#{self.variable}, line {self.source.line}"

    def change(self, number: str) -> WordEdit:
        """Another number there, or what stands for one."""
        if self.variable is not None:
            return other_value(self.source, number)
        word = word_of(self.source, self.letter)
        return added_word(self.source, self.letter, number) if word is None else other_number(self.source, word, number)


def variable_of(word: Word | None) -> int | None:
    """The variable whose value is all that a word takes, or its negative; None of other words."""
    match = None if word is None else _READ.fullmatch("".join(word.expression.split()))
    return int(match[1]) if match else None


class Assignments:
    """The variables of a program, and where they are assigned and read."""

    def __init__(self, programs: Programs, given: Collection[int]) -> None:
        self.file, self.given = programs.name, given
        self._assigned: dict[int, list[SourceText]] = {}
        self._read: dict[int, Counter[SourceText]] = {}
        self._worked_out = self._macro = False
        for program in programs:
            for source in program.blocks:
                self._add(source)
        main = [*programs.main.blocks]
        straight = not any(_TURN.search(_COMMENT.sub("", each.text)) for each in main)
        self._order = {source: number for number, source in enumerate(main)} if straight else {}

    def _add(self, source: SourceText) -> None:
        text = _COMMENT.sub("", source.text)
        self._worked_out |= _WORKED_OUT.search(text) is not None
        self._macro |= _MACRO.search(text) is not None
        assigned = [int(number) for number in _ASSIGNED.findall(text)]
        for number in assigned:
            self._assigned.setdefault(number, []).append(source)
        for number, times in (Counter(map(int, _ANY.findall(text))) - Counter(assigned)).items():
            self._read.setdefault(number, Counter())[source] += times

    def place(self, variable: int, reader: SourceText) -> SourceText | None:
        """The block that assigns what a block reads; None if that is not known from the text.

        It is the only one that assigns the variable, or the last one before, in a main program that runs straight on.
        """
        places = self._assigned.get(variable, [])
        if len(places) != 1:
            order = self._order
            known = all(each in order for each in (*places, reader))
            places = [each for each in places if known and order[each] < order[reader]][-1:]
        return places[0] if places else None

    def spot(self, variable: int, letter: str, readers: Sequence[SourceText]) -> Spot | str:
        """The one number that some blocks read of a variable.

        Returns:
            Where it stands, or what else to do so that there is one.
        """
        place, places = self.place(variable, readers[0]), self._assigned.get(variable, [])
        others = self._read.get(variable, Counter()) - Counter(dict.fromkeys(readers, 1))
        others = Counter({each: n for each, n in others.items() if self.place(variable, each) in (place, None)})
        number = value_text(place) if place else None
        own = "give it a variable of its own"
        reasons = {
            f"assign one in the program, for #{variable} has a value from outside": variable in self.given,
            "name variables by their numbers, for one whose number is worked out may be this one": self._worked_out,
            "take a variable from #100 on, for a G65 may assign this one": self._macro and variable in LOCALS,
            "change what is assigned": not places,
            f"{own}, for this one is assigned in {_lines(places)}": place is None,
            f"in {_lines([place] if place else [])}, where it is worked out": number is None,
            f"{own}, for this one is read in {_lines(others)}, too": bool(others),
            f"assign it in {self.file}": place is not None and place.file != self.file,
        }
        why = next((remedy for remedy, holds in reasons.items() if holds), None)
        if why is not None:
            return why
        assert number is not None and place is not None
        return Spot(place, letter, number, missing=False, variable=variable)


def _lines(sources: Collection[SourceText]) -> str:
    """Where blocks stand, in words."""
    lines: Sequence[str] = [str(source.line) for source in sources]
    return f"line{'s' if len(lines) > 1 else ''} {listed(lines)}" if lines else "nothing"
