import pytest

from grind_env.control import Control, CycleAhead, CycleStart, execute, read
from grind_env.control.block_words import read_block
from grind_env.control.word_rewriting import with_words
from tests.control.harness import COMMON, DRESS, PARKED


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("G82 X1. E500. D2 (END)", "G82 X1. E900 D0 (END)"),
        ("G82 E 500.5 X1.", "G82 E900 X1. D0"),
        ("G82 E[#1 + 2]X1. D#3", "G82 E900X1. D0"),
        ("/N5 G81 X1.", "/N5 G81 X1. E900 D0"),
    ],
)
def test_words_are_replaced_or_added(text: str, changed: str) -> None:
    block = with_words(read_block(next(iter(read(text).main.blocks))), {"E": "900", "D": "0"})
    assert block.source.text == changed
    assert {word.letter: str(word) for word in block.words}["E"] == "E900"


def test_a_cycle_can_be_changed_before_it_is_executed() -> None:
    text = COMMON + "G82 X230. I-30. Y-.02 J-.01 E12000. F60. P9100\nG81\nM30" + DRESS
    stream = execute(read(text), Control(start=PARKED, announce_cycles=True))
    plans = []
    for event in stream:
        if isinstance(event, CycleAhead) and event.block.words[0].whole == "82":
            stream.choose(E="9000", D="1")
        elif isinstance(event, CycleStart):
            plans.append(event.plan)
    assert [(plan.feed, plan.dresses) for plan in plans] == [(9000.0, 1), (9000.0, 0)]
    assert plans[0].text == "G82 X230. I-30. Y-.02 J-.01 E9000 F60. P9100 D1"
