"""Paramacros: variables, jumps, loops and calls in programs."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Control, execute, read
from tests.control.harness import COMMON, DRESS, cycles, ends, plans, refusal, run


def xs(text: str, **settings: object) -> list[float]:
    """Return the ends of the X moves of a program."""
    return [round(end[0], 9) for end in ends(text, **settings)]


def value(expression: str, **settings: object) -> float:
    (x,) = xs(f"#33={expression}\nG00 X[#33+1000]", **settings)
    return x - 1000.0


# ------------------------------------------------------------------------------------------------------ expressions

OPERATORS: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "MOD": math.fmod,
    "GT": lambda a, b: float(a > b),
    "LE": lambda a, b: float(a <= b),
}
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)),
    "SQRT": math.sqrt,
    "ABS": abs,
    "FIX": lambda a: float(math.trunc(a)),
    "FUP": lambda a: float(math.ceil(abs(a))) * (1.0 if a >= 0.0 else -1.0),
    "ROUND": lambda a: math.copysign(math.floor(abs(a) + 0.5), a),
    "EXP": math.exp,
    "LN": math.log,
}
Tree = tuple
trees = st.recursive(
    st.integers(-2000, 2000).map(lambda n: n / 8),
    lambda inner: (
        st.tuples(st.sampled_from(sorted(OPERATORS)), inner, inner)
        | st.tuples(st.sampled_from(sorted(FUNCTIONS)), inner)
    ),
    max_leaves=6,
)


def shown(tree: Tree | float) -> str:
    if isinstance(tree, float):
        return f"[{tree}]" if tree < 0.0 else f"{tree}"
    if len(tree) == 2:
        return f"{tree[0]}[{shown(tree[1])}]"
    return f"[{shown(tree[1])} {tree[0]} {shown(tree[2])}]"


def computed(tree: Tree | float) -> float:
    """Return the value in Python's arithmetic, with function arguments rounded to ten decimals."""
    if isinstance(tree, float):
        return tree
    given = [computed(each) for each in tree[1:]]
    if len(given) == 1:
        given = [round(given[0], 10)]
    if len(given) == 2 and tree[0] in ("GT", "LE") and 0.0 < abs(given[0] - given[1]) < 1e-6:
        raise ValueError  # the numbers differ only by rounding
    if tree[0] == "MOD" and abs(given[0]) > 1e12 * abs(given[1]):
        raise ValueError  # the quotient has more digits than the control, or than Python, can hold
    if tree[0] in ("FIX", "FUP", "ROUND", "MOD") and any(abs(8 * each - round(8 * each)) > 1e-12 for each in given):
        raise ValueError  # rounding may cross a step of the function
    found = OPERATORS[tree[0]](*given) if len(given) == 2 else FUNCTIONS[tree[0]](*given)
    if abs(found) > 1e6:
        raise ValueError
    return found


@given(trees)
def test_expressions_have_the_values_of_python_arithmetic(tree: Tree | float) -> None:
    try:
        expected = computed(tree)
    except (ValueError, ZeroDivisionError, OverflowError):
        return
    control = Control()
    text = f"#100={shown(tree)}\nIF [ABS[#100-[{expected:.12f}]] GT .00001] THEN #3000=1\nM30"
    for _ in execute(read(text), control):
        pass


flat = st.lists(st.tuples(st.sampled_from(["+", "-", "*", "MOD"]), st.integers(1, 99)), max_size=8)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("12/4*3", 9),  # the six of example 20.1
        ("12/[4*3]", 1),
        ("12+2/2", 13),
        ("[12+2]/2", 7),
        ("12-4+3", 11),
        ("12-[4+3]", 5),
        ("7-17 MOD 5*2", 3),
        ("7 AND 3 OR 8", 11),
        ("5 XOR 1", 4),
        ("1 OR 2 + 4", 7),
        ("[3 GT 2] AND [2 LT 1]", 0),
        ("[1/3*3 EQ 1]", 1),
        ("[.1+.2 EQ .3]", 1),
        ("COS[-90]", 0),
        ("TAN[45]", 1),
        ("ASIN[.5]", 30),
        ("ACOS[-1]", 180),
        ("ATAN[1]", 45),
        ("ATAN[1]/[-1]", 135),
        ("ATAN[-1]/[-1]", -135),
        ("ATAN[1]/2", 22.5),
        ("ROUND[-2.5]", -3),
        ("-SIN[30]*2", -1),
        ("sin[30]+Abs[-1]", 1.5),
    ],
)
def test_operators_and_functions_give_the_documented_values(expression: str, expected: float) -> None:
    assert value(expression) == pytest.approx(expected, abs=1e-3)


# -------------------------------------------------------------------------------------------------------- variables


def test_an_assignment_holds_until_the_next_one() -> None:
    assert xs("#1=5 (FIRST)\nN2 #[1+1]=#1*2\n/#100=#2\nX#1\nX#2\n#1=[#1+#100]\nX#1") == [5.0, 10.0, 15.0]


def test_a_vacant_variable_differs_from_zero() -> None:
    text = (
        "IF [#1 EQ #0] THEN #2=1\n#1=0\nIF [#1 NE #0] THEN #3=2\nX[#2+#3]\n#1=#0\n#4=#1\nIF [#4 EQ #0] THEN #2=7\nX#2"
    )
    assert xs(text) == [3.0, 7.0]


def test_every_word_takes_an_expression() -> None:
    text = "#1=2\n#2=15000\nG[18+1]\nG82 X[#1*50] I-#1 Y[-.03] J-[.03/3] Q-.01 L#1 F[300] E#2 P[9100] D[#1-1]\nM[30]"
    (start,) = plans(cycles(text))
    plan = start.plan
    assert (plan.primary, plan.secondary, plan.depth_target, plan.primary_pick) == (100.0, -2.0, -0.03, 0.01)
    assert (plan.spark_out, plan.feed, plan.pick_feed, plan.program, plan.dresses) == (2, 15000.0, 300.0, 9100, 1)


def test_a_program_reads_the_positions_of_its_axes() -> None:
    text = "G54 G00 X20. Z5.\n#1=#5001\n#2=#5021\n#3=#5043\nX[#1+1]\nX[#2-#1]\nX#3"
    assert xs(text, work_offsets={"G54": (100.0, 0.0, 0.0)}) == [120.0, 121.0, 200.0, 105.0]
    assert xs("G70 G08 X2.\n#1=#5041\nG71 G07 X#1") == [25.4, 2.0]  # inches, as a diameter


def test_a_program_reads_and_writes_offsets_and_radii() -> None:
    assert xs("#1=#5221\n#5221=#1+5\nX0\n#5201=2\nX0\nG55 X0\n#5241=#5241-1\nX0") == [5.0, 7.0, 2.0, 1.0]
    assert xs("X#2033\n#2033=#2033-.5\nX#2033", radii={33: 100.0}) == [100.0, 99.5]
    assert xs("G70\n#2001=1\nG71\nX#2001") == [25.4]


# ---------------------------------------------------------------------------------------------------- jumps and loops


def test_goto_finds_the_next_matching_block_or_else_the_first() -> None:
    assert xs("GOTO 20\nN10 X1\nM30\nN20 X2\nGOTO 10\nN20 X3") == [2.0, 1.0]
    assert xs("N1 X1\nIF [#5041 GT .5] GOTO#1\nN2 X2\nN3 X3", variables={1: 3}) == [1.0, 3.0]


def test_a_loop_repeats_while_its_condition_holds() -> None:
    assert xs("#1=1\nWHILE [#1 LE 3] DO 1\nX#1\n#1=#1+1\nEND 1\nX9") == [1.0, 2.0, 3.0, 9.0]
    assert xs("while[1gt2]do2\nX1\nend2\nX9") == [9.0]
    nested = "#1=0\nWHILE[#1LT2]DO1\n#2=0\nWHILE[#2LT2]DO2\nX[10*#1+#2+1]\n#2=#2+1\nEND2\n#1=#1+1\nEND1"
    assert xs(nested) == [1.0, 2.0, 11.0, 12.0]


def test_goto_leaves_a_loop_which_can_start_again() -> None:
    text = "#1=0\nN1 #1=#1+1\nDO 1\nX#1\nIF [#1 LT 3] GOTO 1\nGOTO 2\nEND 1\nN2 X9"
    assert xs(text) == [1.0, 2.0, 3.0, 9.0]


@pytest.mark.parametrize(
    "text",
    [
        "WHILE [1 EQ 1] DO 1\nEND 1",
        "DO 1\n#1=1\nEND 1",
        "N1 GOTO 1",
        "N1 #1=0\nGOTO 1",
        "DO 1\nM98 P5\nEND 1\nO5\nG91 X.1\nM99",
        "DO 1\nG65 P5\nEND 1\nO5\nM99",
        "#1=0\nN1 #1=1-#1\nGOTO 1",
        "#1=0\nDO 1\n#1=[#1+1] MOD 37\nEND 1",
    ],
)
def test_an_endless_loop_is_refused_with_its_line(text: str) -> None:
    error = refusal(text)
    assert error.name == "block-budget" and "goes round here without end" in error.message
    assert error.line is not None and any(word in text.split("\n")[error.line - 1] for word in ("END 1", "GOTO 1"))


def test_a_loop_that_repeats_earlier_values_may_end() -> None:
    # the inner loop starts with the same values in every round of the outer loop
    inner = "#1=0\nWHILE [#1 LT 2] DO 2\n#1=#1+1\nG91 X.1\nEND 2\n"
    assert len(cycles(f"#2=0\nWHILE [#2 LT 3] DO 1\n{inner}#2=#2+1\nEND 1\nM30")) > 6
    assert len(cycles("#100=0\nN1 G91 X.1\n#100=#100+1\nIF [#100 LT 3] GOTO 1\nM30")) > 2


def test_a_jump_does_not_reread_a_long_program_from_its_start() -> None:
    filling = "(A)\n" * 15_000  # reading it anew at every jump would take a quarter of an hour
    loop = "#1=0\nDO 1\n#1=#1+1\nEND 1"
    assert refusal(f"{filling}{loop}\n{filling[:400]}", block_budget=60_000).name == "block-budget"


# ------------------------------------------------------------------------------------------------------------- calls


def test_g65_passes_its_arguments() -> None:
    letters = "A1 B2 C3 I4 J5 K6 D7 E8 F9 H11 M13 Q17 R18 S19 T20 U21 V22 W23 X24 Y25 Z26"
    body = "\n".join(f"X#{letter[1:]}" for letter in letters.split())
    text = f"G65 P8 {letters}\nM30\nO8\n{body}\nM99"
    assert xs(text) == [float(letter[1:]) for letter in letters.split()]


def test_local_variables_belong_to_one_level_and_common_ones_to_all() -> None:
    text = "#1=1\n#100=5\nG65 P8 A7 L2\nX#1\nX#100\nM98 P9\nX#2\nM30\n"
    text += "O8\n#1=#1+1\n#100=#100+#1\nX#1\nM99\nO9\n#2=#1*3\nM99"
    assert xs(text) == [8.0, 1.0, 21.0, 3.0]


def test_a_level_keeps_its_local_variables_from_call_to_call() -> None:
    assert xs("G65 P8 A2\nG65 P9\nM30\nO8\n#5=#1*2\nM99\nO9\nX#5\nM99") == [4.0]  # 20-13


def test_macros_and_subprograms_nest_together() -> None:
    chain = "M98 P1\nM30\n" + "".join(f"O{k}\n{'G65' if k % 2 else 'M98'} P{k + 1}\nM99\n" for k in range(1, 8))
    assert xs(chain + "O8\nX8\nM99") == [8.0]
    assert refusal(chain + "O8\nM98 P9\nM99\nO9\nX8\nM99").name == "nesting"


# ------------------------------------------------------------------------------------------------- G52 and G53


def test_g52_shifts_every_work_system_until_it_is_cancelled() -> None:
    text = "G52 X10.\nX1\nG55 X1\nG91 G52 X5.\nG90 X1\nG52 X0\nX1"
    assert xs(text, work_offsets={"G55": (100.0, 0.0, 0.0)}) == [11.0, 111.0, 106.0, 101.0]


def test_g53_moves_to_machine_coordinates_once() -> None:
    text = "G92 X7.\nG53 G00 X3.\nX3\nF100. G53 G01 X2.\nX2."
    assert xs(text, start=(5.0, 0.0, 0.0)) == [3.0, 1.0, 2.0, 0.0]


# -------------------------------------------------------------------------------------------- compensation and loops


def contour(text: str) -> list[tuple[float, ...]]:
    return [tuple(round(value, 6) for value in end) for end in ends(f"G17 G71 F500. T1\n{text}", radius=2.0)]


def test_compensation_looks_ahead_along_jumps_and_loops() -> None:
    written = "G41 G01 X10. Y0\nX20.\nX20. Y10.\nX30.\nX30. Y20.\nX40.\nG40 X50. Y50.\nM30"
    looped = (
        "G41 G01 X10. Y0\n#1=0\nWHILE [#1 LT 2] DO 1\nX[20+10*#1]\nY[10+10*#1]\n#1=#1+1\nEND 1\n"
        "GOTO 5\nX0\nN5 X40.\nG40 X50. Y50.\nM30"
    )
    called = "G41 G01 X10. Y0\nG65 P8 A20 B10\nG65 P8 A30 B20\nX40.\nG40 X50. Y50.\nM30\nO8\nX#1\nY#2\nM99"
    assert contour(looped) == contour(written)
    assert contour(called) == contour(written)


# ------------------------------------------------------------------------------------------------------ messages


@pytest.mark.parametrize("text", ["G81 X10.E15000.", "G81 X10E150", "G81 X10. E2", "G81 X10.E#1"])
def test_an_e_word_directly_after_a_number_is_not_an_exponent(text: str) -> None:
    run(f"#1=200\nG00 Z1\nG19\n{text}")


def test_a_clamped_feed_is_reported_with_the_unit_probably_meant() -> None:
    events = run(COMMON + "G70\nG82 X8. I-1. Y-.001 J-.001 F20. E9000.\nG71 G80\nG01 X5. F70000.\nM30" + DRESS)
    inch, metric = (event.text for event in events if type(event).__name__ == "Message")
    assert inch.startswith("line 3: E9000. is 228600 mm/min and clamped to 60000; ") and "write E354.3 if" in inch
    assert metric == "line 5: F70000. is 70000 mm/min and clamped to 60000"
