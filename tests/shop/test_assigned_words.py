"""Words that read a variable are varied through the number assigned to this variable."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read, read_file
from grind_env.files import read_bytes
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.uncertainty import CERTAIN
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.result import Optimised
from grind_env.shop.optimise.search_problem import Variation, variation_of
from grind_env.shop.optimise.word_editing import text_of
from grind_env.shop.search_options import OptionError, options_of
from grind_env.shop.trials import LotUse, lots_of, trials_of
from tests.examples import examples
from tests.shop.programs import DRESS, EXAMPLES, FEEDS, INCH, JOB, KNOWN, PLATE

pytestmark = pytest.mark.usefixtures("few_lots")

SHOP = replace(load_job(EXAMPLES / "plate_g82.toml"), uncertainty=CERTAIN)
#: the plate with four kinds of words read from variables
ASSIGNED = (
    PLATE.replace("N30 G00 X-30.", "#101 = 15000. (ROUGH)\n N31 #102=9000\n#103=+1(DRESSES)\n#104=-.01\nN30 G00 X-30.")
    .replace("E15000.", "E#101")
    .replace("E9000.", "E[#102]")
    .replace("D1", "D#103")
    .replace("J-.01", "J #104")
)


def asked_for(text: str, tmp_path: Path, vary: str | None = None, fix: tuple[int, ...] = ()) -> Variation:
    path = tmp_path / "part.nc"
    path.write_bytes(text.encode("latin-1"))
    options = options_of(vary and vary.split(","), fixed=fix, untried=True)
    return variation_of(read_file(path), text_of(read_bytes(path)), SHOP, options, 2, 1)


def found_in(text: str, tmp_path: Path, **asked: object) -> Optimised:
    path = tmp_path / "part.nc"
    path.write_text(text, encoding="utf-8")
    path.with_suffix(".toml").write_text(JOB + KNOWN, encoding="utf-8")
    return find_words(path, parts=3, seconds=1000.0, **asked)  # type: ignore[arg-type]


@pytest.mark.nightly
def test_a_program_with_variables_is_optimised_like_its_twin_with_numbers(tmp_path: Path) -> None:
    options = options_of(("E", "D", "J"), bounds={"D": (0, 1)})
    theirs, mine = (found_in(text, tmp_path, options=options) for text in (PLATE, ASSIGNED))
    assert [(word.name, word.before, word.after) for word in mine.words] == [
        (word.name, word.before, word.after) for word in theirs.words
    ]
    assert [word.place for word in mine.words] == [
        "#101, line 7",
        "#102, line 8",
        "#103, line 9",
        "N70",
        "#104, line 10",
        "N70",
    ]
    for name in ("cost", "seconds", "Ra"):
        assert mine.quantity(name).expected[1] == pytest.approx(theirs.quantity(name).expected[1], rel=1e-12)
    part = grind(read(mine.after), SHOP).parts[0]
    assert mine.quantity("cost").expected[1] == pytest.approx(part["total_cost"], rel=1e-9)


def test_only_the_assigned_number_changes(tmp_path: Path) -> None:
    text = ASSIGNED.replace("\n", "\r\n").replace("(ROUGH)", "(#101=7, GRÖSSE)")
    asked = asked_for(text, tmp_path, "E,D,J")
    point = [*asked.start]
    for number in (0, 1, 4):
        point[number] -= 1
    rough, finish, _, _, pick, _ = asked.choices.variables
    new = asked.with_words(tuple(point)).bytes().decode("latin-1").split("\r\n")
    old = text.split("\r\n")
    changed = {line: new[line] for line in range(len(old)) if new[line] != old[line]}
    assert [*changed.values()] == [
        "#101 = 14900. (#101=7, GRÖSSE) (#101=15000. TO #101=14900.)",
        " N31 #102=8900 (#102=9000 TO #102=8900)",
        f"#104=-{pick.levels[pick.start - 1]:f} (#104=-.01 TO #104=-.009)".replace("=-0.", "=-."),
    ]
    assert (rough.place, finish.place) == ("#101, line 7", "#102, line 8")


def test_blocks_that_read_one_variable_are_varied_together(tmp_path: Path) -> None:
    text = PLATE.replace("N30", "#101=12000\nN30", 1).replace("E15000.", "E#101").replace("E9000.", "E#101")
    asked = asked_for(text, tmp_path, "E")
    (speed,) = asked.choices.variables
    assert (speed.blocks, speed.place, speed.own) == ((0, 1), "#101, line 7", 12_000)
    found = found_in(text, tmp_path, options=options_of(["E"]))
    cost = grind(read(found.after), SHOP).parts["total_cost"][0]
    assert found.quantity("cost").expected[1] == pytest.approx(cost, rel=1e-9)
    new = found.after.splitlines()
    assert sum(old != line for old, line in zip(text.splitlines(), new, strict=True)) == 1
    assert [(word.name, word.place) for word in found.words] == [("E", "#101, line 7")]


def test_each_assignment_of_a_variable_is_varied_separately(tmp_path: Path) -> None:
    text = (
        PLATE.replace("N30", "#1=15000.\nN30", 1)
        .replace("E15000.", "E#1")
        .replace("N60 M01", "N59 #1=9000.\nN60 M01")
        .replace("E9000.", "E#1")
    )
    asked = asked_for(text, tmp_path, "E")
    assert [(each.blocks, each.own, each.place) for each in asked.choices.variables] == [
        ((0,), 15_000, "#1, line 7"),
        ((1,), 9000, "#1, line 12"),
    ]


def test_a_word_taken_over_from_the_block_before_is_varied_with_its_variable(tmp_path: Path) -> None:
    text = PLATE.replace("N30", "#101=12000\nN30", 1).replace("E15000.", "E#101").replace(" E9000.", "")
    asked = asked_for(text, tmp_path)
    assert [each.blocks for each in asked.choices.variables if each.name == "E"] == [(0, 1)]


def test_variables_in_inch_programs_and_feed_moves_are_varied(tmp_path: Path) -> None:
    inch = asked_for(INCH.replace("N30", "#1=590.55\nN30", 1).replace("E590.55", "E#1"), tmp_path, "E")
    assert [float(each.own * each.unit) for each in inch.choices.variables] == pytest.approx(
        [15_000.0, 9000.0], rel=1e-4
    )
    strokes = asked_for(FEEDS.replace("N3 ", "#1=9000\nN3 ", 1).replace("F9000.", "F#1") + DRESS, tmp_path)
    literal = asked_for(FEEDS + DRESS, tmp_path)
    assert [each.own for each in strokes.choices.variables] == [each.own for each in literal.choices.variables]


KEPT = {
    "#101=6000*2": "in line 7, where it is worked out",
    "#101=12000\nGOTO 25\nN25 #101=11000": "give it a variable of its own, for this one is assigned in lines 7, 9",
    "#101=12000\nG04 P[#101/10000]": "give it a variable of its own, for this one is read in line 8, too",
    "#101=12000\n#105=101\n#106=#[#105]": "name variables by their numbers, for one whose number is worked out",
    "IF [1 EQ 1] THEN #101=12000": "in line 7, where it is worked out",
}


@pytest.mark.parametrize(("assigned", "remedy"), KEPT.items())
def test_a_remark_gives_the_remedy_for_a_word_without_its_own_number(
    assigned: str, remedy: str, tmp_path: Path
) -> None:
    text = PLATE.replace("N30", f"{assigned}\nN30", 1).replace("E15000.", "E#101")
    asked = asked_for(text, tmp_path)
    (remark,) = asked.choices.remarks
    assert remark.startswith(f"N50: E#101 is kept as it is; write a number there, or {remedy}")
    assert all("#101" not in each.place for each in asked.choices.variables)


def test_a_fixed_block_fixes_the_variable_it_shares(tmp_path: Path) -> None:
    text = PLATE.replace("N30", "#101=12000\nN30", 1).replace("E15000.", "E#101").replace("E9000.", "E#101")
    asked = asked_for(text, tmp_path, fix=(70,))
    assert [each.name for each in asked.choices.variables] == ["D"]
    assert asked.choices.remarks == (
        "N50: E#101 is kept as it is; write a number there, or give it a variable of its own, for N70, which is kept, "
        "reads this one, too",
    )


def test_a_variable_read_by_two_kinds_of_words_is_not_varied(tmp_path: Path) -> None:
    text = PLATE.replace("N30", "#101=1\nN30", 1).replace("D1", "D#101").replace("L4", "L#101")
    with pytest.raises(OptionError, match=r"N50: D#101 is kept .* this one is read in line 14, too"):
        asked_for(text, tmp_path, "D", fix=(70,))


def test_a_dress_interval_is_written_into_the_assignment_of_D(tmp_path: Path) -> None:
    text = PLATE.replace("N30", "#103=1\nN30", 1).replace("D1", "D#103")
    asked = asked_for(text, tmp_path, "D,interval")
    (executions, *_) = asked.choices.variables
    assert executions.place == "#103, line 7"
    point = (1, *(0 for _ in asked.counts[2:]), len(asked.choices.intervals) - 1)
    new = asked.with_words(point)
    assert "#103=#501 (#103=1 TO #103=#501)" in new.text
    trials = trials_of(read(new.text), SHOP, 2, lots_of(1, LotUse.SEARCH, 2))
    assert trials.own[:, 1].tolist() == asked.settings(asked.base.own, np.array([point]))[0, :, 1].tolist()
    assert trials.own[:, 1].tolist() == [0, 0, 1, 0]


def test_a_variable_set_from_outside_is_not_varied(tmp_path: Path) -> None:
    text = PLATE.replace("E15000.", "E#101")
    found = found_in(text, tmp_path, variables={101: 12_000.0})
    assert {word.place for word in found.words} == {"N50", "N70", "dresses"}
    assert (
        "N50: E#101 is kept as it is; write a number there, or assign one in the program, for #101 has a value from "
        in (found.remarks[0])
    )


LEVELS = {"E": ("9000.", "12000"), "J": ("-.01", "-.02"), "L": ("1", "3"), "D": ("0", "1")}
HEAD, TAIL = PLATE[: PLATE.index("(ROUGH")], PLATE[PLATE.index("N80") :]


@st.composite
def with_variables(draw: st.DrawFn) -> str:
    """Draw a program with some words read from variables; blocks between may assign or read these variables."""
    lines, held = list[str](), dict[int, str]()

    def word(letter: str) -> str:
        value = draw(st.sampled_from(LEVELS[letter]))
        if draw(st.booleans()):
            return f" {letter}{value}"
        known = [number for number, of in held.items() if of == letter]
        number = draw(st.sampled_from([*known, 101 + len(held)]))
        if number not in known or draw(st.integers(0, 3)) == 0:
            form = draw(st.sampled_from(["#{}={}", " N7 # {} = {}(SET)", "IF [1 EQ 1] THEN #{}={}"]))
            lines.append(form.format(number, value))
            held[number] = letter
        return f" {letter}" + draw(st.sampled_from(["#{}", "[#{}]"])).format(number)

    for k in range(draw(st.integers(1, 4))):
        words = [word(letter) for letter in "EJLD" if k == 0 or letter == "D" or draw(st.booleans())]
        way = "X230. I-30. F60. P9100" if k == 0 else ""
        lines.append(f"N{50 + k} G82 {way} Y-{0.04 * (k + 1):.2f}{''.join(words)}")
        if held and draw(st.integers(0, 5)) == 0:
            lines.append(f"G04 P[ABS[#{draw(st.sampled_from([*held]))}]]")
    looped = ["DO 1", "IF [1 EQ 1] GOTO 79", "END 1", "N79"] if draw(st.booleans()) else []
    return "\n".join([HEAD, *looped[:1], *lines, *looped[1:], TAIL])


@pytest.mark.nightly
@examples(15)
@given(text=with_variables(), data=st.data())
def test_the_written_program_has_the_chosen_settings_and_cost(text: str, data: st.DataObject) -> None:
    programs = read(text, "part.nc")
    try:
        asked = variation_of(
            programs, text_of(text.encode()), SHOP, options_of((*"EDJL", "interval"), untried=True), 1, 1
        )
    except OptionError:
        return
    point = tuple(data.draw(st.integers(0, count - 1)) for count in asked.counts)
    new = asked.with_words(point)
    trials = trials_of(read(new.text, "part.nc"), SHOP, 1, lots_of(1, LotUse.SEARCH, 2))
    other = asked.settings(asked.base.own, np.array([point]))
    assert trials.own[:, :4] == pytest.approx(other[0, :, :4], rel=1e-9)
    mine = asked.measure(asked.base.with_lots(lots_of(1, LotUse.SEARCH, 2)), [point])
    assert trials.measure(trials.own[None]).cost == pytest.approx(mine.cost, rel=1e-9)
