"""The words of the grinding cycles: their meanings, ranges and values when omitted."""

import pytest

from grind_env.control import CycleEnd, CyclePlan, DressStart, Motion, check, read
from tests.control.harness import COMMON, DRESS, PARKED, cycles, plans, refusal, run, story, strokes

G82 = "G82 X230. I-30. Y-.02 J-.01 F60. E12000."
G83 = "G83 X230. I-30. Y-.02 J-.02 Z20. K10. F6000. E12000."


def last_plan(text: str, **settings: object) -> CyclePlan:
    return plans(cycles(text, **settings))[-1].plan


@pytest.mark.parametrize(("axis", "integrand"), ["XI", "YJ", "ZK"])
def test_g81_takes_each_axis_with_its_own_integrand(axis: str, integrand: str) -> None:
    (start,) = plans(run(f"G81 {axis}40. {integrand}-5. E600. P9100" + DRESS))
    plan = start.plan
    assert (plan.axis, plan.primary, plan.secondary, plan.feed, plan.program) == (
        "XYZ".index(axis),
        40.0,
        -5.0,
        600.0,
        9100,
    )
    foreign = {"X": "J", "Y": "K", "Z": "I"}[axis]
    assert refusal(f"G81 {axis}40. {foreign}-5. E600.").name == "block-format"


def test_g81_takes_omitted_words_from_the_last_cycle() -> None:
    first = "G81 X230. I-20. E12000. P9100\nG80\n"
    plan = last_plan(first + "G81 X200.")
    assert (plan.primary, plan.secondary, plan.feed, plan.program) == (200.0, -20.0, 12000.0, 9100)
    plan = last_plan(first + "G81 I-10.")
    assert (plan.primary, plan.secondary) == (230.0, -10.0)


@pytest.mark.parametrize("code", ["G82", "G83"])
def test_g82_and_g83_take_omitted_words_from_the_last_cycle(code: str) -> None:
    first = {"G82": G82, "G83": G83}[code]
    before, after = (start.plan for start in plans(cycles(f"{first} P9100\nG80\nG00 X-30. Y0 Z0\n{code}" + "\nM30")))
    for name in ("axis", "primary", "secondary", "depth_target", "primary_pick", "cross_end", "primary_cross_pick"):
        assert getattr(after, name) == getattr(before, name), name
    assert (after.feed, after.pick_feed, after.program) == (before.feed, before.pick_feed, before.program)


def test_e_is_read_like_f() -> None:
    assert last_plan("G81 X9. E1234.5678").feed == 1234.567
    assert last_plan("G70 G81 X9. E10.").feed == 254.0
    assert refusal(COMMON + "G81 X9. E123456.").name == "number-format"


def test_f_of_the_block_replaces_a_missing_e() -> None:
    assert last_plan("F300.\nG82 X230. Y-.02 J-.01 F60.").feed == 60.0


def test_p_is_needed_for_a_pre_dress_only() -> None:
    for block in ("G81 X230. E600.", G82, G83):
        code, _, words = block.partition(" ")
        assert last_plan(block).program is None
        assert refusal(COMMON + f"{code}.1 {words}", start=PARKED).name == "missing-parameter"
        assert last_plan(f"G81 X9. E600. P9100\nG80\n{code}.1 {words}").program == 9100


@pytest.mark.parametrize("number", [1, 99999])
def test_p_takes_1_to_99999(number: int) -> None:
    assert last_plan(f"G81 X9. E600. P{number}\nM30\nO{number}\nM99\n").program == number
    assert refusal("G81 X9. E600. P100000").name == "out-of-range"


@pytest.mark.parametrize(("word", "dresses"), [("D0", 0), ("D999", 999), ("", 0)])
def test_d_takes_0_to_999(word: str, dresses: int) -> None:
    events = cycles(f"{G82} P9100 {word}\nM30", block_budget=10_000)
    assert sum(isinstance(event, DressStart) for event in events) == dresses


@pytest.mark.parametrize(("word", "spark_out"), [("L0", 0), ("L999", 999), ("", 0)])
def test_l_takes_0_to_999(word: str, spark_out: int) -> None:
    assert len(strokes(cycles(f"{G82} {word}\nM30"))) == 2 + 1 + spark_out


@pytest.mark.parametrize("block", ["G81.1 X230. E12000.", G82.replace("G82", "G82.1"), G83.replace("G83", "G83.1")])
def test_every_cycle_has_a_form_with_pre_dress(block: str) -> None:
    events = cycles(f"{block} P9100\nM30")
    causes = [event.cause for event in events if isinstance(event, DressStart)]
    assert causes == ["pre"]
    first = next(event for event in events if isinstance(event, Motion))
    assert first.source.value == "dress"


def test_p_names_the_dress_program() -> None:
    events = cycles(f"{G82} D1 P7\nG82.1 Y-.04 P9100\nM30\nO7\nM99\n")
    assert [(event.program, event.cause) for event in events if isinstance(event, DressStart)] == [
        (7, "auto"),
        (9100, "pre"),
    ]


@pytest.mark.parametrize(("mode", "depth", "cross"), [("G90", -0.02, 20.0), ("G91", 4.98, 23.0)])
def test_depth_and_crossover_are_absolute_or_incremental(mode: str, depth: float, cross: float) -> None:
    plan = last_plan(f"G00 Y5. Z3.\n{mode} {G83.replace('J-.02', 'J-1.')} Q-.01 R5.\nM30")
    assert (plan.depth_target, plan.cross_end) == (depth, cross)
    found = plan.primary_pick, plan.secondary_pick, plan.primary_cross_pick, plan.secondary_cross_pick
    assert found == (1.0, 0.01, 10.0, 5.0)


def test_q_and_r_of_g83_are_the_secondary_picks_and_default_to_j_and_k() -> None:
    text = f"{G83} Q-.01 R5.\nG80\nG00 X-30. Y0 Z0\nG83 J-.005 K2.\nM30"
    first, second = (start.plan for start in plans(cycles(text)))
    assert (first.secondary_pick, first.secondary_cross_pick) == (0.01, 5.0)
    assert (second.secondary_pick, second.secondary_cross_pick) == (0.005, 2.0)
    # plunge J at the start of the crossover, then R, K, R, K; Q at its end
    assert story(cycles(f"{G83} Q-.01 R5.\nM30")).startswith("X230 y-0.02 X-30 z5 X230 z15 X-30 z20 X230")


def test_a_cycle_takes_over_at_once_at_the_secondary_point() -> None:
    at_secondary = "G82 X230. I-30. Y-.02 J-.01 F6. E12000.\n"
    assert story(cycles(at_secondary + "G82 Y-.03\nM30")) == "X230 y-0.01 X-30 y-0.02 X230 X-30 X230 y-0.03 X-30"
    assert story(cycles(at_secondary.replace("J-.01", "J-.02") + "G82 Y-.04\nM30")) == (
        "X230 y-0.02 X-30 X230 y-0.04 X-30"
    )


def test_words_of_a_new_cycle_act_from_its_first_stroke() -> None:
    made = strokes(cycles("G81 X230. I-30. E12000.\nG04 P.5\nG81 X100. I-10. E6000.\n", strokes=2))
    assert [(stroke.end[0], stroke.feed) for stroke in made] == [
        (230.0, 12000.0),
        (-30.0, 12000.0),
        (100.0, 6000.0),
        (-10.0, 6000.0),
    ]


def test_defaults_are_not_remembered() -> None:
    # neither the start point used for a missing I nor the F used for a missing E
    text = "F300.\nG81 X230.\nG80\nG00 X-5.\nF500.\nG81 X230."
    first, second = (start.plan for start in plans(cycles(text, strokes=1)))
    assert (first.secondary, first.feed) == (-30.0, 300.0)
    assert (second.secondary, second.feed) == (-5.0, 500.0)


def test_an_i_in_a_block_without_a_cycle_code_is_remembered() -> None:
    text = "G81 X230. I-30. E12000.\nI-60.\nG91 I5.\nG90 G80\nG81 X230."
    assert last_plan(text).secondary == -55.0


@pytest.mark.parametrize("block", ["G10 L2 P2 X99.", "G92 Z99.", "G04 X.1"])
def test_reversal_data_survive_other_blocks(block: str) -> None:
    assert story(cycles(f"G81 X230. I-30. E12000.\n{block}\n", strokes=2)) == "X230 X-30"


def test_reversal_data_survive_a_dress() -> None:
    dress = "\nM30\nO7\nG00 X99. E9.\nG01 X98. F60.\nM99\n"
    made = strokes(cycles(f"{G82} P7 D1" + dress))
    assert [(stroke.end[0], stroke.feed) for stroke in made] == [(230.0, 12000.0), (-30.0, 12000.0), (230.0, 12000.0)]


def test_the_motion_code_outlives_a_cycle() -> None:
    events = cycles(f"G01 Z1. F600.\n{G82}\nG80\nZ2.\nM30")
    lines = [event for event in events if isinstance(event, Motion) and event.source.value == "program"]
    assert [(type(line).__name__, line.end[2]) for line in lines] == [("Line", 1.0), ("Line", 2.0)]


def test_g00_and_g01_do_not_end_reciprocation() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG00 Z1.\nG01 Z2. F600.\nG80\nM30")
    assert story(events) == "X230"
    assert sum(isinstance(event, CycleEnd) for event in events) == 1


def test_a_check_reads_blocks_that_are_not_reached() -> None:
    report = check(read("G00 X1.\nM30\nG05\n"))
    assert [(error.name, error.line) for error in report.errors] == [("unknown-word", 3)]
