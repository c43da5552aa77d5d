"""The study of out-of-model machines: machines, comparisons, cache and promises."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomllib

from agents.evaluation_cache import imported
from agents.plants import trials
from agents.plants.advising import plans
from agents.plants.figure import MOST, plants_figure
from agents.plants.optimising import real
from agents.plants.page import page, programs_of, write
from agents.plants.power_errors import MeanCuts, fitted, predicted
from agents.plants.program_variants import batch, scaled, with_catalogue
from agents.plants.promises import promises
from agents.plants.shop_log import over_the_part
from agents.plants.study_machines import FAMILY_NAMES, PROGRAMS, StudyMachine, StudyProgram, machines
from agents.plants.trials import PlantsTrial
from grind_env.control import read, read_file
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.rehearsal import advised, as_programmed, ground
from tests.agents.asking import in_process, status

PLATE = StudyMachine("model", PROGRAMS["plate"])


def test_the_machines_combine_all_families_with_all_programs() -> None:
    found = machines(seeds=2)
    assert len({*found}) == len(found) == len(PROGRAMS) * (1 + 2 * (len(FAMILY_NAMES) - 1))
    assert all(each.program.job.exists() for each in found)


@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS)
def test_a_scaled_program_has_scaled_strokes(program: StudyProgram) -> None:
    text, job = program.text, StudyMachine("model", program).job()
    own, other = (grind(read(each, "a.nc"), job).strokes for each in (text, scaled(text, 0.5, 1.0)))
    np.testing.assert_allclose(other["E"], 0.5 * own["E"])
    deeper = grind(read(scaled(text, 1.0, 2.0), "a.nc"), job).strokes
    assert len(deeper) < len(own) and deeper["Z"].max() == own["Z"].max()
    assert not grind(read(scaled(text, dressed=False), "a.nc"), job).dresses.size


def test_a_batch_grinds_its_parts_in_sequence() -> None:
    text, job = PLATE.program.text, PLATE.job()
    whole = grind(read(batch(PLATE.program, (1.0, 0.8), (True, False)), "a.nc"), job)
    first = grind(read(text, "a.nc"), job)
    assert len(whole.parts) == 2 and len(whole.dresses) == 1
    count = len(first.strokes)
    np.testing.assert_array_equal(whole.strokes["ae"][:count], first.strokes["ae"])
    np.testing.assert_allclose(whole.strokes["E"][count:], 0.8 * first.strokes["E"])


def test_a_log_has_every_stroke_over_the_part_and_a_pause_at_the_stop() -> None:
    text = PLATE.program.text
    strokes = grind(read(text, "a.nc"), PLATE.job()).strokes
    begins, ends = over_the_part(grind(read(text, "a.nc"), PLATE.job()), text)
    np.testing.assert_allclose(ends - begins, 60.0 * 200.0 / strokes["E"])
    assert (begins[1:] > ends[:-1]).all()
    gap = np.diff(begins) - np.diff(strokes["time"])
    assert gap[np.flatnonzero(np.diff(strokes["line"]))[-1]] == pytest.approx(8.0, abs=0.5)  # at the M01


def test_the_regression_finds_a_power_law() -> None:
    rng = np.random.default_rng(1)
    cuts = MeanCuts(*(rng.uniform(low, high, 60) for low, high in ((0.002, 0.02), (100, 400), (0, 400), (5, 25))))
    power = cuts.b * 300.0 * cuts.a**0.7 * cuts.v**0.5 * (cuts.V + 10.0) ** 0.1
    np.testing.assert_allclose(fitted(cuts, power)[1:], [0.7, 0.5, 0.1], atol=0.01)
    np.testing.assert_allclose(predicted(fitted(cuts, power), cuts), power, rtol=0.02)


@pytest.mark.nightly
def test_the_adviser_scraps_few_parts_on_a_soft_machine() -> None:
    rail = StudyMachine("soft:2", PROGRAMS["rail"])
    model, simulation = StudyMachine("model", rail.program).simulation(40), rail.simulation(40)
    policy: Any = policy_for(None, model)
    # the policy of the model alone burns more than one part in ten
    assert ground(simulation, advised(Adviser(model, policy.model))).scrap.mean() > 0.1
    assert ground(simulation, advised(Adviser(model, policy))).scrap.mean() < 0.03


def test_a_shift_costs_as_much_as_its_program() -> None:
    simulation = PLATE.simulation(30)
    shifts = [ground(simulation, as_programmed(simulation), seed) for seed in range(4)]
    assert np.mean([shift.cost.mean() for shift in shifts]) == pytest.approx(
        real(read_file(PLATE.program.path), PLATE.job())[0], rel=0.01
    )


def test_plans_dress_as_often_as_they_say() -> None:
    simulation = PLATE.simulation(8)
    dresses = [ground(simulation, plan).executions.sum() for plan in plans(simulation)]
    assert dresses == [8.0, 4.0, 2.0] * 5


def test_the_tables_show_each_promise_and_its_verdict(tmp_path: Path) -> None:
    kept = {"adviser_cost": 1.0, "floor_cost": 1.0, "plan_cost": 1.0, "adviser_scrap": 0.0, "adviser_in_a_row": 0.0}
    missed = kept | {"adviser_cost": 2.0, "adviser_scrap": 0.5}
    others = [StudyMachine("meter:1", PLATE.program), StudyMachine("soft:1", PLATE.program)]
    good, bad = (
        {
            each.what: each.kept
            for _, each in promises({PlantsTrial("advise", others[0]): kept, PlantsTrial("advise", others[1]): last})
        }
        for last in (kept, missed)
    )
    plan = "cost over the best of 15 fixed plans"
    assert all(good.values()) and not bad["scrap, worst machine, %"] and not bad[f"{plan}, worst machine"]
    found = {PlantsTrial("advise", others[0]): kept, PlantsTrial("advise", others[1]): missed}
    assert "| soft | 1 |" in page(found, drawn=False) and "NO" in page(found, drawn=False)
    write(found, tmp_path)
    rows = 1 + len(kept) + len(missed)
    assert (tmp_path / "plants.csv").read_text().count("\n") == rows
    # answers to other questions stay
    write({PlantsTrial("robust", others[0]): {"robust_cost": 1.0, "plan_cost": 1.0}}, tmp_path)
    assert (tmp_path / "plants.csv").read_text().count("\n") == rows + 2
    write({PlantsTrial("advise", others[0]): kept}, tmp_path)
    assert (tmp_path / "plants.csv").read_text().count("\n") == 1 + len(kept) + 2
    assert "## advise" in (tmp_path / "plants.md").read_text() and "## robust" in (tmp_path / "plants.md").read_text()


def test_a_robust_agent_is_compared_with_the_best_plan_of_each_machine() -> None:
    cell = PlantsTrial("robust", PLATE._replace(plant="soft:1"))
    numbers = {"plan_cost": 2.0, "robust_cost": 2.2, "robust_scrap": 0.031}
    asked = [each for _, each in promises({cell: numbers})]
    assert [each.found for each in asked] == pytest.approx([1.1, 1.1, 3.1])
    assert [each.kept for each in asked] == [True, True, False]


def test_the_figure_has_a_dot_at_the_cost_of_every_machine(tmp_path: Path) -> None:
    soft, meter = (PLATE._replace(plant=name) for name in ("soft:1", "meter:1"))
    found = {
        PlantsTrial("advise", soft): {"adviser_cost": 3.0, "floor_cost": 4.0, "plan_cost": 2.0},
        PlantsTrial("advise", meter): {"adviser_cost": 1.0, "floor_cost": 30.0, "plan_cost": 2.0},
    }
    figure = plants_figure(found)
    assert figure is not None
    (panel,) = figure.axes
    drawn = {
        str(line.get_label()): list(zip(*line.get_data(), strict=True))
        for line in panel.lines
        if len(line.get_data()[0])
    }
    assert [label.get_text() for label in panel.get_yticklabels()] == ["soft", "meter"]
    assert drawn["grind advise"] == [(1.5, 0.0), (0.5, -1.0)]
    # a dot beyond the axis stands at its end
    assert [x for x, _ in drawn["adviser without a model"]] == [2.0, MOST]
    assert "agent of grind train" not in drawn
    write(found, tmp_path)
    assert "![" in (tmp_path / "plants.md").read_text() and (tmp_path / "figures" / "plants.png").stat().st_size > 5000
    assert plants_figure({PlantsTrial("calibrate", soft): {}}) is None


@pytest.mark.nightly
def test_the_deciding_code_includes_every_loaded_module() -> None:
    names = "m.__file__ for n, m in sys.modules.items() if n.startswith('grind_env')"
    code = f"import sys, agents.plants.power_errors; print(*({names}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=trials.ROOT)
    found = {*map(str, imported("agents.plants.power_errors", trials.DECIDING).values())}
    own = {each for each in loaded.stdout.split() if not each.endswith(("__init__.py", "registration.py"))}
    assert len(own) > 100 and own <= found


@pytest.mark.nightly
def test_another_program_or_job_of_the_same_name_is_another_cell(tmp_path: Path) -> None:
    path = _copied(tmp_path, "part.nc", PLATE.program.text)
    (program,) = programs_of([str(path)], None)
    first = trials.code(PlantsTrial("advise", StudyMachine("model", program)))
    assert trials.code(PlantsTrial("advise", StudyMachine("model", program))) == first
    path.with_suffix(".toml").write_text(PLATE.program.job.read_text().replace("tolerance = 9", "tolerance = 8"))
    assert trials.code(PlantsTrial("advise", StudyMachine("model", program))) != first


def _copied(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    path.with_suffix(".toml").write_text(PLATE.program.job.read_text())
    return path


def test_a_users_program_is_written_out_in_any_spelling(tmp_path: Path) -> None:
    text = PLATE.program.text.replace(" D1", "d1").replace("M30", "m30").replace(" E15000.", "E15000.0")
    (program,) = programs_of([str(_copied(tmp_path, "part.nc", text))], None)
    ours, theirs = (
        grind(each.read(batch(each, (0.8, 1.2), (True, False))), PLATE.job()) for each in (PLATE.program, program)
    )
    np.testing.assert_array_equal(theirs.strokes["power"], ours.strokes["power"])


@pytest.mark.parametrize(
    ("old", "new"),
    [("E15000.", "E#101"), ("M30", "GOTO 10"), ("M30", "M99"), ("%\nO", "N5 GOTO 10\nO")],
    ids=["variable", "jump", "subprogram", "begins with a jump"],
)
def test_a_program_with_variables_jumps_or_returns_is_refused(tmp_path: Path, old: str, new: str) -> None:
    text = PLATE.program.text.replace(old, new).replace("N10", "#101=15000\nN10")
    with pytest.raises(GrindError):
        programs_of([str(_copied(tmp_path, "part.nc", text))], None)


def test_a_catalogue_is_added_to_the_catalogues_of_a_job(tmp_path: Path) -> None:
    files = tmp_path / "own.toml", tmp_path / "more.toml"
    files[0].write_text("[wheel.mine]\n")
    for catalogue in ("", "[catalogue]\nfiles = [\n  'own.toml',\n]\n", "[catalogue]\n"):
        job = tmp_path / "job.toml"
        job.write_text(PLATE.program.job.read_text() + catalogue)
        listed = tomllib.loads(with_catalogue(job, files[1]))["catalogue"]["files"]
        assert listed == [str(each) for each in files[0 if "own" in catalogue else 1 :]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--family", "metre"], "did you mean meter"),
        (["--program", "plat"], "did you mean plate"),
        (["--program", "no.nc"], "name a file"),
        (["--job", "a.toml"], "--job needs exactly one --program that is a file"),
        (["--program", "plate", "--job", "a.toml"], "--job needs exactly one --program that is a file"),
        (["--program", "."], "choose plate, rail, die, or name a file"),
        (["--program", ""], "--program"),
        (["--question", "opt"], "choose calibrate, optimise, advise"),
        (["--seeds", "0"], "--seeds"),
        (["--seeds", "many"], "--seeds"),
        (["--jobs", "0"], "--jobs"),
        (["--family", "meter:1"], "did you mean meter"),
    ],
)
def test_invalid_options_are_refused_without_a_traceback(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = status(monkeypatch, "plants", *arguments)
    error = capsys.readouterr().err
    assert ended != 0 and said in error and "Traceback" not in error


@pytest.mark.nightly
def test_a_second_run_of_a_study_reads_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    in_process(monkeypatch)
    words = ("plants", "--family", "model", "--tasks", "plate", "--question", "advise", "--cache", tmp_path)
    assert status(monkeypatch, *words, "--episodes", 1) == 0
    (file,) = (tmp_path / "plants").glob("advise-plate-on-model-*.json")
    written, numbers = file.stat().st_mtime_ns, json.loads(file.read_text())
    for episodes in (1, 2):  # other episodes are other results
        assert status(monkeypatch, *words, "--episodes", episodes) == 0 and file.stat().st_mtime_ns == written
        assert len([*file.parent.glob("advise-plate-on-model-*.json")]) == episodes
    assert numbers["adviser_cost"] < numbers["program_cost"] and "## advise" in (tmp_path / "plants.md").read_text()
