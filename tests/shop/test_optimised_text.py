"""Text of an optimised program: only the intended words change, and they take the chosen values."""

import re
from decimal import Decimal
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.machine.script.block_settings import DRESS_SECONDS, own_settings
from grind_env.machine.script.script import script_of
from grind_env.shop.optimise.search_problem import Variation
from grind_env.shop.optimise.variables import COLUMNS
from grind_env.shop.optimise.word_editing import like
from grind_env.shop.search_options import OptionError, options_of
from tests.examples import examples, few
from tests.shop.programs import EXAMPLES, JOB, PROGRAMS, varied, write

pytestmark = pytest.mark.usefixtures("nothing_compiled")

ALL = "E,D,J,L,lead,depth,passes"
COMMENT = re.compile(r" \([^()]*(?: TO | ADDED)[^()]*\)")
VARIED = re.compile(r"[ \t]?[EDJLFYedjlfy][+-]?[0-9.]+")


@cache
def asked_for(name: str, folder: Path, vary: str = ALL) -> Variation:
    return varied(write(folder, name), options_of(vary.split(","), untried=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("programs")


@pytest.mark.parametrize("name", few(PROGRAMS, 2))
@examples(15)
@given(data=st.data())
def test_only_intended_words_change_and_take_the_chosen_values(name: str, folder: Path, data: st.DataObject) -> None:
    asked = asked_for(name, folder, "E,D,J,L,lead,depth")
    variables = asked.choices.variables
    point = tuple(
        data.draw(st.integers(0, len(each.levels) - 1), label=f"{each.place} {each.name}") for each in variables
    )
    text = asked.with_words((*point, 0))

    old, new = PROGRAMS[name].split(b"\n"), text.bytes().split(b"\n")
    for before, after in zip(old, new, strict=True):
        assert before.endswith(b"\r") == after.endswith(b"\r")
        said = COMMENT.findall(after.decode())
        stripped = COMMENT.sub("", after.decode())
        assert bool(said) == (stripped != before.decode())
        assert VARIED.sub("", stripped) == VARIED.sub("", before.decode())

    script = script_of(read(text.text), asked.job)
    said = np.array([own_settings(block.plan, block.dress_plan) for block in script.blocks])
    first = script_of(read(asked.text.text), asked.job)
    meant = np.array([own_settings(block.plan, block.dress_plan) for block in first.blocks])
    for variable, number in zip(variables, point, strict=True):
        meant[list(variable.blocks), COLUMNS[variable.name]] = variable.settings[number]
    columns = [k for k in range(meant.shape[1]) if k != DRESS_SECONDS]
    assert said[:, columns] == pytest.approx(meant[:, columns], rel=1e-9)


@pytest.mark.parametrize("name", few(["plate", "lower", "loop"]))
def test_dress_passes_are_removed_or_repeated(name: str, folder: Path) -> None:
    asked = asked_for(name, folder, "passes")
    (passes,) = asked.choices.variables
    assert [int(level) for level in passes.levels] == [1, 2, 4]
    for number, level in enumerate(passes.levels):
        script = script_of(read(asked.with_words((number, 0)).text), asked.job)
        dress = script.blocks[0].dress_plan
        assert dress is not None
        assert (dress.passes, dress.depth, dress.feed) == (level, pytest.approx(0.02), pytest.approx(191.0 / 60.0))


def test_passes_of_absolute_infeeds_are_not_repeated(folder: Path) -> None:
    (passes,) = asked_for("inch", folder, "passes").choices.variables
    assert [int(level) for level in passes.levels] == [1, 2]


def test_one_value_holds_for_all_calls_of_a_subprogram(folder: Path) -> None:
    assert [each.blocks for each in asked_for("loop", folder, "E,D").choices.variables] == [(0, 1, 2, 3)] * 2


def test_a_fixed_block_is_not_varied_and_an_unknown_one_is_refused() -> None:
    path = EXAMPLES / "plate_g82.nc"
    found = varied(path, options_of(("E", "D"), fixed=[50], untried=True))
    assert {each.place for each in found.choices.variables} == {"N70"}
    with pytest.raises(OptionError, match=r"N51 is no cycle block .* there are N50, N70"):
        varied(path, options_of(fixed=[51]))


def test_an_expression_is_not_varied_and_a_remark_gives_the_remedy(tmp_path: Path) -> None:
    path = write(tmp_path, "plate")
    path.write_text(PROGRAMS["plate"].decode().replace("E9000.", "E[9000.]"), encoding="utf-8")
    found = varied(path, options_of(untried=True))
    assert [(each.name, each.place) for each in found.choices.variables] == [("E", "N50"), ("D", "N50")]
    (remark,) = found.choices.remarks
    assert remark.startswith("N70: E[9000.] is kept as it is; write a number there")


@pytest.mark.parametrize(
    "value, written, text",
    [
        ("24000", "15000.", "24000."),
        ("24000", "15000", "24000"),
        ("0.012", "-.01", "-.012"),
        ("0.012", "-0.01", "-0.012"),
        ("590.5", "354.33", "590.5"),
        ("595", "590.55", "595."),
        ("0", "1", "0"),
    ],
)
def test_new_numbers_are_formatted_like_the_old_ones(value: str, written: str, text: str) -> None:
    assert like(Decimal(value), written) == text


def test_passes_but_not_depth_of_a_self_advancing_dresser_are_varied(tmp_path: Path) -> None:
    plate = (EXAMPLES / "plate_g82.nc").read_text(encoding="utf-8")
    path = tmp_path / "plate.nc"
    dress = (
        "O9100\nG71 G90 G94\nG00 Y20.\nX-120. Z-40.\nG00 Y9.98\nG91 G01 Z35. F191.\nZ-35. F191.\nG90 G00 Y20.\nM99\n"
    )
    path.write_text(plate[: plate.index("O9100")] + dress, encoding="utf-8")
    path.with_suffix(".toml").write_text(JOB, encoding="utf-8")
    asked = varied(path, options_of(("passes", "depth"), {"passes": (2, 4)}, untried=True))
    (passes,) = asked.choices.variables
    assert (passes.name, [int(level) for level in passes.levels]) == ("passes", [2, 4])
    assert "depth of O9100 is kept as it is: it has no infeed, for its dresser advances by itself" in " ".join(
        asked.choices.remarks
    )
    changed = script_of(read(asked.with_words((1, 0)).text), asked.job).blocks[0].dress_plan
    assert (changed.passes, changed.depth) == (4, 0.02)
