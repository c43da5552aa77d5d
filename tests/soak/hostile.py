"""Hostile changes of a file: of its bytes, numbers, words and lines, or of the kind of file."""

import json
import os
import random
import re
import socket
import struct
from collections.abc import Callable
from pathlib import Path

ESCAPE = "\x1b[31mRED\x1b]0\x07\x9b2J\x7f\u202e"
MARKUP = "<script>alert(1)</script>"
NUMBERS = (
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "1e400", "-1", "0", "-0.0", "1e9", "0.000001", "0x10"),
    *("1_000", "9" * 40, "9" * 5000, "1,5", "..", "--5", "1e", "\u0661\u0662", "true", "[1]", "{}", '""', "null"),
)
WORDS = (
    *("", "x" * 100_000, ESCAPE, MARKUP, "=1+1", "@SUM(A1)", "+1", "-cmd|' /C calc'!A0", "\t=1", "$x^{", "{{7*7}}"),
    *("%s%n", "../secret.txt", "../../secret.txt", "/etc/passwd", "/dev/zero", "../secret.toml", ".", "..", "/", "~"),
    *("\\u0000", "\\ud800", "\u200f\u202e", "a\x00b", "[bold]x[/bold]", "[/]", "nan", "1e999", "CON", "-", "--help"),
)
NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+")
WORD = re.compile(r'"[^"\n]*"')
MACHINE = re.compile(r"[a-z-]+:\d+")  #: pattern of the name of a plant
SEEDS = (
    *("0", "4294967295", "4294967296", "-1", "1.5", "1e3", "0x7", "\u0663", "", " 7", "7\n"),
    *("9" * 5000, "0" * 5000 + "7"),
)
CANARY = "canary_5c19"  #: name of a module that leaves a trace when it is imported
LONG = 1_000_000  #: size beyond which a file is not changed any further, bytes
SPARSE = 70_000_000  #: size of a sparse file without content, bytes


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Return the bytes of a valid file with one or more random changes."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        if len(data) > LONG:
            break
        change = rng.choice(TEXTUAL if rng.random() < 0.7 else RAW)
        data = change(data, rng)
    return data


def _number(data: bytes, rng: random.Random) -> bytes:
    return _replaced(data, NUMBER, lambda: rng.choice(NUMBERS), rng)


def _word(data: bytes, rng: random.Random) -> bytes:
    return _replaced(data, WORD, lambda: f'"{rng.choice(WORDS)}"', rng)


def _replaced(data: bytes, pattern: "re.Pattern[str]", new: Callable[[], str], rng: random.Random) -> bytes:
    text = data.decode("utf-8", "surrogateescape")
    found = list(pattern.finditer(text))
    if not found:
        return data
    here = rng.choice(found)
    return (text[: here.start()] + new() + text[here.end() :]).encode("utf-8", "surrogateescape")


def _piece(data: bytes, rng: random.Random) -> bytes:
    """Replace a piece between separators, such as a cell, word or key."""
    pieces = re.split(rb"([\s,;=\[\]{}:]+)", data)
    pieces[rng.randrange(0, len(pieces), 2)] = rng.choice((*NUMBERS, *WORDS)).encode("utf-8", "surrogateescape")
    return b"".join(pieces)


def _lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    here, there = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(5)
    if kind == 0:
        del lines[here]
    elif kind == 1:
        lines.insert(there, lines[here])
    elif kind == 2:
        lines[here], lines[there] = lines[there], lines[here]
    elif kind == 3:
        lines[here:here] = lines[here : here + 1] * 3000
    else:
        lines[here] *= rng.choice((2, 2000))
    return b"\n".join(lines)


def _nested(data: bytes, rng: random.Random) -> bytes:
    depth = rng.choice((10, 1000, 100_000))
    text = rng.choice(
        (
            *("x = " + "[" * depth + "]" * depth, "[" + ".".join("a" * depth) + "]", "[" * depth, '{"a":' * depth),
            *("(" * depth, "#1=" + "[" * depth + "1" + "]" * depth, "x = " + '{a = "' + "y" * depth + '"}'),
            *(f"N{depth} M98 P1 L{depth}", "WHILE[1 EQ 1]DO1\nEND1", "N1 GOTO1", "#1=" + "1+" * depth + "1"),
        )
    ).encode()
    lines = data.split(b"\n")
    lines.insert(rng.randrange(len(lines) + 1), text)
    return b"\n".join(lines)


def _flipped(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 4, 40))):
        if changed:
            changed[rng.randrange(len(changed))] = rng.choice((0, 9, 10, 27, 34, 127, 255, rng.randrange(256)))
    return bytes(changed)


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _inserted(data: bytes, rng: random.Random) -> bytes:
    here = rng.randrange(len(data) + 1)
    piece = rng.choice(
        (
            *(b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b"\r\n", b"\x1a", b"\x85", ESCAPE.encode(), MARKUP.encode()),
            *(rng.randbytes(100), b"A" * 1_000_000, b"\n" * 100_000, b"," * 200_000, b'"', b"9" * 100_000),
        )
    )
    return data[:here] + piece + data[here:]


def _coded(data: bytes, rng: random.Random) -> bytes:
    text = data.decode("utf-8", "replace")
    return rng.choice((text.encode("utf-16"), text.encode("utf-32"), text.encode("utf-8-sig"), text.encode("utf-7")))


def _replaced_whole(data: bytes, rng: random.Random) -> bytes:
    return rng.choice((b"", b"\n", b"\0" * 1000, b"PK\x03\x04" + data, rng.randbytes(3000), b"{}", b"[]", b"null"))


TEXTUAL = (_number, _number, _word, _piece, _piece, _lines, _lines, _nested)
RAW = (_flipped, _cut, _inserted, _coded, _replaced_whole)


def tensors(data: bytes, rng: random.Random) -> bytes:
    """Return a file of tensors with changes of its header, shapes, offsets or values."""
    if rng.random() < 0.25:
        return mutated(data, rng)
    size = struct.unpack("<Q", data[:8])[0]
    header, body = data[8 : 8 + size], data[8 + size :]
    kind = rng.randrange(5)
    if kind == 0:
        header = mutated(header, rng)
    elif kind == 1:
        tables = json.loads(header)
        key = rng.choice([name for name in tables if name != "__metadata__"])
        shape = rng.choice(([2**40], [2**62, 2**62], [], [-1], [0], [1e9], ["x"], [2**31, 2]))
        changed = {"shape": shape} if rng.random() < 0.5 else {"data_offsets": [0, rng.choice((2**40, 0, -1, 2**64))]}
        header = json.dumps({**tables, key: {**tables[key], **changed}}).encode()
    elif kind == 2:
        tables = json.loads(header)
        said = tables["__metadata__"]
        name = rng.choice(list(said))
        said[name] = mutated(said[name].encode(), rng).decode("utf-8", "replace")
        header = json.dumps(tables).encode()
    elif kind == 3:
        count = rng.choice((1, 40, len(body) // 4))
        values = bytearray(body)
        for _ in range(count):
            here = 4 * rng.randrange(len(body) // 4)
            values[here : here + 4] = struct.pack("<f", rng.choice((float("nan"), float("inf"), 3e38, -3e38, 1e-45)))
        body = bytes(values)
    length = len(header) if kind < 4 else rng.choice((2**63, 2**40, 0, size - 1, size + 1, 100_000_000))
    return struct.pack("<Q", length) + header + body


def named(data: bytes, rng: random.Random) -> bytes:
    """Return a file with another name of a plant: of the same family, of another one or of none."""
    if rng.random() < 0.2:
        return mutated(data, rng)
    good = MACHINE.search(data.decode())
    assert good is not None
    family, own = good[0].partition(":")[0], f"{CANARY}:MACHINE"
    others = (
        *(family, f"{family}:{rng.choice(SEEDS)}", f"{family}:{rng.getrandbits(32)}", "model", good[0].upper()),
        *(
            f"{good[0]}+{good[0]}",
            f"{good[0]}+",
            f"{good[0]}+" * 100_000 + good[0],
            "foreign:1+bursts:2",
            "held-out:5+meter:1",
        ),
        *(own, f"{own}:7", f"{own}:7+{good[0]}", f"{good[0]}+{own}:7", f"{CANARY}:", f"./{own}"),
        *("os:system", "sys:exit:1", "no.such:x", "..:x", "a:b:c:d", f"{family}::7", "held-out:5+meter:1"),
        *(rng.choice(WORDS), rng.choice(NUMBERS)),
    )
    return MACHINE.sub(lambda _: rng.choice(others), data.decode(), count=1).encode("utf-8", "surrogateescape")


def lay(path: Path, rng: random.Random) -> None:
    """Put a pipe, folder, link, socket, sparse file, empty file or nothing in place of a file."""
    path.unlink(missing_ok=True)
    kind = rng.randrange(9)
    if kind == 0:
        os.mkfifo(path)
    elif kind == 1:
        path.mkdir()
    elif kind == 2:
        path.symlink_to(path.name)
    elif kind == 3:
        path.symlink_to(rng.choice(("/dev/zero", "/dev/random", "/dev/null", "/dev/full", "/proc/self/mem")))
    elif kind == 4:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)  # a relative name, because long names are refused
    elif kind == 5:
        with path.open("wb") as file:
            file.truncate(SPARSE)
    elif kind == 6:
        path.symlink_to("../secret.txt")
    elif kind == 7:
        path.write_bytes(b"")
    # else nothing
