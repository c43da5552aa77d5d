"""Every error message of the control, word by word, with a program, settings or a call that cause it."""

import ast
import contextlib
import io
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import grind_env.control
from grind_env.control import (
    Control,
    ControlError,
    Interrupt,
    NumberFormat,
    check,
    dress_program_moves,
    execute,
    read,
    read_file,
)
from grind_env.control.block_decoding import decode
from grind_env.control.block_words import Block, read_block
from grind_env.control.cli_options import interrupts_of
from grind_env.control.compensation.corners import CompensationFault
from grind_env.control.control_flow import MOST_BLOCKS
from grind_env.control.macro_formulas import FormulaFault, VariableFault
from grind_env.control.macro_functions import FunctionFault
from grind_env.control.modal_state import Modes
from grind_env.control.path_geometry import ImpossibleArc
from grind_env.control.program_scanner import IN_MEMORY_BYTES
from grind_env.toml import tomllib
from tests.command import status

MESSAGES = tomllib.loads(Path(__file__).with_name("error_texts.toml").read_text(encoding="utf-8"))["message"]
SOURCES = Path(grind_env.control.__file__).parent
FAULTS = (ControlError, CompensationFault, ImpossibleArc, FormulaFault, FunctionFault, VariableFault)
MAKERS = {*(fault.__name__ for fault in FAULTS), "error"}  #: names of the functions that make an error

Site = tuple[str, int]


class Outcome(NamedTuple):
    """The printed text of a message, and the lines of the sources that made it."""

    text: str
    sites: set[Site]


def printed(message: dict[str, Any], folder: Path) -> str:
    """Return the answer of the control to the program, settings or call of a message."""
    if "call" in message:
        with pytest.raises(ControlError) as caught:
            CALLS[message["call"]](folder)
        return str(caught.value).replace(f"{folder}/", "")
    if "settings" in message:
        try:
            errors = check(read(message["program"], "part.nc"), settings(message["settings"])).errors
        except ControlError as error:
            errors = [error]
        return "\n".join(map(str, errors))
    path = folder / "part.nc"
    path.write_text(message["program"], encoding="utf-8")
    errors_shown = io.StringIO()
    with contextlib.redirect_stderr(errors_shown):
        assert status("check", path, *message.get("options", ())) == 2
    return errors_shown.getvalue().strip().removeprefix("grind: ")


def settings(values: dict[str, Any]) -> Control:
    """Return a control with settings from TOML: lists for tuples, strings for the keys of tables."""
    keywords = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
    for name in ("radii", "variables"):
        if name in keywords:
            keywords[name] = {int(key): value for key, value in keywords[name].items()}
    if "interrupts" in keywords:
        keywords["interrupts"] = tuple(Interrupt(**request) for request in keywords["interrupts"])
    if "number_format" in keywords:
        form = {name: tuple(v) if isinstance(v, list) else v for name, v in keywords["number_format"].items()}
        keywords["number_format"] = NumberFormat(**form)
    return Control(**keywords)


def hold(folder: Path) -> None:
    control = Control()
    control.feedhold()
    list(execute(read("G00 X1."), control))


def changed_file(folder: Path) -> None:
    path = folder / "part.nc"
    path.write_text("G00 X1.\n" * (IN_MEMORY_BYTES // 8 + 1))
    programs = read_file(path)
    path.write_text("G00 X1.\n")
    list(programs.main.blocks)


def with_parity(folder: Path) -> None:
    path = folder / "part.nc"
    path.write_bytes(bytes(byte | 0x80 * (bin(byte).count("1") % 2) for byte in b"G00 X1. Y-2.5\nX1. Y7.\nM30\n"))
    read_file(path)


def block(text: str) -> Block:
    return read_block(next(iter(read(text, "part.nc").main.blocks)))


def unevaluated(folder: Path) -> None:
    decode(block("G00 X#1"), Modes(), NumberFormat())


#: errors that no program and no setting can cause
CALLS: dict[str, Callable[[Path], object]] = {
    "override": lambda folder: Control().override(201.0),
    "hold": hold,
    "wheel radius": lambda folder: execute(read("G00 X1.")).set_wheel_radius(-1.0),
    "dress program": lambda folder: dress_program_moves(read("G00 X1.", "part.nc"), 5),
    "missing file": lambda folder: read_file(folder / "part.nc"),
    "job file": lambda folder: read_file(folder / "part.toml"),
    "parity": with_parity,
    "interrupt": lambda folder: interrupts_of(["9200"]),
    "long program": lambda folder: list(execute(read("X1\n" * MOST_BLOCKS + "GOTO 5", "part.nc"))),
    "changed file": changed_file,
    "long block": lambda folder: read("  " + "M03 " * 2500 + "M", "part.nc"),
    "unevaluated": unevaluated,
}


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory: pytest.TempPathFactory) -> list[Outcome]:
    """Return the outcome of every message, in the order of the file."""
    result = []
    for message in MESSAGES:
        folder = tmp_path_factory.mktemp("message")
        with noted_sites() as noted:
            text = printed(message, folder)
        sites = [made for error, made in noted if str(error).replace(f"{folder}/", "") in text.splitlines()]
        result.append(Outcome(text, set().union(*sites)))
    return result


@contextlib.contextmanager
def noted_sites() -> Iterator[list[tuple[Exception, set[Site]]]]:
    """Yield a list of errors with their source lines; an error made while handling another has the lines of both."""
    noted: list[tuple[Exception, set[Site]]] = []

    def watched(fault: type[Exception]) -> Callable[..., None]:
        make = fault.__init__

        def init(self: Exception, *args: Any, **keywords: Any) -> None:
            make(self, *args, **keywords)
            handled = sys.exc_info()[1]
            noted.append((self, set(_frames()).union(*(sites for error, sites in noted if error is handled))))

        return init

    with pytest.MonkeyPatch.context() as patch:
        for fault in FAULTS:
            patch.setattr(fault, "__init__", watched(fault), raising=False)
        yield noted


def _frames() -> Iterator[Site]:
    frame = sys._getframe(2)
    while frame is not None:
        yield frame.f_code.co_filename, frame.f_lineno
        frame = frame.f_back


def test_every_message_is_as_recorded(outcomes: list[Outcome]) -> None:
    for outcome, message in zip(outcomes, MESSAGES, strict=True):
        assert outcome.text == message["text"]
        assert re.fullmatch(r"(part\.nc:\d+:\d+: )?[^:].* \[[a-z-]+\]", outcome.text)


def test_every_error_in_the_sources_has_a_recorded_message(outcomes: list[Outcome]) -> None:
    reached = set().union(*(outcome.sites for outcome in outcomes))
    silent = []
    for path in sorted(SOURCES.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and _called(node) in MAKERS:
                lines = range(node.lineno, (node.end_lineno or node.lineno) + 1)
                if not any((str(path), line) in reached for line in lines):
                    silent.append(f"{path.name}:{node.lineno}: {ast.unparse(node)}")
    assert silent == []


def _called(node: ast.Call) -> str:
    if isinstance(node.func, ast.Name):
        return node.func.id
    return node.func.attr if isinstance(node.func, ast.Attribute) else ""
