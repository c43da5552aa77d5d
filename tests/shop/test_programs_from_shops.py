"""Programs of stations, macros, counters, loops of feed strokes and inches, written before what now grinds them.

Strokes and dresses are counted by hand from the text: a G82 makes a stroke, one for each pick and L more; a G83 begins
with a stroke and makes `ceil(way / K)` for each traverse. After an odd number of them the table goes on for one stroke,
from where the next cycle takes over.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from grind_env.control import read, read_file
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.file import load_job
from grind_env.shop.calls import optimise, sweep
from grind_env.shop.optimise import variation
from grind_env.shop.optimise.outcome import Verdict
from tests.command import Grind
from tests.examples import few
from tests.shop.programs import KNOWN

pytestmark = pytest.mark.usefixtures("few_lots")

FOLDER = Path(__file__).with_name("programs_from_shops")


class Shop(NamedTuple):
    """What follows from a program by hand: strokes and dresses of all parts, and parts that are ground."""

    strokes: int
    dresses: int
    parts: int
    given: Mapping[int, float] = {}


SHOPS = {
    # eight plates of 8 + 1 and 5 + 1 + 2 strokes; every fourth is dressed
    "counter_500": Shop(8 * (9 + 1 + 8), 2, 8, {500: 0.0}),
    # M98 leads the wheel over the diamond and dresses nothing, which is told
    "creep_feed_lug": Shop(2, 0, 1),
    "macro_two_fixtures_inch": Shop(10 + 1 + 2 + 10 + 1 + 3, 2, 2),
    "maschinenmesser": Shop((5 + 4 + 2) * 2, 0, 1),
    "punch_block_inch": Shop(6 * 2 + 2 * 2, 0, 1),
    # picks of 6 and 4 um in turn: twelve of them
    "row_of_plates": Shop(3 * (12 + 1 + 1 + 5 + 1 + 3), 0, 3),
    # four strokes beside each other, to and fro, in three layers
    "step_over_goto": Shop(3 * 4, 0, 1),
    "two_rows_g10": Shop(2 * (1 + (2 + 1) * 4 + 1 + 1 + (1 + 1 + 1) * 4), 2, 2),
    # J-.0025 is read as .002 mm: five picks
    "two_vices": Shop(2 * (6 + 1 + 5 + 1 + 2), 2, 2),
}
MADE_BETTER = ("counter_500", "macro_two_fixtures_inch", "maschinenmesser", "punch_block_inch", "row_of_plates")


def held(name: str) -> tuple[Path, Job]:
    path = FOLDER / f"{name}.nc"
    return path, replace(load_job(path.with_suffix(".toml")), variables=SHOPS[name].given)


@pytest.mark.parametrize("name", SHOPS)
def test_it_grinds_what_its_shop_counts(name: str) -> None:
    path, job = held(name)
    record, shop = grind(read_file(path), job), SHOPS[name]
    assert (record.strokes.size, len(record.dresses), record.parts.size) == shop[:3]
    assert not any(record.unjudged)
    stock = [each.part.stock for each in job.stations] or [job.part.stock] * shop.parts
    assert record.parts["S"] == pytest.approx(
        stock, rel=0.15, abs=0.015
    )  # the wheel gives way, and loses what its dress has loosened


def test_an_infeed_beside_a_table_that_reciprocates_grinds_the_stock() -> None:
    """G81 with eight infeeds of 10 um: how many strokes lie between them is a matter of time."""
    path = FOLDER / "g81_handwheel.nc"
    record = grind(read_file(path), load_job(path.with_suffix(".toml")))
    cutting = record.strokes["Z"]
    assert sorted({round(1000.0 * float(depth)) for depth in cutting if depth > 0.0})[-1] == 80
    assert record.parts["survival"][0] > 0.99


@pytest.mark.usefixtures("clock_of_looks")
@pytest.mark.parametrize("name", few(MADE_BETTER))
def test_what_is_promised_of_better_words_is_what_they_grind(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path, job = held(name)
    known = tmp_path / path.with_suffix(".toml").name
    known.write_text(path.with_suffix(".toml").read_text(encoding="utf-8") + KNOWN, encoding="utf-8")
    if name == "maschinenmesser":  # Ra is so near its limit that as many lots as a shop's own tell what keeps it
        monkeypatch.setattr(variation, "USUAL_RUNS", 50)
    found = optimise(path, known, parts=4, budget=6.0, variables=job.variables)
    assert found.verdict is Verdict.BETTER
    record = grind(read(found.after, path.name, path.parent), replace(job, variables=SHOPS[name].given))
    for quantity, column in (("cost", "total_cost"), ("seconds", "seconds"), ("Ra", "Ra")):
        assert found.quantity(quantity).expected[1] == pytest.approx(record.parts[column].mean(), rel=1e-9), quantity


def test_stations_to_which_a_program_comes_back_are_for_grind_run_alone() -> None:
    path, _ = held("two_vices")
    with pytest.raises(GrindError, match=r"strokes come back to station vice 1; .* that is for grind run alone"):
        sweep(path, parts=2)


@pytest.mark.parametrize("command", ["optimise", "sweep", "advise"])
def test_what_is_refused_for_many_runs_has_the_line_of_the_file(command: str, grind: Grind, tmp_path: Path) -> None:
    more = ["--state", tmp_path / "state.json"] if command == "advise" else []
    status, _, err = grind(command, FOLDER / "two_vices.nc", "--parts", 3, *more)
    assert status == 2 and err.startswith("grind: two_vices.nc:33: ")


def test_a_counter_without_a_value_names_the_remedy(grind: Grind) -> None:
    for command in (["run"], ["optimise"], ["sweep"], ["advise"]):
        status, _, err = grind(*command, FOLDER / "counter_500.nc")
        assert status == 2 and "counter_500.nc:7:6: #500 has no value" in err and "--set '#500=1'" in err
    assert json.loads(grind("run", FOLDER / "counter_500.nc", "--set", "#500=0", "--json")[1])["good_parts"] > 7.9
