"""The block budget: a program that would exceed it is refused long before it has run so far."""

from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.control import (
    Control,
    ControlError,
    CycleStart,
    Infeed,
    Interrupt,
    Motion,
    Rapid,
    Source,
    check,
    execute,
    read,
)
from grind_env.control.cycle_execution import least_strokes
from tests.command import status
from tests.control.harness import COMMON, DRESS, plans, refusal, run, strokes

EXAMPLES = Path(grind_env.__file__).parent / "examples"
CYCLE = "G82 X230. I-30. Y-.02 J-.01 F6. E12000. P9100"
RETURN = "G00 X-30. Y0\n"
NESTED = "O2\nM98 P3 L999\nM99\nO3\nM98 P4 L999\nM99\nO4\nG04 P1.\nM99\n"
LONG_DRESS = "O9100\nM98 P5 L999\nM99\nO5\nG04 P1.\nM99\n"

#: programs of more than a million blocks and strokes, with the line at fault
TOO_MUCH = {
    "a main program that begins again": ("G91 G00 X1.\nM99\n", 2),
    "with strokes": (f"{COMMON}{RETURN}{CYCLE}\nG80\nM99{DRESS}", 5),
    "without motion": ("M99\n", 1),
    "calls of one block": ("M98 P2 L999\nM30\nO2\nM98 P3 L999\nM99\nO3\nG04 P1.\nM99\n", 4),
    "calls in calls": (f"M98 P2 L999\nM30\n{NESTED}", 7),
    "few calls in few calls": (f"M98 P2 L300\nM30\n{NESTED}".replace("L999", "L300"), 7),
    "cycles in calls": (f"{COMMON}M98 P2 L999\nM30\nO2\n{RETURN}{CYCLE} L999 D999\nG80\nM99{DRESS}", 2),
    "dresses of many blocks": (f"{COMMON}{RETURN}{CYCLE.replace('-.01', '-.001')} D999\nM30\n{LONG_DRESS}", 3),
    "picks": (f"{COMMON}{RETURN}{CYCLE.replace('-.02', '-9999.').replace('-.01', '-.001')}\nM30{DRESS}", 3),
    "cross picks": (f"{COMMON}{RETURN}G83 X230. I-30. Y-9. J-.01 Z999. K.01 F6. E12000.\nM30", 3),
    "strokes beside a dwell": (f"{COMMON}G81 X.1 I0 E60000.\nG04 P99999.\nG80\nM30", 3),
    "strokes beside a motion": (f"{COMMON}G81 X.1 I0 E60000.\nG01 Z9999. F.01\nG80\nM30", 3),
    "grooves": ("G90 G94 G18\nG00 X30. Z0\nG77 X24. Z-50000. I.6 K.01 D0 F6.\nM30", 3),
}


@pytest.mark.parametrize(("text", "line"), TOO_MUCH.values(), ids=TOO_MUCH)
def test_a_program_beyond_the_block_budget_is_refused_early(text: str, line: int) -> None:
    events, made = execute(read(text)), 0
    with pytest.raises(ControlError) as caught:
        for _ in events:
            made += 1
            assert made < 50_000
    assert caught.value.name == "block-budget"
    assert caught.value.line == line


def test_a_larger_budget_allows_a_longer_program() -> None:
    text = TOO_MUCH["calls of one block"][0]
    assert len(list(islice(execute(read(text), Control(block_budget=3_000_000)), 5000))) == 5000
    few = text.replace("L999", "L30")
    assert refusal(few, block_budget=1000).name == "block-budget"
    assert sum(isinstance(event, Motion) for event in run(few, block_budget=3000)) == 900


@given(st.integers(1, 9), st.integers(0, 9), st.integers(0, 3))
def test_every_block_and_stroke_counts_one(calls: int, spark_out: int, dresses: int) -> None:
    text = f"{COMMON}M98 P2 L{calls}\nM30\nO2\n{RETURN}{CYCLE} L{spark_out} D{dresses}\nG80\nM99{DRESS}"
    events = run(text)
    blocks = 3 + 4 * calls + 3 * calls * dresses
    needed = blocks + len(strokes(events))
    assert run(text, block_budget=needed) == events
    assert refusal(text, block_budget=needed - 1).name == "block-budget"


def test_repeated_calls_shorter_than_the_first_are_not_refused() -> None:
    # only the first call finds the wheel above its depth
    deep = CYCLE.replace("-.02", "-1.").replace("-.01", "-.001")
    text = f"{COMMON}{RETURN}M98 P2 L999\nM30\nO2\n{deep}\nM99{DRESS}"
    assert len(plans(run(text, block_budget=20_000))) == 999


@pytest.mark.nightly
def test_a_program_of_three_thousand_parts_is_accepted() -> None:
    part, dress = (EXAMPLES / "plate_g82.nc").read_text(encoding="utf-8").replace("%", "").split("\nO9100")
    part = part.replace("O2001", "O2").replace("N100 M30", "N100 M00 M99")
    calls = "M98 P2 L750\n" * 4
    report = check(read(f"O1\n{calls}M30\n{part}\nO9100{dress}"))
    assert (report.errors, len(report.cycles)) == ([], 6000)


@given(
    st.sampled_from(["G82", "G83"]),
    st.lists(st.integers(1, 40), min_size=3, max_size=3),
    st.lists(st.integers(0, 60), min_size=3, max_size=3),
    st.booleans(),
)
def test_a_cycle_makes_at_least_the_predicted_number_of_strokes(
    code: str, picks: list[int], more: list[int], coverage: bool
) -> None:
    depth, width, spark_out = more
    words = f"Y-.{depth:03d} J-.{picks[0]:03d} Q-.{picks[1]:03d} L{spark_out % 7} F6. E60000."
    if code == "G83":
        words += f" Z{width}. K{picks[2]}."
    text = f"{COMMON}{RETURN}{code} X9. I-30. {words}\nG80\nM30"
    events = run(text, coverage_pass=coverage)
    (start,) = (event for event in events if isinstance(event, CycleStart))
    made, least = sum(stroke.number is not None for stroke in strokes(events)), least_strokes(start.plan, coverage)
    assert least <= made
    if picks[0] == picks[1] and depth > 0:
        assert least == made


@given(st.integers(1, 30), st.integers(1, 40), st.integers(0, 40), st.integers(1, 20))
def test_grooves_have_the_predicted_number_of_legs(step: int, depth: int, last: int, spacing: int) -> None:
    text = f"G90 G94 G18\nG00 X30. Z0\nG77 X{30 - depth}. Z-{last}. I{step}. K{spacing}. D0 F6.\nM30"
    motions = [event for event in run(text) if isinstance(event, Motion) and event.source is Source.CYCLE]
    infeeds = sum(isinstance(motion, Infeed) for motion in motions)
    assert infeeds == -(-depth // step) * (1 + -(-last // spacing))
    needed = 4 + len(motions)
    assert len(run(text, block_budget=needed)) >= len(motions)
    assert refusal(text, block_budget=needed - 1).name == "block-budget"
    assert all(isinstance(motion, Infeed | Rapid) for motion in motions)


@pytest.mark.parametrize("command", ["check", "trace", "run"])
def test_commands_take_a_budget(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    call = command, EXAMPLES / "plate_g82.nc"
    assert (status(*call, "--max-blocks", "53"), status(*call)) == (0, 0)
    capsys.readouterr()
    assert status(*call, "--max-blocks", "52") == 2
    assert "more than 52 blocks and strokes" in "".join(capsys.readouterr())
    assert status(*call, "--max-blocks", "0") == 2


@pytest.mark.parametrize(
    ("program", "control"),
    [
        ("O9100\nM98 P5 L400\nM99\nO5\nG04 P.01\nM99\n", {"operator_dress_at": (5.0,)}),
        (f"O77\nM98 P5 L400\nM99\nO5\nG04 P.01\nM99{DRESS}", {"interrupts": (Interrupt(77, at=1.5, immediate=False),)}),
    ],
    ids=["a dress that the operator asks for", "an interrupt"],
)
def test_a_single_dress_or_interrupt_between_many_parts_is_counted_once(program: str, control: dict[str, Any]) -> None:
    parts = f"{COMMON}M98 P2 L900\nM30\nO2\n{RETURN}{CYCLE}\nG80\nM99\n{program}"
    seen = sum(1 for _ in execute(read(parts), Control(**control)))
    assert 400 < seen < 100_000
