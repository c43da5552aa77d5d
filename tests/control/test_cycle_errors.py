import pytest

from tests.control.harness import COMMON, DRESS, PARKED, cycles, plans, refusal, story

GOOD = "X230. I-30. Y-.1 J-.01 F6. E12000. P9100"


@pytest.mark.parametrize(
    ("block", "name", "word"),
    [
        (f"N7 G82 {GOOD} D2.5", "number-format", "D2.5"),
        (f"N7 G82 {GOOD} D-1", "out-of-range", "D-1"),
        (f"N7 G82 {GOOD} D1000", "out-of-range", "D1000"),
        (f"N7 G82 {GOOD} L1.5", "number-format", "L1.5"),
        ("N7 G81 X230. E0", "out-of-range", "E0"),
        ("N7 G81 X230. E-5.", "out-of-range", "E-5."),
        ("N7 G81 X230. E12000. L1", "block-format", "L1"),
        ("N7 G81 X230. E12000. Q-.1", "block-format", "Q-.1"),
        ("N7 G81 X230. E12000. R1.", "block-format", "R1."),
        (f"N7 G82 {GOOD} Z1.", "block-format", "Z1."),
        (f"N7 G82 {GOOD} K1.", "block-format", "K1."),
        (f"N7 G82 {GOOD} R1.", "block-format", "R1."),
        ("N7 G82 X230. Y-.1 J-.0005 F6. E12000.", "zero-pick", "J-.0005"),
        ("N7 G82 X230. Y-.1 J-.01 Q.01 F6. E12000.", "pick-direction", "Q.01"),
        ("N7 G83 X230. Y-.1 J-.01 Z10. K0 F6. E12000.", "zero-pick", "K0"),
        ("N7 G83 X230. Y-.1 J-.01 Z10. K-1. F6. E12000.", "pick-direction", "K-1."),
        ("N7 G83 X230. Y-.1 J-.01 Z10. K1. R-1. F6. E12000.", "pick-direction", "R-1."),
    ],
)
def test_a_faulty_cycle_word_is_refused_by_name_block_and_column(block: str, name: str, word: str) -> None:
    error = refusal(COMMON + block + "\nM30" + DRESS, start=PARKED)
    assert (error.name, error.block, error.line) == (name, 7, 2)
    assert error.column == block.index(word) + 1


def test_a_dress_program_counts_as_a_nesting_level() -> None:
    text = "M98 P1\nM30\nO1\nM98 P2\nM99\nO2\nM98 P3\nM99\nO3\n{}\nM99\nO5\nM99"
    cycle = "G19 G81.1 X9. E100. P5"
    assert refusal(text.format("M98 P4") + "\nO4\n" + cycle + "\nM99").name == "nesting"
    assert refusal(text.format(cycle + "\nZZ")).name == "number-format"


def test_a_cycle_of_zero_depth_has_strokes_but_no_picks_or_dresses() -> None:
    events = cycles("G82 X230. I-30. Y0 J.01 L2 F6. E12000. P9100 D3\nM30")
    assert story(events) == "X230 X-30 X230"
    assert refusal(COMMON + "G82 X230. Y0 J0 F6. E12000.").name == "zero-pick"


def test_q0_and_r0_skip_their_picks() -> None:
    assert story(cycles("G82 X230. I-30. Y-.03 J-.02 Q0 F6. E12000.\nM30")) == ("X230 y-0.02 X-30 X230 y-0.03 X-30")
    assert story(cycles("G83 X230. I-30. Y-.02 J-.02 Z20. K10. R0 F600. E12000.\nM30")) == (
        "X230 y-0.02 X-30 X230 z10 X-30 X230 z20 X-30"
    )


def test_the_spark_out_follows_at_once_without_a_coverage_pass() -> None:
    block = "X230. I-30. Y-.02 J-.01 L1 F6. E12000."
    assert story(cycles(f"G82 {block}\nM30", coverage_pass=False)) == "X230 y-0.01 X-30 y-0.02 X230"
    assert story(cycles(f"G83 {block} Z10. K10.\nM30", coverage_pass=False)) == (
        "X230 y-0.01 X-30 z10 X230 y-0.02 X-30 z0 X230"
    )


def test_g83_without_a_crossover_plunges_at_every_reversal() -> None:
    assert story(cycles("G83 X230. I-30. Y-.03 J-.02 Q-.01 Z0 K0 F6. E12000.\nM30")) == ("X230 y-0.02 X-30 y-0.03 X230")


def test_a_cycle_remembers_words_by_the_role_of_their_axis() -> None:
    events = cycles("G82 X230. I-30. Y-.02 J-.01 L1 F6. E12000.\nG80\nG17\nG82 X-29. I1.\nM30")
    second = plans(events)[1].plan
    assert (second.axis, second.primary, second.secondary) == (2, 230.0, -30.0)
    assert (second.plunge_axis, second.primary_pick, second.depth_target) == (0, 1.0, -29.0)
