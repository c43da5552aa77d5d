import os
import re
import threading
import tracemalloc
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grind_env import files
from grind_env.control import program_scanner as source_module
from grind_env.control.block_words import read_block
from grind_env.control.errors import ControlError
from grind_env.control.program_reader import Blocks, read, read_file
from grind_env.control.program_scanner import Mark, Scanner, SourceText, Text, text_of
from tests.examples import examples
from tests.patience import PATIENCE

Found = tuple[int, int, str]


def naive_remark(rest: str) -> bool:
    """Return whether the text after a ; is a remark and not a block."""
    rest = rest.lstrip(" \t")
    if not rest or rest[0].isspace() or rest[0] in "(/#;%":
        return False
    if not (rest[0].isascii() and rest[0].isalpha()):
        return True
    if re.match(r"(if|while|goto|do|end)[ \t]*[\[#0-9]", rest.lower()):
        return False
    if rest[0].upper() in "EFIJKQRXYZ" and rest[1:2].upper() == "O" and not re.match("[A-Za-z]", rest[2:3]):
        return False
    behind = rest[1:].lstrip(" \t")[:1]
    return bool(behind) and behind not in "-+.0123456789[#();%\n"


def naive_blocks(text: str) -> list[Found]:
    """Return line, column and text of every block, found character by character."""
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    found: list[Found] = []
    line, column, commented, begun = 1, 1, False, False
    block, begin, remark = "", 1, False
    for position, character in enumerate(text + "\n"):
        if remark and character != "\n":
            continue
        remark = character == ";" and naive_remark(text[position + 1 :].partition("\n")[0])
        ends = character in ";\n" or (character == "%" and not commented)
        if not ends:
            commented = (commented or character == "(") and character != ")"
            if block or not character.isspace():
                begin = begin if block else column
                block += character
        column += 1
        if ends:
            if block:
                found.append((line, begin, block.rstrip()))
            begun = begun or bool(re.sub(r"\([^()]*\)", "", block).strip())
            if character == "%" and begun:
                return found
            block, commented = "", False
            if character == "\n":
                line, column = line + 1, 1
    return found


def seen(sources: Iterator[SourceText] | Blocks) -> list[Found]:
    return [(source.line, source.column, source.text) for source in sources]


def lines(count: int) -> str:
    return "".join(f"N{k % 100000} G01 X{k / 1000:.3f} Y-{k / 500:.3f} F{k % 900 + 1}.\n" for k in range(count))


programs_text = st.lists(
    st.sampled_from(
        [*"GX1 ();%\n\r\t\ufeffé", "\r\n", "; a ; 1%", ";XO", ";-", "O1", "O2", "O3", "(o)", "G01 X-1.5", "M99"]
    ),
    max_size=30,
).map("".join)


LEADERS = ["", "%", "\n%\r\n", "(A)\n%\n", "X1\n%\n", "%X1\n", "% (A) %", "%\n%\n", ";%;", "X1%"]
EVERYTHING = "O1 (É); G00 X1\r\n\r\n/N5 Y2;(%);Z3 \rO2\nO3\n(UNCLOSED % ; X4\r\r\n  X5 (A)(B;C) % X6\nX7"


def test_the_scanner_reads_all_leaders_like_a_reading_by_characters() -> None:
    for leader in LEADERS:
        compare_scan(leader + EVERYTHING)


@examples(300)
@given(programs_text, st.integers(1, 9))
def test_the_scanner_reads_any_text_like_a_reading_by_characters(text: str, chunk: int) -> None:
    compare_scan(text, (chunk,))


def compare_scan(text: str, chunks: Sequence[int] = (*range(1, 30), 1 << 16)) -> None:
    """Compare the blocks of a text, also those after every single block, with a reading by characters."""
    whole, expected = text_of(text, "t"), naive_blocks(text)
    with pytest.MonkeyPatch.context() as patch:
        for chunk in chunks:
            patch.setattr(source_module, "CHUNK", chunk)
            scanner = Scanner(whole.open(), whole, Mark())
            found, marks = [], [scanner.mark]
            for source in scanner:
                found.append((source.line, source.column, source.text))
                marks.append(scanner.mark)
            assert found == expected
            for taken, mark in enumerate(marks):
                assert seen(iter(Scanner(whole.open(), whole, mark))) == expected[taken:]


@examples(300)
@example("(o)\nO1\nO2\nG01 X-1.5 (o)\r\nO3\nM99", 3)
@example("(o)\n(o)\nX1", 3)
@example("(o)(\nO1", 3)
@example("G\nO1", 3)
@given(programs_text, st.integers(1, 9))
def test_programs_hold_the_blocks_between_their_names(text: str, chunk: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(source_module, "CHUNK", chunk)
        try:
            programs = list(read(text))
        except ControlError:
            return
        actual = [seen(program.blocks) for program in programs]
    parts: list[list[Found]] = [[]]
    for found in naive_blocks(text):
        if re.sub(r"\([^()]*\)", "", found[2]).strip().startswith("O"):
            parts.append([])
        else:
            parts[-1].append(found)
    comments_alone = all(not re.sub(r"\([^()%]{,126}\)", "", block).strip() for _, _, block in parts[0])
    assert actual == (parts[1:] if len(parts) > 1 and comments_alone else parts)
    assert [len(program.blocks) for program in programs] == [len(part) for part in actual]


@pytest.fixture(params=["held", "read again"])
def path(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the path of a program file whose text is held in memory or read again from disk."""
    if request.param == "read again":
        monkeypatch.setattr(source_module, "IN_MEMORY_BYTES", -1)
    return tmp_path / "part.nc"


def test_iterations_over_a_program_are_independent(path: Path) -> None:
    path.write_bytes(b"%\r\nO1 (MAIN)\r\nM98 P2\rX1; X2\r\nM30\r\nO2; G91 X3\nM99")
    main, sub = read_file(path)
    assert seen(main.blocks) == seen(main.blocks) == [(3, 1, "M98 P2"), (4, 1, "X1"), (4, 5, "X2"), (5, 1, "M30")]
    pairs = [(a.text, [b.text for b in sub.blocks]) for a in main.blocks]
    assert pairs == [(text, ["G91 X3", "M99"]) for text in ("M98 P2", "X1", "X2", "M30")]
    one, two = iter(main.blocks), iter(main.blocks)
    assert [next(one).text, next(one).text, next(two).text, next(one).text] == ["M98 P2", "X1", "M98 P2", "X2"]
    assert seen(sub.blocks) == [(6, 5, "G91 X3"), (7, 1, "M99")]


class Opened:
    """A text that records the handles it opens."""

    def __init__(self, text: str) -> None:
        self.handles: list[BinaryIO] = []
        self._text = text_of(text, "t")
        self.text = Text("t", "t", self.open)

    def open(self) -> BinaryIO:
        self.handles.append(self._text.open())
        return self.handles[-1]


def test_an_iterator_closes_its_text_at_its_end() -> None:
    words = [f"X{number}" for number in range(60)]
    opened = Opened("\n".join(words))
    blocks = Blocks(opened.text, Mark(), 60, None)
    assert [source.text for source in blocks] == words
    unfinished = iter(blocks)
    next(unfinished)
    assert [handle.closed for handle in opened.handles] == [True, False]
    del unfinished
    assert [handle.closed for handle in opened.handles] == [True, True]
    assert not list(Blocks(opened.text, Mark(), 0, None)) and len(opened.handles) == 2


def test_a_short_program_is_split_into_blocks_once() -> None:
    opened = Opened("X1\nX2\nX3")
    blocks = Blocks(opened.text, Mark(), 3, None)
    assert [source.text for source in (*blocks, *blocks)] == ["X1", "X2", "X3"] * 2
    assert [handle.closed for handle in opened.handles] == [True]


def peak(work: Path, count: int) -> tuple[int, int]:
    """Return the peak memory of reading `count` lines, bytes, and the number of blocks found."""
    work.write_text(f"O1\n{lines(count)}M30\n", encoding="utf-8")
    read_block.cache_clear()
    tracemalloc.start()
    programs = read_file(work)
    found = 0
    for source in programs.main.blocks:
        found += 1
        if found % 20 == 0:
            assert read_block(source).words
    top = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return top, found


@pytest.mark.nightly
def test_memory_does_not_grow_with_the_program(tmp_path: Path) -> None:
    small, few = peak(tmp_path / "small.nc", 35_000)
    large, many = peak(tmp_path / "large.nc", 130_000)
    assert (few, many) == (35_001, 130_001)
    assert (tmp_path / "large.nc").stat().st_size > 4_000_000
    assert large < 4_000_000
    assert large < 1.2 * small


def test_a_line_of_100_000_blocks_needs_less_than_2_mb(tmp_path: Path) -> None:
    path = tmp_path / "one_line.nc"
    path.write_text("G01 X1.234 Y2.345; " * 100_000, encoding="utf-8")
    tracemalloc.start()
    blocks = read_file(path).main.blocks
    last = blocks.last
    top = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(blocks) == 100_000 and last is not None and last.column == 19 * 99_999 + 1
    assert top < 2_000_000


def test_a_large_file_that_changes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_module, "IN_MEMORY_BYTES", -1)
    monkeypatch.setattr(source_module, "CHUNK", 4)
    path = tmp_path / "part.nc"
    path.write_text("X1\n" * 20_000)
    blocks = read_file(path).main.blocks
    started = iter(blocks)
    next(started)
    os.truncate(path, 30_000)
    with pytest.raises(ControlError, match=r"part\.nc has changed since it was read"):
        list(started)
    with pytest.raises(ControlError, match="has changed"):
        list(blocks)
    path.write_text("X1\n" * 20_000)
    again = read_file(path).main.blocks
    path.write_text("X2\n" * 20_000)
    os.utime(path, (0.0, 1.0))
    with pytest.raises(ControlError, match="has changed"):
        list(again)
    path.unlink()
    with pytest.raises(ControlError, match=r"part\.nc cannot be read \(No such file or directory\)"):
        list(blocks)


def test_a_small_file_may_change_after_it_was_read(tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    path.write_text("X1\nX2")
    blocks = read_file(path).main.blocks
    path.write_text("X3")
    assert [source.text for source in blocks] == ["X1", "X2"]


def test_a_pipe_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "PATIENCE", PATIENCE)
    path = tmp_path / "part.nc"
    os.mkfifo(path)
    writer = threading.Thread(target=path.write_text, args=("X1\nX2",))
    writer.start()
    blocks = read_file(path).main.blocks
    writer.join()
    assert seen(blocks) == seen(blocks) == [(1, 1, "X1"), (2, 1, "X2")]


@pytest.mark.parametrize("chunk", [3, 1 << 16])
@pytest.mark.parametrize(
    ("data", "line"), [(b"G00\n(R\0ck)", 2), (b"X1\rX2\r\n\n\0", 4), (b"M30\n%\nabc\n\0\n", 4), (b"X1\n(\0", 2)]
)
def test_a_null_byte_is_refused_with_its_line(
    path: Path, monkeypatch: pytest.MonkeyPatch, chunk: int, data: bytes, line: int
) -> None:
    monkeypatch.setattr(source_module, "CHUNK", chunk)
    path.write_bytes(data)
    with pytest.raises(ControlError, match=r"a byte 0 stands in this line, .*; save") as caught:
        read_file(path)
    assert (caught.value.name, caught.value.line) == ("file", line)


HEIDENHAIN = """0  BEGIN PGM PLATE MM
1  TOOL CALL 1 Z S1910
2  L  X-30 Y+2 R0 FMAX M3
3  END PGM PLATE MM
"""
HEIDENHAIN_ISO = "%40001 G71 *\nN10 G30 G17 X+0 Y+0 Z-40*\nN20 G01 X+10 F100*\nN9999 %40001 G71 *\n"
SINUMERIK = """N10 G90 G71 G94
N20 DEF REAL DEPTH=0.2
N30 R1=0.01
START:
N60 IF DEPTH>0.2 GOTOB START
N80 M30
"""
MAZATROL = """UNo. MAT. INITIAL-Z ATC MODE MULTI MODE
 0   CST IRN  50.  0  OFF
UNo. UNIT DEPTH SRV-Z SRV-R
SNo. TOOL NOM-D No. APRCH-X
"""


@pytest.mark.parametrize(
    ("text", "name", "line"),
    [
        (HEIDENHAIN, "Heidenhain", 1),
        (f"; FROM THE OFFICE\n\n{HEIDENHAIN}", "Heidenhain", 3),
        (HEIDENHAIN_ISO, "Heidenhain", 2),
        (f"%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR\n{SINUMERIK}", "Sinumerik", 1),
        (SINUMERIK, "Sinumerik", 2),
        (MAZATROL, "Mazatrol", 1),
    ],
)
def test_a_program_for_another_control_is_refused_by_the_name_of_the_control(text: str, name: str, line: int) -> None:
    for end in ("\n", "\r\n"):
        with pytest.raises(ControlError, match=f"this is a program for a {name} control") as caught:
            read(text.replace("\n", end))
        assert caught.value.line == line


def test_programs_for_this_control_are_not_taken_for_foreign_ones() -> None:
    # single words of another control are reported one by one
    for text in (
        "N10 R1=5\nN20 G00 X1\nM30",
        "(SINUMERIK: R1=5)\n(CYCLE81)\nG00 X1 ; R1=5 *\nX2 ; BEGIN PGM *",
        "L X+1",
    ):
        read(text)
    root = Path(__file__).parents[2]
    paths = [path for name in ("grind_env", "agents", "tests") for path in (root / name).rglob("*.n*c")]
    assert len(paths) > 100
    for path in paths:
        read_file(path)


@pytest.mark.parametrize("leader", ["(A)\n%\n", "(A) (B)\n\n(C)%", "%\n(A)\n%\n", "; FIRST\n%\n%\n"])
def test_comments_may_stand_before_the_first_percent(leader: str) -> None:
    main, sub = read(f"{leader}O1\nX1\n(B)\nM30\nO2\nX2\n%\nX3")
    assert [text for _, _, text in seen(main.blocks)] == ["X1", "(B)", "M30"]
    assert [text for _, _, text in seen(sub.blocks)] == ["X2"]


def test_parity_bits_and_data_transfer_codes_are_refused(path: Path) -> None:
    text = b"%\r\nO1 (MAIN)\r\nG00 X1. Y-2.5\r\nM30\r\n%\r\n"
    path.write_bytes(bytes(byte | 0x80 * (bin(byte).count("1") % 2) for byte in text))
    with pytest.raises(ControlError, match="every byte has a bit of even parity"):
        read_file(path)
    for number, data in ((2, b"\x12" + text), (4, text + b"\x14"), (3, text.replace(b"G00", b"\x13G00"))):
        path.write_bytes(data)
        with pytest.raises(ControlError, match=f"the code DC{number} of a data transfer") as caught:
            read_file(path)
        assert caught.value.line == {2: 1, 3: 3, 4: 6}[number]


@pytest.mark.parametrize("chunk", [3, 1 << 16])
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "cp437"])
def test_comments_may_use_any_8_bit_encoding(
    path: Path, monkeypatch: pytest.MonkeyPatch, chunk: int, encoding: str
) -> None:
    monkeypatch.setattr(source_module, "CHUNK", chunk)
    text = "O1 (Rückzug)\nX1 (ä)\nX2 ; zurück\n(ö) X3\nO2 (ü)\nX4\n"
    path.write_bytes(text.encode(encoding))
    programs = list(read_file(path))
    found = [[word for source in program.blocks for word in read_block(source).words] for program in programs]
    assert [[(str(word), word.column) for word in each] for each in found] == [
        [("X1", 1), ("X2", 1), ("X3", 5)],
        [("X4", 1)],
    ]
    if encoding != "cp437":
        assert next(iter(programs[0].blocks)).text == "X1 (ä)"


def words(text: str) -> list[str]:
    (source,) = read(text).main.blocks
    return [str(word) for word in read_block(source).words]


blanks = st.text(" \t", max_size=2)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["", "+", "-"]), st.from_regex(r"[0-9]{1,20}\.?|[0-9]{0,12}\.[0-9]{1,18}", fullmatch=True)
        ),
        min_size=1,
        max_size=5,
    ),
    st.data(),
)
def test_spacing_and_case_do_not_change_the_words(numbers: list[tuple[str, str]], data: st.DataObject) -> None:
    pieces, expected, columns = "", [], []
    for letter, (sign, number) in zip("XyZfG", numbers, strict=False):
        columns.append(len(pieces) + 1)
        pieces += letter
        for character in f"{sign}{number}":
            pieces += data.draw(blanks) + character
        pieces += data.draw(blanks)
        whole, point, decimals = number.partition(".")
        expected.append((letter.upper(), sign, whole, bool(point), decimals))
    (source,) = read(pieces).main.blocks
    found = read_block(source).words
    assert [word[:5] for word in found] == expected
    assert [word.column for word in found] == columns


def refusal(text: str) -> tuple[str, int | None]:
    with pytest.raises(ControlError) as caught:
        words(text)
    return caught.value.name, caught.value.column


def test_a_comment_has_at_most_128_characters_with_its_parentheses() -> None:
    assert words(f"({'A' * 126}) X1") == ["X1"]
    assert refusal(f"X1 ({'A' * 127})") == ("block-format", 4)


def test_block_delete_must_be_the_first_character() -> None:
    (source,) = read("  / X1").main.blocks
    assert source.deletable and words(" /X1") == ["X1"]
    assert refusal("//X1") == ("block-format", 2)
    assert words("(/ OFF) X1") == ["X1"]


@pytest.mark.parametrize("text", ["N12345 X1", "N0 X1", "N00001 X1"])
def test_block_numbers_have_up_to_five_digits(text: str) -> None:
    (source,) = read(text).main.blocks
    assert read_block(source).place.block == int(text[1:].split()[0])


@pytest.mark.parametrize(
    ("text", "name", "column"),
    [
        ("N[1]", "number-format", 1),
        ("X+-1", "number-format", 1),
        ("X.[1]", "number-format", 1),
        ("X1 É", "block-format", 4),
        ("X#1[2]", "expression", 4),
    ],
)
def test_a_faulty_word_is_refused_by_name_and_column(text: str, name: str, column: int) -> None:
    assert refusal(text) == (name, column)


def test_expressions_stay_unevaluated() -> None:
    (source,) = read("X[#12+ 6] G[#1]Y-#3 Z #[#1+[2]] R+ #4 F[1]").main.blocks
    block = read_block(source)
    assert [str(word) for word in block.words] == ["X[#12+ 6]", "G[#1]", "Y-#3", "Z#[#1+[2]]", "R+ #4", "F[1]"]
    assert [(word.whole, word.decimals) for word in block.words] == [("", "")] * 6
    assert [word.column for word in block.words] == [1, 11, 16, 21, 33, 39]


def test_equal_blocks_are_read_once_and_the_cache_is_small() -> None:
    one, two = (next(iter(read("G00 X1").main.blocks)) for _ in range(2))
    assert one is not two and read_block(one) is read_block(two)
    limit = read_block.cache_info().maxsize
    assert limit is not None and limit <= 4096
