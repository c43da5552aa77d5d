"""`grind optimise` keeps its promises on other lots and in `grind run`, and gives a reason for each refusal."""

import csv
import itertools
import json
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read, read_file
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.program_episode import BlockRun, ProgramEpisode, Words
from grind_env.envs.tasks import load_task
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.policies.choices import all_choices
from grind_env.policies.episode_columns import COST
from grind_env.policies.score_statistics import bootstrap
from grind_env.shop.optimise import optimisation, variables
from grind_env.shop.optimise import search as clock
from grind_env.shop.optimise.judgement import ProgramJudge, words_of
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.result import Optimised, Verdict, WordChange
from grind_env.shop.optimise.search import Budget, Point, Search
from grind_env.shop.optimise.search_problem import LOTS
from grind_env.shop.optimise.tables import as_data, sentences
from grind_env.shop.search_options import options_of
from grind_env.shop.sweep.study import sweep
from grind_env.shop.trials import LotUse, Measures, lots_of, trials_of
from tests.command import Grind, status
from tests.examples import few
from tests.policies.optimum import exact_optimum
from tests.shop.programs import EXAMPLES, known_job, write

PARTS = 4


LONG = ("--budget", "1000s")  #: long enough that no search ends early on a busy machine
FRESH = tuple((77, 4242, k) for k in range(2048))
SHOWN = {"seconds": "seconds", "Ra": "Ra", "rise": "rise", "size_error": "worst_error", "cost": "total_cost"}


@pytest.fixture(scope="module", params=few(("keyway_g81", "plate_g82", "rail_g83")))
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Optimised:
    job = known_job(tmp_path_factory.mktemp("job"), request.param)
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(variables.STEPS, "E", (Decimal(1000), Decimal(50)))
        return find_words(EXAMPLES / f"{request.param}.nc", job, parts=PARTS, seconds=1000.0)


def test_optimise_improves_every_example_within_the_limits(found: Optimised) -> None:
    assert found.verdict is Verdict.BETTER
    assert not found.ended_early
    assert found.quantity("cost").difference.high < 0.0
    assert all(limit.kept for limit in found.limits)


def test_grind_run_shows_the_promised_numbers(found: Optimised) -> None:
    job = load_job(EXAMPLES / Path(found.program).with_suffix(".toml").name)
    for text, which in ((found.before, 0), (found.after, 1)):
        part = grind(read(text), job).parts[0]
        for name, column in SHOWN.items():
            assert found.quantity(name).expected[which] == pytest.approx(abs(part[column]), rel=1e-9), name
        assert found.quantity("scrap").expected[which] == pytest.approx(100.0 * (1.0 - part["survival"]), abs=1e-7)
        assert found.quantity("power").expected[which] == pytest.approx(part["peak_power"] / 1000.0, rel=1e-9)


def test_the_gain_holds_on_lots_of_other_seeds(found: Optimised) -> None:
    job = load_job(EXAMPLES / Path(found.program).with_suffix(".toml").name)
    before, after = (trials_of(read(text), job, PARTS, FRESH) for text in (found.before, found.after))
    old, new = before.measure(before.own[None]), after.measure(after.own[None])
    change = bootstrap(lambda values: np.asarray(values.mean(axis=-1)), new.cost[0] - old.cost[0])
    promised = found.quantity("cost").difference
    assert change.high < 0.0
    assert change.low < promised.high and promised.low < change.high
    assert new.ratios.max() < 1.1


def test_optimise_costs_at_most_1_percent_more_than_the_best_sweep_point(found: Optimised, tmp_path: Path) -> None:
    path = EXAMPLES / found.program
    grid = sweep(path, known_job(tmp_path, path.stem), parts=PARTS)
    job = load_job(path.with_suffix(".toml"))
    trials = trials_of(read(found.after), job, PARTS, lots_of(1, LotUse.SWEEP, grid.lots))
    cost = trials.measure(trials.own[None]).cost.mean()
    assert cost <= 1.01 * grid.best.cost.value
    assert cost <= grid.own.cost.value


@pytest.mark.usefixtures("few_lots")
def test_a_program_that_is_not_better_is_not_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "out.nc"
    options = ["--vary", "E", "--bounds", "E=8000..9000", "--parts", "2", *LONG, "-o", output]
    assert status("optimise", EXAMPLES / "plate_g82.nc", *options) == 3
    assert "no better program found" in capsys.readouterr().out
    assert not output.exists()


@pytest.mark.usefixtures("few_lots")
@pytest.mark.parametrize(("stiffness", "written"), [(2000, False), (3300, True)])
def test_a_scrapping_program_may_be_replaced_by_one_that_scraps_less(
    stiffness: int, written: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job, output = known_job(tmp_path, "plate_g82"), tmp_path / "my out.nc"
    softer = f"[setup]\nmachine_overrides = {{ stiffness = {stiffness} }}\n"
    job.write_text(job.read_text(encoding="utf-8").replace("[setup]\n", softer))
    options = ["--vary", "E", "--bounds", "E=5000..30000", "--parts", "2", *LONG, "-o", output, "--untried"]
    assert status("optimise", EXAMPLES / "plate_g82.nc", "--job", job, *options) == 4
    told = capsys.readouterr().out
    assert output.exists() == (f"next: grind run '{output}' --job {job}\n" in told) == written
    assert ("nearer to the limits, which it does not keep: -" in told) == written
    if not written:
        assert "no program keeps the limits" in told
        return
    lots = lots_of(5, LotUse.JUDGEMENT, 16)
    trials = [trials_of(read_file(path), load_job(job), 2, lots) for path in (EXAMPLES / "plate_g82.nc", output)]
    before, after = (each.measure(each.own[None]) for each in trials)
    assert before.scrap.mean() > 0.9
    assert after.scrap.mean() < before.scrap.mean() - 0.2
    assert after.cost.mean() < before.cost.mean() - 5.0


@pytest.mark.usefixtures("few_lots")
def test_the_reason_names_a_limit_that_forbids_all_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "out.nc"
    options = ["--vary", "E", "--margin", "Ra=.2", "--parts", "2", *LONG, "--json", "-o", output]
    assert status("optimise", EXAMPLES / "plate_g82.nc", *options) == 4
    told = json.loads(capsys.readouterr().out)
    assert told["verdict"] == "infeasible"
    assert told["reason"].startswith("the limit of Ra forbids all programs tried")
    assert [(limit["name"], limit["price"]) for limit in told["limits"] if limit["binds"]] == [("Ra", None)]
    assert not output.exists()


@pytest.mark.usefixtures("few_lots", "coarse_speeds")
@pytest.mark.parametrize("refused", [1, 2, 99])
def test_the_next_best_program_is_judged_if_the_best_exceeds_a_limit(
    refused: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    measured, words = ProgramJudge.measured, list[tuple[WordChange, ...]]()

    def harsh(judgement: ProgramJudge, point: Point) -> Measures:
        new = measured(judgement, point)
        words.append(words_of(judgement.variation.choices, point))
        return new._replace(ratios=np.full((1, 4), 1.02)) if len(words) <= refused else new

    monkeypatch.setattr(ProgramJudge, "measured", harsh)
    monkeypatch.setattr(optimisation, "costs_of_limits", lambda *arguments: {})
    options = options_of(["E"])
    found = find_words(EXAMPLES / "plate_g82.nc", known_job(tmp_path, "plate_g82"), options, parts=2, seconds=1000.0)
    assert len(words) == len(set(words)) > 1
    if refused < len(words):
        assert len(words) == refused + 1 and found.verdict is Verdict.BETTER and found.words == words[-1]
        assert any(each.startswith(f"the {refused} programs ranked before it") for each in found.remarks)
    else:
        assert "the best program exceeds the limit of" in found.reason and found.words == words[0]
        assert any(each.startswith(f"the {len(words) - 1} programs ranked next") for each in found.remarks)


@pytest.mark.nightly
@pytest.mark.usefixtures("few_lots", "coarse_speeds")
def test_only_the_best_program_is_judged_if_the_budget_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    now, measured = [0.0], ProgramJudge.measured

    def ticking() -> float:
        now[0] += 0.01
        return now[0]

    def slow(judgement: ProgramJudge, point: Point) -> Measures:
        now[0] += 600.0
        return measured(judgement, point)._replace(ratios=np.full((1, 4), 1.02))

    monkeypatch.setattr(ProgramJudge, "measured", slow)
    monkeypatch.setattr(clock, "monotonic", ticking)
    found = find_words(EXAMPLES / "plate_g82.nc", None, options_of(["E"]), parts=2, seconds=1000.0)
    assert found.judged == 1
    assert any("the budget ended before " in remark for remark in found.remarks)


@pytest.mark.usefixtures("few_lots", "coarse_speeds")
def test_a_budget_in_programs_does_not_depend_on_the_clock(monkeypatch: pytest.MonkeyPatch, grind: Grind) -> None:
    words = "optimise", EXAMPLES / "plate_g82.nc", "--vary", "E", "--parts", 2, "--budget", "12 programs", "--json"
    found = []
    for step in (0.01, 100.0):
        looks = itertools.count()
        monkeypatch.setattr(clock, "monotonic", lambda looks=looks, step=step: step * next(looks))
        found.append(json.loads(grind(*words)[1]))
    assert found[0] == found[1]
    assert found[0]["evaluations"] == 12 and found[0]["judged"] >= 1


@pytest.mark.usefixtures("few_lots", "coarse_speeds")
def test_the_program_json_and_csv_of_optimise_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, output = write(tmp_path, "lower"), tmp_path / "out.nc"
    arguments = ["optimise", path, "--vary", "E", "--bounds", "E=12000..20000", "--parts", "3"]
    assert status(*arguments, *LONG, "-o", output, "--json", "--csv", tmp_path / "out.csv") == 0
    told = json.loads(capsys.readouterr().out)
    rows = {row[0]: row for row in csv.reader((tmp_path / "out.csv").read_text(encoding="ascii").splitlines())}
    (seconds,) = (each for each in told["quantities"] if each["name"] == "seconds")
    sides = [seconds[side]["value"] for side in ("before", "after")]
    assert [float(value) for value in rows["seconds"][2:4]] == pytest.approx(sides, 1e-5)
    assert output.read_bytes() == told["text"].encode()
    assert b"\r\n" in output.read_bytes()
    assert status("run", output, "--job", path.with_suffix(".toml")) == 0


class Clock:
    """Clock that advances by a fixed time with every block the control executes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
        self.now, self.judged = 0.0, 0.0
        step, keep = ProgramEpisode.step, Budget.keep

        def ticking(episode: ProgramEpisode, words: Words) -> BlockRun:
            self.now += seconds
            return step(episode, words)

        def noted(budget: Budget, seconds: float) -> None:
            self.judged = self.now
            keep(budget, seconds)

        monkeypatch.setattr(ProgramEpisode, "step", ticking)
        monkeypatch.setattr(Budget, "keep", noted)
        monkeypatch.setattr(clock, "monotonic", lambda: self.now)


@pytest.fixture
def executed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a program of two blocks without a script (G96), which is tried on a quarter of the lots."""
    monkeypatch.setitem(LOTS, LotUse.SEARCH, 4)
    monkeypatch.setattr(optimisation, "LEAST_JUDGED", 2)
    path = tmp_path / "part.nc"
    text = (EXAMPLES / "plate_g82.nc").read_text(encoding="utf-8")
    path.write_text(text.replace("S1910 M03", "G96 S1800 M03"), encoding="utf-8")
    path.with_suffix(".toml").write_bytes((EXAMPLES / "plate_g82.toml").read_bytes())
    return path


#: numbers of executed blocks: before the clock starts, before the first trial, to judge the present program on two lots
#: twice, and in one trial
ONCE, LOOKED, JUDGED, TRIAL = 10, 10, 8, 8


def test_the_search_of_a_program_without_a_script_ends_with_its_budget(
    executed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    budget = (LOOKED + JUDGED + 3.5 * TRIAL) / 0.6  # ends after the second trial
    watch = Clock(monkeypatch, 1.0)
    found = find_words(executed, parts=1, seconds=budget)
    assert found.ended_early and found.evaluations == 2
    assert watch.now <= ONCE + 1.5 * budget + 10.0
    assert 2 <= found.lots < 256
    assert f"judged on {found.lots} lots" in " ".join(sentences(found))
    assert "2 programs tried, 1 judged, seed 1" in sentences(found)
    assert as_data(found)["evaluations"] == 2 and as_data(found)["lots"] == found.lots


def test_a_single_trial_is_reported_as_too_few_programs(
    executed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    watch = Clock(monkeypatch, 1.0)
    report = tmp_path / "found.html"
    assert status("optimise", executed, "--parts", 1, "--budget", f"{LOOKED + TRIAL - 2}s", "--report", report) == 3
    said = capsys.readouterr().out.split("\n")
    assert "too few programs were tried: the first one took all the time of the search" in said[0]
    assert "try about 100 programs with --budget 14min" in said[0] and "1 program tried" in said[-2]
    assert watch.now <= 5.0 * (LOOKED + TRIAL - 2) + 10.0
    assert "no better program" not in "".join(said) + report.read_text(encoding="utf-8")


@pytest.mark.parametrize("seconds", [2.0, 8.0], ids=["before the first trial", "within it"])
def test_a_budget_too_short_for_one_trial_is_refused_with_a_remedy(
    executed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], seconds: float
) -> None:
    watch = Clock(monkeypatch, 1.0)
    assert status("optimise", executed, "--parts", 1, "--budget", f"{seconds}s") == 2
    error = capsys.readouterr().err
    assert "no time to try one program on 4 lots, for the control executes" in error and error.count("\n") == 1
    assert "give it more than --budget" in error
    assert watch.now <= ONCE + 1.5 * seconds + 4.0 + 1.0


@pytest.mark.parametrize(
    "options, told",
    [
        (["--vary", "E,Q"], "there is no 'Q'"),
        (["--bounds", "E=9000"], "'9000' is no range of E"),
        (["--bounds", "E=9000..90000"], "40000 is the most here"),
        (["--margin", "heat=.5"], "there are power, rise, Ra, size"),
        (["--margin", "power=85"], "power=85 is 85 times the limit, and no share of it; write a number up to 1, such"),
        (["--budget", "soon"], "write 60s, 2min or '2000 programs'"),
        (["--fix", "N51"], "N51 is no cycle block"),
    ],
)
def test_invalid_options_are_refused_in_one_line(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status("optimise", EXAMPLES / "plate_g82.nc", *options) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1


def test_the_search_finds_the_optimum_of_oracle6() -> None:
    """Compare the search with dynamic programming over all plans of the task."""
    simulation = BlockSimulation(load_task("oracle6"))
    optimum, choices = exact_optimum(simulation), all_choices(simulation.task, 20)
    start = simulation.start([np.random.default_rng(0)])

    def costs(points: np.ndarray) -> np.ndarray:
        episodes, total = start.pick(np.zeros(len(points), int)), np.zeros(len(points))
        for block in range(6):
            chosen = points[:, 2 * block] * 2 + points[:, 2 * block + 1]
            total += simulation.step(episodes, choices.speeds[chosen], choices.executions[chosen])[0][:, COST]
        return total

    assert len(choices.speeds) == 8 and choices.executions[1] != choices.executions[0]
    search = Search(costs, [4, 2] * 6)
    best = search.costs[search.run((0, 0) * 6, seed=1)]
    assert optimum.cost - 1e-9 <= best <= 1.001 * optimum.cost


@pytest.mark.usefixtures("few_lots")
def test_only_a_limit_next_to_the_best_settings_binds(tmp_path: Path) -> None:
    options = options_of(("E",), {"E": (5000, 30_000)}, margins={"Ra": 0.68})
    job = known_job(tmp_path, "plate_g82")
    found = find_words(EXAMPLES / "plate_g82.nc", job, options, parts=PARTS, seconds=1000.0)
    limits = {limit.name: limit for limit in found.limits}
    assert [name for name, limit in limits.items() if limit.binds] == ["Ra"]
    assert 0.62 < limits["Ra"].after <= 0.68 < (limits["Ra"].without or 0.0) < 0.8
    assert any(sentence.startswith("the limit of Ra binds: ") for sentence in sentences(found))


@pytest.mark.usefixtures("few_lots", "coarse_speeds")
@pytest.mark.parametrize(("tolerance", "searched"), [(2.0, {"size"}), (900.0, set())])
def test_the_search_is_repeated_only_without_limits_that_refuse_a_program(
    tolerance: float, searched: set[str], tmp_path: Path
) -> None:
    job, labels = known_job(tmp_path, "keyway_g81"), set[str]()
    part = replace(load_job(job).part, tolerance=tolerance, roughness_limit=0.0, rise_allowance=1500.0)
    options = options_of(("E",))
    progress = lambda label, count: labels.add(label)  # noqa: E731
    found = find_words(
        EXAMPLES / "keyway_g81.nc",
        replace(load_job(job), part=part),
        options,
        parts=1,
        seconds=1000.0,
        progress=progress,
    )
    assert {label.removeprefix("without the limit of ") for label in labels if label.startswith("without")} == searched
    for limit in found.limits:
        if limit.name not in searched and limit.price is not None:
            assert limit.price.value == 0.0 and limit.without == limit.after
