"""Dress intervals: the search finds them, and the written program counts and dresses exactly as promised."""

import json
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read, read_file
from grind_env.machine.grind import grind_file
from grind_env.machine.job.job_file import load_job
from grind_env.machine.script.block_settings import D
from grind_env.shop.dress_interval import DressInterval, intervals_between
from grind_env.shop.optimise.counter_writer import counting_of
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.result import Trade, Verdict, cheapest_by_time
from grind_env.shop.optimise.search_problem import Variation
from grind_env.shop.search_options import options_of
from grind_env.shop.sweep.study import LOTS
from grind_env.shop.trials import LotUse, lots_of, trials_of
from tests.command import Grind
from tests.examples import nightly
from tests.shop.programs import EXAMPLES, KNOWN, TWO_PLATES, known_job, varied

pytestmark = pytest.mark.usefixtures("few_lots")

PLATE = EXAMPLES / "plate_g82.nc"
RAIL = EXAMPLES / "rail_g83.nc"
RUNS = 13


def variation_dressing_every(path: Path, every: int) -> tuple[Variation, tuple[int, ...]]:
    """Return a variation of a program and its start point, with a dress due every `every` runs."""
    variation = varied(path, options_of(("D", "interval"), {"interval": (every, every)}), RUNS)
    return variation, variation.start


@given(every=st.integers(1, 9), dressing=st.lists(st.booleans(), min_size=1, max_size=5), runs=st.integers(1, 40))
def test_due_dresses_match_a_count_by_hand(every: int, dressing: list[bool], runs: int) -> None:
    by_runs, by_blocks, number = [], [], 0
    for run in range(1, runs + 1):
        by_runs.append([each and run % every == 0 for each in dressing])
        by_blocks.append([])
        for each in dressing:
            number += each
            by_blocks[-1].append(each and number % every == 0)
    blocks, run = np.tile(dressing, runs), np.repeat(np.arange(runs), len(dressing))
    assert DressInterval(every).due(blocks, run).tolist() == [each for row in by_runs for each in row]
    assert DressInterval(every, "block").due(blocks, run).tolist() == [each for row in by_blocks for each in row]


def test_intervals_are_named_by_parts_blocks_or_runs() -> None:
    assert [str(each) for each in intervals_between(1, 3)] == ["every part", "every 2 parts", "every 3 parts"]
    assert str(intervals_between(1, 2, blocks=6, parts=6)[0]) == "every run"
    several = [str(each) for each in intervals_between(1, 2, blocks=2, parts=2)]
    assert several == ["every run", "every 2 blocks", "every 3 blocks", "every 2 runs", "every 4 blocks"]


@pytest.mark.parametrize("path", [PLATE, nightly(RAIL)])
def test_the_program_dresses_once_its_counter_reaches_the_interval(path: Path) -> None:
    variation, point = variation_dressing_every(path, 3)
    programs, job = variation.read(point), load_job(path.with_suffix(".toml"))
    own = sum(block.plan.dresses for block in variation.once.simulation.blocks)
    for left, dresses in ((None, 0), (0.0, 0), (1.0, 0), (2.0, own), (57.0, own)):
        found = grind_file(programs, job, variables=None if left is None else {500: left})
        assert len(found.dresses) == dresses


@pytest.mark.nightly
def test_an_interval_of_three_blocks_is_counted_across_parts() -> None:
    """The rail dresses in N50 and N80: every third block is N50 of the second run and N80 of the third."""
    variation = varied(RAIL, options_of(("D", "interval"), {"interval": (1, 3), "D": (1, 1)}), runs=6)
    number = variation.choices.intervals.index(DressInterval(3, "block"))
    point = (*variation.start[:-1], number)
    said = trials_of(variation.read(point), variation.job, 6, [(0,)]).own[:, D].reshape(6, 2)
    assert said.tolist() == [[0, 0], [1, 0], [0, 1], [0, 0], [1, 0], [0, 1]]


def test_the_dress_counter_avoids_variables_of_the_program() -> None:
    programs = read(PLATE.read_text().replace("N60 M01", "#500=#[501]+1\nN60 M01"))
    counting = counting_of(DressInterval(2), programs, [])
    assert counting is not None and (counting.counter, counting.due) == (502, 503)
    assert counting.word(Decimal(2)) == "[2*#503]"


def test_cheapest_by_time_picks_the_cheapest_program_of_each_time() -> None:
    kept = [Trade(2.0, 10.0, 0.5), Trade(1.0, 10.1, 0.9), Trade(5.0, 50.0, 1.0)]
    assert cheapest_by_time([*kept, Trade(0.1, 10.0, 1.1)]) == (kept[1], kept[2])
    assert cheapest_by_time([]) == ()


QUICK = ("--parts", "4", "--budget", "1000s", "--vary", "E")


@pytest.mark.usefixtures("coarse_speeds")
def test_a_cost_constraint_is_met_when_time_is_minimised(tmp_path: Path, grind: Grind) -> None:
    known = *QUICK, "--job", known_job(tmp_path, "plate_g82")
    status, out, _ = grind("optimise", PLATE, *known, "--objective", "time", "--constraint", "cost=2.3", "--json")
    told = json.loads(out)
    assert status == 0 and told["objective"] == "seconds"
    (requirement,) = told["requirements"]
    assert requirement["kept"] and requirement["after"] <= 2.3 < requirement["before"]
    quickest = json.loads(grind("optimise", PLATE, *known, "--objective", "time", "--json")[1])
    by_name = {each["name"]: each["after"]["value"] for each in quickest["quantities"]}
    within = {each["name"]: each["after"]["value"] for each in told["quantities"]}
    assert by_name["seconds"] <= within["seconds"]


@pytest.mark.usefixtures("coarse_speeds")
def test_an_unreachable_constraint_is_reported(grind: Grind) -> None:
    status, out, _ = grind("optimise", PLATE, *QUICK, "--budget", "10 programs", "--constraint", "seconds=30")
    assert status == 4
    assert "no program tried keeps the limits within 30 s a part; the nearest one takes" in out


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--constraint", "minutes=2"), "--constraint: there is no 'minutes'; there are cost, seconds"),
        (("--objective", "speed"), "--objective: there is no 'speed'; there are cost, time"),
        (("--bounds", "interval=2..9"), "a dress every 2 to 9 parts; it may be from 1 to --parts, which is 4"),
        (("--constraint", "seconds=0"), "write a number above 0"),
    ],
)
def test_invalid_search_options_are_refused(options: tuple[str, ...], told: str, grind: Grind) -> None:
    status, _, err = grind("optimise", PLATE, "--parts", "4", *options)
    assert status == 2 and told in err


@pytest.mark.nightly
def test_identical_parts_share_their_words_unless_freed() -> None:
    alike, free = (varied(TWO_PLATES, options_of(free=each), runs=3) for each in (False, True))
    assert [each.places for each in alike.choices.variables] == ["N150, N250", "N170, N270", "N150, N250"]
    assert [each.places for each in free.choices.variables] == ["N150", "N170", "N250", "N270", "N150", "N250"]
    text = alike.with_words((*(count - 1 for count in alike.counts[:-1]), 0)).text
    assert text.count("E30000.") == 4 * 2 and text.count("D3") == 2 * 2


def test_sweep_writes_the_program_that_it_recommends(tmp_path: Path, grind: Grind) -> None:
    output = tmp_path / "better.nc"
    swept = ("--E", "12000..24000", "--dress-every", "1..4", "--parts", "8")
    status, out, _ = grind("sweep", PLATE, *swept, "--job", known_job(tmp_path, "plate_g82"), "--json", "-o", output)
    best = json.loads(out)["best"]
    trials = trials_of(read_file(output), load_job(PLATE.with_suffix(".toml")), 8, lots_of(1, LotUse.SWEEP, LOTS))
    assert status == 0
    assert trials.measure(trials.own[None]).cost.mean() == pytest.approx(best["cost"]["value"] - best["luck"], rel=1e-9)
    assert best["every"] > 1 and f"(DRESS EVERY {best['every']} PARTS" in output.read_text()


def test_sweep_writes_no_program_if_none_is_cheaper(tmp_path: Path, grind: Grind) -> None:
    output = tmp_path / "better.nc"
    status, _, err = grind("sweep", PLATE, "--E", "3000..4000", "--parts", "2", "-o", output)
    assert status == 3 and not output.exists()
    assert "no point keeps the limits and costs less than the program" in err


@pytest.mark.nightly
@pytest.mark.usefixtures("coarse_speeds")
def test_a_program_with_a_dress_counter_is_optimised_and_swept_again(tmp_path: Path, grind: Grind) -> None:
    """The program written by optimise reads its D from a variable."""
    program = tmp_path / "part.nc"
    variation, point = variation_dressing_every(PLATE, 3)
    program.write_bytes(variation.with_words(point).bytes())
    known = PLATE.with_suffix(".toml").read_text(encoding="utf-8") + KNOWN
    program.with_suffix(".toml").write_text(known, encoding="utf-8")
    once_more = find_words(program, parts=6, seconds=1000.0)
    assert once_more.verdict is Verdict.BETTER and "D#501" in once_more.after
    assert grind("sweep", program, "--dress-every", "1..3", "--parts", "6")[0] == 0
