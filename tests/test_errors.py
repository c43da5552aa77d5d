"""Messages quote long, deep or odd input in one short printable line."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import check, read
from grind_env.envs.tasks import load_task
from grind_env.errors import GrindError
from grind_env.machine.job.job_file import load_job
from grind_env.message_text import quoted, shortened
from grind_env.pages import page
from grind_env.process.catalogue import load_catalogue

LONG = "a" * 1_000_000
MOST = 400  #: characters of a message about hostile input, without the folder of its file


@given(st.text(max_size=60).filter(str.isprintable))
def test_short_printable_text_is_quoted_unchanged(text: str) -> None:
    assert shortened(text) == text
    assert quoted(text[:50]) == shortened(repr(text[:50]))


@given(st.text(max_size=3000))
def test_a_quotation_is_one_short_printable_line(text: str) -> None:
    for shown in (shortened(text), quoted(text)):
        assert shown.isprintable() and len(shown) < MOST


def nested(depth: int) -> Any:
    value: Any = 1
    for _ in range(depth):
        value = {"a": [value]}
    return value


def test_values_too_large_for_repr_are_named_by_their_type() -> None:
    assert quoted(nested(100_000)) == "a value of type dict that is too large to be shown"
    assert quoted(1 << 100_000) == "a value of type int that is too large to be shown"


JOB = '[part]\nmaterial = "aisi_52100"\nlength = 200\nwidth = 20\nstock = 0.3\nscrap_cost = 40\n'
JOBS = {
    "material": JOB.replace("aisi_52100", LONG),
    "a number": JOB.replace("200", '"' + LONG + '"'),
    "hexadecimal": JOB.replace("200", "0x" + "f" * 100_000),
    "decimal": JOB.replace("200", "9" * 100_000),
    "a deep material": JOB.replace('material = "aisi_52100"', "material" + ".a" * 400 + " = 1"),
    "a key": f"{JOB}{LONG[:900_000]} = 1\n",
    "a heading": f"{JOB}[{LONG[:900_000]}]\n",
    "a file": f'{JOB}[catalogue]\nfiles = ["{LONG[:900_000]}"]\n',
    "no file": JOB + '[catalogue]\nfiles = ["a\\u0000b"]\n',
    "files": JOB + "[catalogue]\nfiles = [" + "1," * 400_000 + "]\n",
    "a line break": JOB + '"a\\nb" = 1\n',
    "a key twice": f"{LONG[:400_000]} = 1\n" * 2,
}
CATALOGUES = {
    "a kind": f"[{LONG[:900_000]}.x]",
    "a name": f'[wheel.{LONG[:900_000]}]\nbase = "a60j"\ndiameter = 1',
    "a base": f'[wheel.x]\nbase = "{LONG[:900_000]}"',
    "a deep base": "[wheel.x]\nbase" + ".a" * 400 + " = 1",
    "a value": f'[wheel.x]\nbase = "a60j"\ndiameter = "{LONG[:900_000]}"',
}


TASK = (
    '[[kind]]\nname = "part"\nmaterial = "aisi_52100"\nstock = 0.2\npick = 0.01\n'
    "width = 20\nlength = 200\nheight = 20\n"
)
TASKS = {
    "a name": TASK.replace("part", LONG[:900_000]),
    "a line break": TASK.replace("part", "a\\nb"),
    "a width": TASK.replace("width = 20", "width = 2000").replace("part", "a" * 40),
    "a material": TASK.replace("aisi_52100", LONG[:900_000]),
    "a base": f'base = "{LONG[:900_000]}"',
    "a base in a file": f'base = "{LONG[:900_000]}.toml"',
    "a sequence": f'sequence = ["{LONG[:900_000]}"]\n{TASK}',
    "a long sequence": "sequence = [" + '"part",' * 90_000 + f"]\nblocks = 0\n{TASK}",
    "a factor": f"{TASK}[factors]\n{LONG[:900_000]} = 1",
    "a heading": f"{TASK}[{LONG[:900_000]}]",
    "kinds": "kind = [" + "1," * 400_000 + "]",
    "a deep kind": "kind" + ".a" * 400 + " = 1",
}


@pytest.mark.parametrize(
    ("read", "text"),
    [(load_job, text) for text in JOBS.values()]
    + [(load_catalogue, text) for text in CATALOGUES.values()]
    + [(lambda path: load_task(str(path)), text) for text in TASKS.values()],
    ids=[
        *(f"job: {name}" for name in JOBS),
        *(f"catalogue: {name}" for name in CATALOGUES),
        *(f"task: {name}" for name in TASKS),
    ],
)
def test_a_message_about_a_file_is_one_short_sentence(read: Any, text: str, tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    path.write_text(text)
    with pytest.raises(GrindError) as caught:
        read(path)
    message = str(caught.value)
    assert "job.toml" in message and message.isprintable() and len(message) - 2 * len(str(tmp_path)) < MOST


ONES = "1+" * 4_900 + "1]"
PROGRAMS = {
    **{f"{word}[": f"{word}[{ONES}" for word in ("G01 X", "G", "T-", "O", "M98 P", "M98 P1 L", "G80 X", "G00 Q")},
    "a zero stroke": f"G81 X[0*[{ONES}] I0 E600.",
    "brackets": "X" + "[" * 9_000,
    "a name": "X[" + "A" * 9_000 + "]",
    "variables": "X" + "#[" * 4_000,
    "digits": "X" + "1" * 9_000,
    "a label": "N" + "1" * 9_000,
    "a program": "O" + "1" * 9_000,
    "NUL": "\0" * 9_000,
    "a long block": "X" + "1" * 1_000_000,
    "a block of words": "G90" * 1_000_000,
    "a comment": "(" + "A" * 1_000_000 + ")",
}


@pytest.mark.parametrize("text", PROGRAMS.values(), ids=PROGRAMS)
def test_a_message_about_a_program_is_one_short_sentence(text: str) -> None:
    try:
        errors: list[Any] = list(check(read(text)).errors)
    except GrindError as error:
        errors = [error]
    assert errors
    assert all(str(error).isprintable() and len(str(error)) < MOST for error in errors)


@pytest.mark.parametrize("ask", [load_task, page])
def test_a_message_about_a_name_is_one_short_sentence(ask: Any) -> None:
    with pytest.raises(GrindError) as caught:
        ask(LONG)
    assert str(caught.value).isprintable() and len(str(caught.value)) < 2 * MOST
