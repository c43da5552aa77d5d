"""Detection of texts that are no part program of this control, with a sentence that names their kind."""

import re
from collections.abc import Mapping, Sequence

from grind_env.control.block_words import read_block
from grind_env.control.errors import ControlError, Place
from grind_env.control.program_scanner import SourceText
from grind_env.message_text import quoted

HEAD_BYTES = 4096  #: bytes at the beginning of a text that are searched for signs of another control
LEAST_SIGNS = 2  #: lines of another control that are needed to recognise it; a single one may be a slip
#: beginnings of lines by which other controls are recognised; no block of this control begins like these
SIGNS: Mapping[str, re.Pattern[str]] = {
    control: re.compile(f"(?:{sign})[^\r\n]*", re.IGNORECASE | re.MULTILINE | re.VERBOSE)
    for control, sign in {
        "Heidenhain": r"""
            ^[ \t]*(?:\d+[ \t]+)?(?:(?:BEGIN|END)[ ]PGM|BLK[ ]FORM|TOOL[ ](?:CALL|DEF)|CYCL[ ]DEF|CALL[ ]LBL|LBL)[ ]
            | ^[ \t]*(?:\d+[ \t]+)?(?:L|CC|CR|CT|LP|CP)[ \t]+[XYZ][+-]\d
            | ^[ \t]*N\d+[^;(\r\n]*\*(?=[ \t]*\r?$)
        """,
        "Sinumerik": r"""
            ^[ \t]*(?:%_N_\w | ;\$PATH=
            | (?:N\d+[ \t]*)?(?:(?:DEF|PROC|EXTERN|MCALL|SETMS|TRANS|ATRANS)[ ]+[A-Z] | STOPRE\b | SUPA\b | MSG\(
            | CYCLE\d+ | \$[AMPST][A-Z]?_ | R\d+[ ]*=[^=] | OS[A-Z]*\d?\[ | FA\[ | [A-Z]+\d?=(?:IC|AC|DC)\(
            | [A-Z_][A-Z_]\w*:[ \t]*\r?$ | (?:IF\b[^\r\n]*)?\bGOTO[BFC][ ] ))
        """,
        "Mazatrol": r"^[ \t]*(?:MAZATROL\b | [UPS]NO\.?[ \t] | FIG[ \t]+PTN\b | SEQ[ \t]+SHP\b)",
    }.items()
}
REMEDY = "this control reads the G code of a 9/Series: post the part for it, or write the program anew"
MOST_BLOCKS_BEFORE = 20  #: most blocks that are checked before the ``%`` that begins the program


def check_head(data: bytes, name: str) -> None:
    """Refuse a program for another control or with parity bits; `data` is its first `HEAD_BYTES` bytes."""
    if sum(byte > 0x7F for byte in data) > max(8, len(data) // 4) and not any(byte.bit_count() % 2 for byte in data):
        message = (
            "every byte has a bit of even parity, as on punched tape; receive the program with 7 data bits and even "
            "parity, or save it as text"
        )
        raise Place(name, 1, 1, 1).error("file", message)
    text = data.decode("latin-1")
    for control, sign in SIGNS.items():
        found = list(sign.finditer(text))
        if len(found) >= LEAST_SIGNS:
            line = 1 + len(re.findall(r"\r\n|\r|\n", text[: found[0].start()]))
            message = f"this is a program for a {control} control ({quoted(found[0][0].strip())}); {REMEDY}"
            raise Place(name, line, 1, line).error("file", message)


def check_before(blocks: Sequence[SourceText]) -> None:
    """Refuse a text before the ``%`` of a program if none of its blocks can be read."""
    if blocks and not any(has_words(block, faulty=False) for block in blocks):
        message = (
            f"{quoted(blocks[0].text)} stands before the % of the program, where only comments may stand; delete it, "
            "or put it in parentheses"
        )
        raise blocks[0].place.error("block-format", message)


def has_words(block: SourceText, *, faulty: bool) -> bool:
    """Return whether a block holds more than comments; `faulty` is the result for a block that cannot be read."""
    try:
        return bool(read_block(block).words)
    except ControlError:
        return faulty
