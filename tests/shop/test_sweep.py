"""`grind sweep`: every point costs the same as the program written out, and the valley is correct."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read, read_file
from grind_env.envs.job.repeated_program import repeated
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.machine.script import block_settings
from grind_env.policies.score_statistics import Interval
from grind_env.shop.possible_machines import fleet_of
from grind_env.shop.sweep import study
from grind_env.shop.sweep.figure import LINES, draw_sweep
from grind_env.shop.sweep.study import LOTS, Sweep, SweepError, SweepRanges, cheapest, judgement_trials, sweep
from grind_env.shop.sweep.table import sentences, tables_of
from grind_env.shop.trials import LotUse, Trials, lots_of, most_risk, risk, trials_of
from tests.command import Grind
from tests.examples import few
from tests.shop.programs import EXAMPLES, INCH, PLATE, known_job

PARTS = 6


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    ranges = SweepRanges(E=(12_000.0, 20_000.0), every=(1, 4), lead=(0.08, 0.16))
    job = known_job(tmp_path_factory.mktemp("job"), "plate_g82")
    return sweep(EXAMPLES / "plate_g82.nc", job, ranges, parts=PARTS)


def test_a_dress_every_third_part_costs_the_same_as_written_out(found: Sweep) -> None:
    job, every = load_job(EXAMPLES / "plate_g82.toml"), 3
    point = next(each for each in found.speeds if each.every == every and pytest.approx(12_000.0) == each.E)
    text = PLATE.replace("E15000.", "E12000.").replace("E9000.", "E7200.")
    lines = "\n".join(source.text for program in [*repeated(read(text), PARTS)][:1] for source in program.blocks)
    parts = lines.split("D1")
    written = parts[0] + "".join(f"D{int((k + 1) % every == 0)}{rest}" for k, rest in enumerate(parts[1:]))
    programs = read(f"{written}\n{text[text.index('O9100') :]}")
    trials = trials_of(programs, job, 1, lots_of(1, LotUse.SWEEP, LOTS))
    assert len(parts) == PARTS + 1
    assert trials.measure(trials.own[None]).cost.mean() == pytest.approx(point.cost.value, rel=1e-9)


def test_lines_differ_by_dash_or_marker(found: Sweep) -> None:
    pytest.importorskip("matplotlib")
    assert len({look[1:] for look in LINES}) == len(LINES)
    several = 0
    for axes in draw_sweep(found).axes:
        lines = [line for line in axes.lines if line.get_label()[0] != "_" and len(np.asarray(line.get_xdata())) > 2]
        looks = {(line.get_linestyle(), line.get_marker()) for line in lines}
        assert len(looks) == len(lines)
        several += len(lines) > 1
    assert several == 4


def test_a_swept_lead_costs_the_same_as_a_dress_program_with_this_lead(tmp_path: Path) -> None:
    job = load_job(EXAMPLES / "plate_g82.toml")
    turns = 60_000.0 * 30.0 / (3.141592653589793 * 300.0)
    feed = round(0.1 * turns)
    ranges = SweepRanges(lead=(feed / turns, feed / turns * 1.5))
    point = sweep(EXAMPLES / "plate_g82.nc", known_job(tmp_path, "plate_g82"), ranges, parts=2).dresses[0]
    trials = trials_of(read(PLATE.replace("F191.", f"F{feed}.")), job, 2, lots_of(1, LotUse.SWEEP, LOTS))
    assert trials.measure(trials.own[None]).cost.mean() == pytest.approx(point.cost.value, rel=1e-6)


def test_the_valley_spans_the_intervals_within_2_percent_of_the_best(found: Sweep) -> None:
    first, last = found.valley
    best = cheapest(found.intervals)
    assert first <= best.every <= last
    costs = {point.every: point.cost.value for point in found.intervals}
    assert all(costs[every] <= 1.02 * best.cost.value for every in range(first, last + 1))
    assert all(costs[every] > 1.02 * best.cost.value for every in (first - 1, last + 1) if every in costs)


def test_a_point_that_exceeds_a_limit_on_new_lots_is_not_the_best(
    found: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def on_a_machine_with_more_force(trials: Trials, *rest: object) -> Trials:
        own = judgement_trials(trials, *rest)
        job = own.simulation.job
        harder = {"ploughing_pressure": 5.0 * job.part.material.ploughing_pressure}
        return own.with_lots(own.seeds, [with_entries(job, {"material": harder})])

    monkeypatch.setattr(study, "judgement_trials", on_a_machine_with_more_force)
    ranges = SweepRanges(E=(12_000.0, 20_000.0), every=(1, 4))
    judged = sweep(EXAMPLES / "plate_g82.nc", known_job(tmp_path, "plate_g82"), ranges, parts=PARTS)
    best = cheapest([found.own, *found.speeds])
    again = next(each for each in judged.speeds if (each.E, each.every) == (best.E, best.every))
    assert best.keeps_limits and again.cost.value > best.cost.value - best.luck and not again.keeps_limits
    assert judged.best == judged.own


@pytest.mark.nightly
def test_the_risk_of_the_best_point_holds_on_other_machines(tmp_path: Path) -> None:
    program, job = EXAMPLES / "plate_g82.nc", load_job(EXAMPLES / "plate_g82.toml")
    safe = []
    for seed in range(1, 7):
        best = sweep(program, job, SweepRanges(E=(15_000.0, 25_000.0), every=(1, 4)), parts=50, seed=seed).best
        once = trials_of(read_file(program), job, 50, ())
        fleet = fleet_of(once, seed + 50, untried=False)
        assert fleet is not None
        trials = fleet.trials_for(once, LotUse.JUDGEMENT, lots_of(seed + 50, LotUse.JUDGEMENT, 256))
        table, due = trials.own.copy(), trials.own[:, block_settings.D] > 0.0
        table[:, block_settings.E] *= best.E / table[0, block_settings.E]
        if best.every:
            table[due, block_settings.D] = [(run + 1) % best.every == 0 for run in range(due.sum())]
        measured, old = (trials.measure(each[None]) for each in (table, trials.own))
        safe.append(risk(trials, measured, old)[0] <= 1.1 * most_risk(job))
    assert sum(safe) >= 5


def test_the_command_writes_a_table_a_csv_file_json_and_a_figure(tmp_path: Path, grind: Grind) -> None:
    words = ("sweep", EXAMPLES / "plate_g82.nc", "--E", "12000..20000", "--dress-every", "1..3", "--parts", 3, "--plot")
    more = ("--csv", tmp_path / "sweep.csv"), ("--json",)
    (status, shown, _), (again, data, _) = (grind(*words, tmp_path / "sweep.png", *each) for each in more)
    assert status == again == 0
    assert "best interval within" in shown and max(map(len, shown.splitlines()[1:])) <= 100
    told = json.loads(data)
    assert len(told["speeds"]) == 27 and told["valley"][0] >= 1
    with (tmp_path / "sweep.csv").open(encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    costs = [point["cost"]["value"] for point in (told["own"], *told["speeds"])]
    assert [float(row["cost, $"]) for row in rows] == pytest.approx(costs, abs=5e-4)
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "program, ranges, told",
    few(
        [
            ("keyway_g81", SweepRanges(every=(1, 5)), "no block that takes a D word"),
            ("keyway_g81", SweepRanges(lead=(0.1, 0.2)), "no dress program"),
            ("plate_g82", SweepRanges(every=(0, 5)), "from 1 to --parts"),
            ("plate_g82", SweepRanges(E=(9e3, 9e4)), "the table makes 40000"),
        ],
        2,
    ),
)
def test_impossible_sweeps_are_refused_with_the_reason(program: str, ranges: SweepRanges, told: str) -> None:
    with pytest.raises(SweepError, match=told):
        sweep(EXAMPLES / f"{program}.nc", None, ranges, parts=5)


@pytest.mark.nightly
def test_an_E_range_in_inches_per_minute_is_refused_with_its_conversion(tmp_path: Path) -> None:
    program, job = tmp_path / "inch.nc", EXAMPLES / "plate_g82.toml"
    program.write_text(INCH, encoding="utf-8")
    told = r"400..800 does not come near the 15000 mm/min \(591 inch/min\) of inch.nc; .* write --E 10160..20320"
    with pytest.raises(SweepError, match=told):
        sweep(program, job, SweepRanges(E=(400.0, 800.0)), parts=2)
    for name, E in ((program, (5_000.0, 9_000.0)), (EXAMPLES / "plate_g82.nc", (400.0, 800.0))):
        found = sweep(name, job, SweepRanges(E=E), parts=1)
        assert pytest.approx(E) == [found.speeds[0].E, found.speeds[-1].E]


@pytest.mark.parametrize(
    ("option", "ends", "told"),
    [
        *[(each, "0..100", f"{each} begins at 0; begin above 0") for each in ("--E", "--lead", "--depth")],
        ("--dress-every", "1.5..20", "--dress-every: the ends of 1.5..20 are no whole numbers"),
    ],
)
def test_impossible_ranges_are_refused(option: str, ends: str, told: str, grind: Grind) -> None:
    status, _, said = grind("sweep", EXAMPLES / "plate_g82.nc", option, ends, "--parts", 1)
    assert status == 2 and told in said


def test_a_limit_binds_if_it_refuses_a_cheaper_point(found: Sweep) -> None:
    best, own = found.best, found.own
    assert found.refused == {} and f"E{best.E:.0f} is the end of the range" in sentences(found), sentences(found)
    cheaper = replace(best, cost=Interval(0.5, 0.4, 0.6), shares=(0.5, 0.2, 1.18, 0.9), lead=own.lead)
    dearer = replace(best, cost=Interval(9.0, 8.9, 9.1), shares=(0.5, 1.3, 0.7, 0.9))
    refused = replace(found, speeds=(*found.speeds, cheaper, dearer))
    assert refused.best == best
    assert refused.refused == {"Ra": cheaper}
    (said,) = (sentence for sentence in sentences(refused) if "binds" in sentence)
    assert said.startswith(f"the limit of Ra binds: E{cheaper.E:.0f}, a dress every {cheaper.every} parts")
    assert said.endswith(" would cost 0.500 $, but parts reach 118 % of it")
    (row,) = tables_of(replace(refused, speeds=(cheaper,), dresses=()))[1].rows
    assert row[-1].text == "Ra 118 %"


def test_the_legend_names_the_limit_that_hollow_points_exceed(found: Sweep) -> None:
    pytest.importorskip("matplotlib")
    risky = [replace(point, shares=(0.5, 0.5, 0.5, 0.5), risk=1.5) for point in found.speeds]
    kept = replace(found.own, shares=(0.5, 0.5, 0.5, 0.5), risk=0.5)
    upper, _, lower, _ = draw_sweep(replace(found, own=kept, speeds=(kept, *risky), dresses=())).axes
    assert upper.get_legend().get_title().get_text() == "hollow: beyond a limit (risk)"
    (risk,) = [line for line in lower.lines if line.get_label() == "risk"]
    assert max(risk.get_ydata()) == pytest.approx(150.0)
