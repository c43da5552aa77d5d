"""A few executed runs represent a batch only if executing every run gives the same result to the bit."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grind_env.control import read, read_file
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobProgramError
from grind_env.envs.job.repeated_program import batch_of, repeated
from grind_env.machine.grind import grind as run
from grind_env.machine.job.job_file import load_job
from grind_env.machine.script.block_settings import E
from grind_env.machine.script.script_tables import PlanRow, ScriptTables
from grind_env.shop import trials as trials_module
from grind_env.shop.optimise import search as clock
from grind_env.shop.optimise import search_problem
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.tables import sentences
from grind_env.shop.trials import LotUse, Trials, lots_of, trials_of
from tests.examples import few
from tests.shop.programs import EXAMPLES, JOB, PROGRAMS, write

RUNS = 9
PLACE = [PlanRow._fields.index(name) for name in ("block", "line")]
FOUND = sorted(Path(__file__).parent.glob("programs_from_*/*.nc"))
FINISH = "N80 G80"
AGAIN = "G00 X-30. ; G01 Y-.19 F500. ; G82 X230. I-30. Y-.2 J-.005 L1 F60. E9000. P9100 D1 ; N80 G80"
#: programs with identical runs
LIKE = {
    "is gauged at rest": (FINISH, f"G80 ; G00 Y2. ; M01 ; G04 P3. ; {AGAIN}"),
    "is gauged while the table runs": ("N60 M01", "G04 P1.5 ; N60 M01"),
    "grinds two parts": (FINISH, f"G80 ; G00 Y2. ; M00 ; {AGAIN}"),
    "is gauged in a subprogram": ("N60 M01", "M98 P300"),
    "is incremental in part": (FINISH, f"G80 ; G91 G00 Y2. ; X10. ; G90 ; {AGAIN}"),
}
#: programs with runs that may differ, if only in the last digit
OWN_RUNS = {
    "drifts across": ("N20 G00 Y2. Z-2.5", "N20 G91 G00 Z.01 ; G90 G00 Y2."),
    "has a variable": ("N50 G82", "#100=15000 ; N50 G82"),
    "counts its parts": ("N50 G82", "#100=#100+1 ; IF[#100EQ6]THEN#101=1 ; N50 G82"),
    "adds to a table": ("N20 G00", "G91 G10 L2 P1 Z.01 ; G90 ; N20 G00"),
    "adds to a table with zeros and a point": ("N20 G00", "G91 G 010. L2 P1 Z.01 ; G90 ; N20 G00"),
    "adds to a table by a code worked out": ("N20 G00", "G91 G[5+5] L2 P1 Z.01 ; G90 ; N20 G00"),
    "jumps": ("N100 M30", "GOTO 100 ; N100 M30"),
    "calls a macro": ("N60 M01", "G65 P300 A1."),
    "infeeds beside the table": ("N60 M01", "G01 Y-.175 F.3"),
}
GAUGED = JOB.replace("load = 20", "gauge = 12\nload = 20")


def rows_of(tables: ScriptTables) -> list[Any]:
    """Return the tables without the block and line numbers."""
    return [np.delete(each, PLACE, axis=1) if name == "plans" else each for name, each in tables._asdict().items()]


def block_count(simulation: JobSimulation) -> int:
    return simulation.programs.main.blocks.count


def changed(folder: Path, old: str, new: str) -> Path:
    """Write the plate with a text replaced and a subprogram added, in a job with a gauging time; return its path."""
    path = write(folder, "plate", GAUGED)
    text = path.read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new.replace(" ; ", "\n")).replace("O9100 ", "O300\nG04 P.5\nM01\nM99\nO9100 ")
    path.write_text(text, encoding="utf-8")
    return path


def require_same(path: Path, runs: int = RUNS) -> bool:
    """Assert that the trials equal a batch of all runs; return whether fewer runs were executed."""
    programs, job = read_file(path), replace(load_job(path.with_suffix(".toml")), variables={100: 0.0})
    made, whole = trials_of(programs, job, runs, lots_of(1, LotUse.BASE, 2)), batch_of(programs, runs, job.variables)
    full = JobSimulation(whole.programs, job, 1.0)
    for one, other in zip(rows_of(made.simulation.tables), rows_of(full.tables), strict=True):
        np.testing.assert_array_equal(one, other)
    assert [each.block.source for each in made.all_blocks] == [whole.origin(each.block).source for each in full.blocks]
    assert made.simulation.task.reference_cost == full.task.reference_cost
    return block_count(made.simulation) < block_count(full)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_few_runs_represent_the_batch(name: str, tmp_path: Path) -> None:
    assert require_same(write(tmp_path, name))


@pytest.mark.parametrize("name", few(["rail_g83", "keyway_g81"]))
def test_an_infeed_beside_the_table_makes_every_run_execute(name: str) -> None:
    assert require_same(EXAMPLES / f"{name}.nc") == (name == "rail_g83")


@pytest.mark.parametrize(
    "path", few([each for each in FOUND if each.stem in ("magnet_plate", "plate_goto", "three_steps")])
)
def test_a_few_runs_represent_shop_programs_without_goto(path: Path) -> None:
    assert require_same(path) == (path.stem != "plate_goto")


@pytest.mark.parametrize("like", few(LIKE))
def test_identical_runs_are_represented_from_five_runs_on(like: str, tmp_path: Path) -> None:
    path = changed(tmp_path, *LIKE[like])
    assert [require_same(path, runs) for runs in (1, 4, 5, 60)] == [False, False, True, True]


@pytest.mark.parametrize("own", OWN_RUNS)
def test_runs_that_may_differ_are_all_executed(own: str, tmp_path: Path) -> None:
    assert not require_same(changed(tmp_path, *OWN_RUNS[own]))


def test_all_runs_are_executed_if_a_called_file_counts(tmp_path: Path) -> None:
    path = changed(tmp_path, "N60 M01", "M98 P500")
    (tmp_path / "O500.nc").write_text("O500\n#100=#100+.01\nG04 P#100\nM99\n")
    assert not require_same(path)


def test_a_program_with_radius_compensation_has_no_script(tmp_path: Path) -> None:
    path = changed(tmp_path, "N30 G00 X-30.", "N30 G18 G41 G01 X-40. Z-3. F500. ; X-35. ; G40 X-30. Z-2.5 ; G19")
    job = load_job(path.with_suffix(".toml"))
    assert trials_of(read_file(path), job, RUNS, lots_of(1, LotUse.BASE, 1)).simulation.script is None


@pytest.mark.parametrize("candidates", [1, 5])
def test_results_do_not_depend_on_the_number_of_cores(candidates: int, monkeypatch: pytest.MonkeyPatch) -> None:
    plate = EXAMPLES / "plate_g82.nc"
    trials = trials_of(read_file(plate), load_job(plate.with_suffix(".toml")), 3, lots_of(1, LotUse.BASE, 7))
    settings = np.repeat(trials.own[None], candidates, axis=0)
    settings[:, :, E] *= np.linspace(0.8, 1.1, candidates)[:, None]
    found = []
    for cores in (1, 3):
        monkeypatch.setattr(trials_module, "CORES", cores)
        found.append(trials.measure(settings))
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


PACE = 0.001  #: time of a program on a lot, s


@pytest.mark.nightly
@pytest.mark.parametrize("seconds", [6.0, 12.0])
def test_search_and_judgement_stay_within_the_budget(seconds: float, monkeypatch: pytest.MonkeyPatch) -> None:
    now, ground = [0.0], Trials._ground

    def ticking(trials: Trials, settings: Any, seeds: Any, *rest: Any, **others: Any) -> Any:
        now[0] += PACE * len(settings) * len(seeds)
        return ground(trials, settings, seeds, *rest, **others)

    monkeypatch.setattr(trials_module, "CORES", 1)
    monkeypatch.setattr(search_problem, "USUAL_RUNS", 1)
    monkeypatch.setattr(Trials, "_ground", ticking)
    monkeypatch.setattr(clock, "monotonic", lambda: now[0])
    found = find_words(EXAMPLES / "plate_g82.nc", None, parts=2, seconds=seconds)
    assert found.ended_early and found.lots == 256
    assert 1 < found.evaluations < seconds / (16 * PACE)
    assert now[0] <= 1.2 * seconds + 0.1
    told = [each for each in sentences(found) if "no time to find what the limit of" in each]
    assert bool(told) == any(limit.price is None for limit in found.limits)


ROUGH, SHORTER = "N50 G82 X230. I-30. Y-.17 J-.01 L0 F60. E15000. P9100 D1", "N70 G71 G82 X231. I-31."
#: first cycles without E or I of their own; the second cycle has another E and another I
UNSAID = {
    "E is F": "G82 X230. I-30. Y-.17 J-.01 F15000. P9100 D1",
    "E is an F before": "G82 X230. I-30. Y-.17 J-.01 P9100 D1",
    "I is where the table stands": "G82 X230. Y-.17 J-.01 F60. E15000. P9100 D1",
    "E and I in inches": "G70 G82 X9. Y-.0067 J-.0004 F590.55 P9100 D1",
    "E and I in G91": "G91 G82 X260. Y-.17 J-.01 F9999. P9100 D1 ; G90",
    "the program jumps": "GOTO 55 ; N55 G82 X230. Y-.17 J-.01 F15000. P9100 D1",
}
SHARED = "F15000. ; M98 P400 ; G82 Y-.18 E9000. ; M98 P400"


@pytest.mark.parametrize("words", UNSAID)
def test_every_run_of_a_batch_makes_the_same_strokes_as_the_program(words: str, tmp_path: Path) -> None:
    """The control forgets E and I of the last cycle at the end of a program, but not at M00."""
    path = changed(tmp_path, ROUGH, UNSAID[words])
    text = path.read_text(encoding="utf-8").replace("N70 G82", SHORTER)
    once, parts = (
        run(programs, load_job(path.with_suffix(".toml"))).strokes for programs in (read(text), repeated(read(text), 3))
    )
    assert np.unique(once["E"]).size == 2
    for number in (1, 2, 3):
        part = parts[parts["part"] == number]
        np.testing.assert_allclose(part["E"], once["E"], rtol=1e-6)
        np.testing.assert_allclose(part["seconds"], once["seconds"], rtol=1e-6)


def test_a_batch_refuses_a_cycle_that_takes_E_from_different_words(tmp_path: Path) -> None:
    path = changed(tmp_path, ROUGH, SHARED)
    text = path.read_text(encoding="utf-8").replace("O300", "O400\nG82 X230. I-30. Y-.17 J-.01 P9100\nM99\nO300")
    with pytest.raises(JobProgramError, match="E or I of the cycle is another one after the first part; write both"):
        repeated(read(text), 2)
