"""Decoding of a block in the modes before it: its command, and the modes after it (10-23)."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass

from grind_env.control import numbers
from grind_env.control.block_words import Block, Word
from grind_env.control.cycles import list_codes
from grind_env.control.errors import ControlError
from grind_env.control.modal_state import Modes
from grind_env.control.modes import ACTIONS, MACHINE_COORDINATES, MODAL_MACROS, MOTIONS, SWITCHES, UNSUPPORTED_CODES
from grind_env.control.numbers import NumberFormat

LENGTHS = frozenset("XYZIJKQR")
PROGRAM_FLOW = frozenset({2, 30, 98, 99})  #: M words that end or call a program; a block holds one of them at most


@dataclass(frozen=True, slots=True)
class Value:
    """A length word: its value in mm, for X a radius, and whether G91 was in force where it stands."""

    mm: float
    incremental: bool
    word: Word


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """A decoded block; in the same modes, a block is decoded once."""

    block: Block
    modes: Modes  #: modes in force at the end of the block
    code: str | None  #: its own motion, cycle, one-shot or G80 code; None if it has none
    code_word: Word | None  #: the word of that code
    lengths: Mapping[str, Value]  #: the X Y Z I J K Q R words
    words: Mapping[str, Word]  #: every word but G and M words, by letter
    m: tuple[int, ...]  #: the M numbers
    reciprocation_feed: float | None  #: E, mm/min; None without an E word
    tool: tuple[int, int] | None  #: entries of the radius and the length table that a T word selects; None without one
    number_format: NumberFormat  #: how the numbers of the block are read
    in_machine: bool = False  #: whether G53 makes its axis words machine coordinates

    @property
    def action(self) -> str:
        return self.code or self.modes.motion

    def error(self, name: str, message: str, letter: str = "") -> ControlError:
        return self.block.error(name, message, self.words.get(letter, self.code_word))

    def named(self, letter: str, mm: float) -> str:
        unit = float(numbers.MILLIMETRES_PER_INCH) if self.modes.inch else 1.0
        return str(self.words[letter]) if letter in self.words else f"{letter}{round(mm / unit, 7):g}"

    def allow_only(self, letters: str, action: str, common: str = "FEST") -> None:
        allowed = letters + common
        for letter, word in self.words.items():
            if letter not in allowed:
                message = f"{word} has no meaning in {action}; {', '.join(sorted({*allowed}))} have"
                raise self.block.error("block-format", message, word)


@functools.lru_cache(maxsize=1024)
def decode(block: Block, modes: Modes, form: NumberFormat) -> Command:
    """Return the command of a block; words apply from left to right, a mode only to the values to its right."""
    code: str | None = None
    code_word: Word | None = None
    lengths: dict[str, Value] = {}
    words: dict[str, Word] = {}
    m: list[int] = []
    reciprocation_feed: float | None = None
    tool: tuple[int, int] | None = None
    feed_missing: Word | None = None
    in_machine: Word | None = None
    for word in block.words:
        letter = word.letter
        if letter == "G":
            g = numbers.g_code(block, word, form)
            if g in SWITCHES:
                field, value = SWITCHES[g]
                if field == "per_revolution" and value != modes.per_revolution:
                    feed_missing = word
                modes = modes._replace(**{field: value})
            elif g in ACTIONS:
                if code is not None:
                    raise block.error("block-format", f"{word} follows {code}; a block holds one motion code", word)
                code, code_word = g, word
            elif g == MACHINE_COORDINATES:
                in_machine = word
            else:
                raise _refused(block, word, g)
        elif letter == "M":
            m.append(numbers.integer(block, word, 0, 999))
        else:
            words[letter] = word
            if letter in LENGTHS:
                mm = numbers.length(block, word, modes.inch, form)
                halved = letter == "X" and modes.diameter
                lengths[letter] = Value(0.5 * mm if halved else mm, modes.incremental, word)
            elif letter == "F":
                modes = modes._replace(feed=numbers.feed(block, word, modes.inch, form))
                feed_missing = None
            elif letter == "E":
                reciprocation_feed = numbers.feed(block, word, modes.inch, form)
            elif letter == "S":
                feet = modes.surface_speed and modes.inch  # S is feet per minute (12-41)
                speed = numbers.plain(block, word, form) * (numbers.METRES_PER_FOOT if feet else 1.0)
                modes = modes._replace(spindle=speed)
            elif letter == "T":
                tool = numbers.tool_numbers(block, word)
    if feed_missing is not None:
        raise block.error(
            "no-feedrate",
            f"{feed_missing} changes the feed mode without an F to its right; write the new F there",
            feed_missing,
        )
    if code in MOTIONS:
        modes = modes._replace(motion=code)
    if sum(number in PROGRAM_FLOW for number in m) > 1:
        raise block.error("block-format", "the block holds more than one of M02, M30, M98 and M99; it may hold one")
    if in_machine is not None:
        _require_machine_move(block, in_machine, code or modes.motion, lengths, modes)
    read = (block, modes, code, code_word, lengths, words, tuple(m), reciprocation_feed, tool, form)
    return Command(*read, in_machine=in_machine is not None)


def _require_machine_move(block: Block, word: Word, action: str, lengths: Mapping[str, Value], modes: Modes) -> None:
    if action not in ("G00", "G01"):
        raise block.error(
            "block-format", f"{word} goes with G00 or G01, but not with {action}; program one of them", word
        )
    if modes.compensation != "G40":
        raise block.error("compensation", f"{word} is programmed under {modes.compensation}; program G40 before", word)
    wrong = next((value.word for value in lengths.values() if value.incremental), None)
    if wrong is not None:
        message = f"{wrong} is incremental, but {word} takes machine coordinates; program G90 before it"
        raise block.error("block-format", message, wrong)


def recognise(block: Block, form: NumberFormat) -> None:
    """Check a block without the modes of its execution: its codes, and numbers that are too long in every unit."""
    if block.calls_macro:
        return
    for word in block.words:
        if word.expression and not (word.whole or word.decimals):
            continue  # its value is known when it is executed
        if word.letter == "M":
            numbers.integer(block, word, 0, 999)
        elif word.letter == "G":
            code = numbers.g_code(block, word, form)
            if not (code in SWITCHES or code in ACTIONS or code == MACHINE_COORDINATES):
                raise _refused(block, word, code)
        elif word.letter in LENGTHS:
            numbers.length(block, word, form.inch[0] > form.metric[0], form)


def _refused(block: Block, word: Word, code: str) -> ControlError:
    hint = "G70 is inch and G71 metric" if code in ("G20", "G21") else ""
    if code.startswith("G8"):
        hint = f"grinding cycles are {list_codes('and')}"
    if code in MODAL_MACROS:
        message = f"{code} calls macros after every motion, which this simulator does not do; write G65 in each place"
        return block.error("not-supported", message, word)
    if code in UNSUPPORTED_CODES:
        message = f"{code} is a code of the control that this simulator does not have; {hint or 'leave it out'}"
        return block.error("not-supported", message, word)
    return numbers.unknown_code(block, word, hint)
