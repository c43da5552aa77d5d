import dataclasses
import re
import shlex
from pathlib import Path

import pytest

import grind_env
from agents.command_line import app
from agents.tuning.rule_tuning import tunable, tune
from agents.tuning.tunable_parameters import RULES, from_vector, vector_size
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.registry import ABLATIONS, make_policy
from grind_env.policies.tuned_parameters import CONFIGS, ConfigError, Tuned, read_tuned, write_tuned
from grind_env.task_version import TASK_VERSION
from tests.examples import few
from tests.policies.harness import simulated

EXAMPLES = Path(grind_env.__file__).with_name("examples")
PLATES, ORACLE = simulated("power_limited"), simulated("oracle6")
ORACLE_PROBLEM = find_problem("oracle6")
TUNED = Tuned(
    parameters={"E": [10.5, 7.0], "D": [1, 0], "gA": -0.5},
    training_cost=1.25,
    validation_cost=1.5,
    evaluations=12,
    training_seeds=[0, 4],
    validation_seeds=[500000, 4],
)


def test_parameters_are_read_as_written(tmp_path):
    write_tuned("job", {"a": TUNED, "b": TUNED}, tmp_path)
    assert read_tuned("job", tmp_path) == {"a": TUNED, "b": TUNED}
    assert [path.name for path in tmp_path.iterdir()] == ["job.toml"]


def test_a_task_without_a_file_has_nothing_tuned(tmp_path):
    assert read_tuned("job", tmp_path) == {}
    with pytest.raises(ConfigError, match="python -m agents tune --task power_limited"):
        make_policy("adaptive_rule", PLATES, tmp_path)


@pytest.mark.parametrize("line", ["", "task_version = 1\n", f"task_version = {TASK_VERSION + 1}\n"])
def test_parameters_of_another_task_version_name_the_tuning_command(tmp_path, line):
    write_tuned("power_limited", {"adaptive_rule": TUNED, "constant": TUNED}, tmp_path)
    path = tmp_path / "power_limited.toml"
    path.write_text(path.read_text(encoding="utf-8").replace(f"task_version = {TASK_VERSION}\n", line), "utf-8")
    assert read_tuned("power_limited", tmp_path) == {}
    number = line.split()[-1] if line else "1"
    command = f"python -m agents tune --task power_limited --policies adaptive_rule --parameters {tmp_path}"
    with pytest.raises(ConfigError) as caught:
        make_policy("adaptive_rule", PLATES, tmp_path)
    place, _, remedy = str(caught.value).rpartition(": ")
    assert place.startswith(f"the parameters in {path} are of task version {number}, ") and remedy == f"run `{command}`"


def test_tuning_replaces_parameters_of_another_task_version(tmp_path):
    configs, first = tmp_path / "configs", {"episodes": 2, "runs": tmp_path / "runs"}
    tune(ORACLE_PROBLEM, ["constant"], folder=configs, **first)
    path = configs / "oracle6.toml"
    fresh = path.read_text(encoding="utf-8")
    path.write_text(fresh.replace(f"task_version = {TASK_VERSION}\n", "").replace("E = ", "E = 1"), "utf-8")
    tune(ORACLE_PROBLEM, ["constant"], folder=configs, **first)
    assert path.read_text(encoding="utf-8") == fresh


@pytest.mark.parametrize("text", ["[a", "[a]\nnonsense = 1", "# 5 µm\n"])
def test_a_damaged_file_is_an_error(tmp_path, text):
    (tmp_path / "power_limited.toml").write_text(text, encoding="latin-1")
    for read in (lambda: read_tuned("power_limited", tmp_path), lambda: make_policy("constant", PLATES, tmp_path)):
        with pytest.raises(ConfigError, match=r"power_limited\.toml is damaged"):
            read()


@pytest.mark.parametrize("name", ["constant", "constant_per_kind", "adaptive_rule", "full_state_rule", "mpc"])
@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"nonsense": 1}, "nonsense"),
        ({"E": []}, "has no E that fits"),
        ({"E": [10.0] * 9}, "has no E that fits"),
        ({"E": "'fast'"}, "has no E that fits"),
        ({"E": "nan"}, "has no E that fits"),
        ({"E": None}, "does not fit .*'E'"),
    ],
)
def test_parameters_unfit_for_their_policy_are_an_error(name, change, match, tmp_path):
    kept = "full_state_rule" if name == "mpc" else name
    tuned = read_tuned("oracle6")[kept]
    parameters = {key: value for key, value in {**tuned.parameters, **change}.items() if value is not None}
    write_tuned("oracle6", {kept: dataclasses.replace(tuned, parameters=parameters)}, tmp_path)
    with pytest.raises(ConfigError, match=match) as caught:
        make_policy(name, ORACLE, tmp_path)
    assert f"oracle6.toml: [{kept}.parameters]" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("every", [0, -2, 1.5])
def test_an_interval_must_be_a_whole_number_of_blocks(every, tmp_path):
    tuned = read_tuned("oracle6")["interval"]
    parameters = {**tuned.parameters, "every": every}
    write_tuned("oracle6", {"interval": dataclasses.replace(tuned, parameters=parameters)}, tmp_path)
    with pytest.raises(
        ConfigError, match=r"oracle6\.toml: \[interval\.parameters\] has no every that fits: give a whole number"
    ):
        make_policy("interval", ORACLE, tmp_path)


def test_parameters_must_be_a_table(tmp_path):
    write_tuned("oracle6", {"constant": TUNED}, tmp_path)
    path = tmp_path / "oracle6.toml"
    path.write_text(path.read_text(encoding="utf-8").partition("[constant.")[0] + "parameters = 3\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"\[constant\.parameters\] does not fit"):
        make_policy("constant", ORACLE, tmp_path)


def test_an_impossible_folder_is_an_error(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be made"):
        write_tuned("job", {"a": TUNED}, tmp_path / "file" / "configs")


def problem_of(name: str) -> Problem:
    """Return the problem of a parameter file; names for an example program end in its number of parts."""
    batch = re.fullmatch(r"(.+)_x(\d+)", name)
    return find_problem(name) if batch is None else find_problem(str(EXAMPLES / f"{batch[1]}.nc"), parts=int(batch[2]))


@pytest.mark.parametrize("task", few(sorted(path.stem for path in CONFIGS.glob("*.toml")), 2))
def test_parameter_files_record_the_cost_of_their_parameters(task):
    simulation, tuned = problem_of(task).simulation(), read_tuned(task)
    assert [name for name in tuned if name not in ABLATIONS] == tunable(simulation)
    # a look-ahead takes seconds an evaluation
    for name in set(tuned) - ({"look_ahead"} if task != "oracle6" else set()):
        entry = tuned[name]
        run = run_seeds(make_policy(name, simulation), simulation, episode_seeds("training", entry.training_seeds[1]))
        assert run.cost.mean() == pytest.approx(entry.training_cost, rel=1e-4), name


def test_a_zero_search_vector_is_the_start_and_values_stay_in_bounds():
    task = ORACLE.task
    start = from_vector(RULES["adaptive_rule"], task, [0.0] * 11)
    assert (start["E"], start["gA"], start["wH"]) == ([12_000.0, 12_000.0], -0.3, 0.5)
    assert from_vector(RULES["constant_per_kind"], task, [0.0, 0.0, 9.0, -9.0])["D"] == [1, 0]
    assert from_vector(RULES["power_threshold"], task, [0.0, 0.0, 9.0, 0.0])["lower"] == 1.0
    plans = [from_vector(RULES["adaptive_speed"], task, [0.0] * 6 + [z, z]) for z in (-9.0, 0.0, 9.0)]
    # exp(4.5) times 4 blocks
    assert [(plan["D"], plan["every"]) for plan in plans] == [(0, 1), (1, 4), (1, 360)]


def test_terms_without_meaning_in_a_task_are_not_tuned():
    sizes = {name: vector_size(RULES["adaptive_rule"], simulated(name).task) for name in ("rush", "CBN")}
    # 3 or 2 kinds, each with E and A_dress; 7 coefficients of every task, 2 of the task
    assert sizes == {"rush": 15, "CBN": 13}
    rush, cbn = (set(from_vector(RULES["adaptive_rule"], simulated(name).task, [0.0] * sizes[name])) for name in sizes)
    assert rush - cbn == {"gP", "wP"}
    assert cbn - rush == {"gB", "wB"}


TASK = 'base = "oracle6"\nblocks = 3\n'
FEW = {"evaluations": 8, "starts": 1, "episodes": 1}


def own_program(folder: Path) -> str:
    """Copy an example program, whose parameters are tuned for batches, to the user's files; return its path."""
    for name in ("plate_g82.nc", "plate_g82.toml"):
        (folder / name).write_text((EXAMPLES / name).read_text(encoding="utf-8"), encoding="utf-8")
    return str(folder / "plate_g82.nc")


def test_parameters_of_a_users_file_lie_below_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shop.toml").write_text(TASK, encoding="utf-8")
    shipped = {path.name: path.read_bytes() for path in CONFIGS.iterdir()}
    problem = find_problem("shop.toml")
    tuned = tune(problem, ["constant"], runs=tmp_path / "runs", **FEW)
    assert {path.name: path.read_bytes() for path in CONFIGS.iterdir()} == shipped
    assert read_tuned("shop", Path("runs/parameters")) == tuned
    assert tuned["constant"].parameters["E"] == make_policy("constant", problem.simulation()).E
    # a named folder comes first
    tune(problem, ["interval"], folder=tmp_path / "other", runs=tmp_path / "runs", **FEW)
    assert list(read_tuned("shop", tmp_path / "other")) == ["interval"]
    with pytest.raises(ConfigError, match=r"constant has no parameters in .*other/shop\.toml.* --parameters .*other`"):
        make_policy("constant", problem.simulation(), tmp_path / "other")


def test_a_users_program_does_not_use_parameters_of_a_namesake_example(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert make_policy("constant", find_problem(str(EXAMPLES / "plate_g82.nc"), parts=30).simulation()).name
    with pytest.raises(ConfigError, match=r"constant has no parameters in runs/parameters/plate_g82_x30\.toml"):
        make_policy("constant", find_problem(own_program(tmp_path), parts=30).simulation())


@pytest.mark.parametrize("name", ["shop.toml", "my shop.toml", "plate_g82.nc"])
def test_an_untuned_policy_of_a_users_file_names_the_tuning_command(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    own_program(tmp_path)
    for shop in ("shop.toml", "my shop.toml"):
        (tmp_path / shop).write_text(TASK, encoding="utf-8")
    with pytest.raises(ConfigError) as raised:
        make_policy("mpc", find_problem(name).simulation())
    command, rest = re.search("`python -m agents (.+)`(.*)", str(raised.value)).groups()
    called = []
    monkeypatch.setattr("agents.tuning.rule_tuning.tune", lambda *given, **others: called.append(given) or {})
    app(shlex.split(command), standalone_mode=False)
    assert called == [(find_problem(name), ["full_state_rule"])]
    assert rest == (" with the same --job and --parts" if name.endswith(".nc") else "")
