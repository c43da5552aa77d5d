"""`grind evaluate` and `grind play` as users type them."""

import csv
import json
import sys
from pathlib import Path

import pytest

import grind_env
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.evaluation import run_seeds as run
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.rules import Fixed
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).with_name("examples")


def test_one_policy_is_evaluated(tmp_path: Path, grind: Grind) -> None:
    command = ("evaluate", "--task", "oracle6", "--episodes", 2, "--policy", "constant")
    status, out, err = grind(*command, "--json")
    answer = json.loads(out)
    assert (status, err) == (0, "")
    assert (answer["E"], answer["D"], answer["paired"]) == (9000.0, 1.0, True)
    assert (answer["seeds"], answer["split"]) == ("evaluation", "all")
    assert (answer["env"], answer["name"]) == ("grind/Oracle6-v0", "oracle6")
    status, out, _ = grind(*command, "--csv", tmp_path / "episodes.csv")
    assert status == 0
    with (tmp_path / "episodes.csv").open(encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["seed"]) for row in rows] == list(episode_seeds("evaluation", 2))
    total, good = (sum(float(row[name]) for row in rows) for name in ("cost, $", "good parts"))
    assert total / good == pytest.approx(answer["cost_per_good_part"])
    assert "$ per good part" in out and f"score {answer['score']:.1f}" in out


@pytest.mark.parametrize("option", ["--env", "--task", "--program"])
@pytest.mark.parametrize("name", ["reciprocation", "grind/WidePlates-v0"])
def test_every_option_for_an_environment_gives_the_same_evaluation(option: str, name: str, grind: Grind) -> None:
    status, out, _ = grind("evaluate", option, name, "--policy", "E12000D1", "--episodes", 2, "--json")
    problem = find_problem(name)
    wanted = run(Fixed(12_000.0, 1), problem.simulation(), episode_seeds("evaluation", 2))
    assert status == 0
    assert json.loads(out)["cost_per_good_part"] == pytest.approx(wanted.cost.sum() / wanted.good.sum())


def test_a_task_file_is_evaluated(tmp_path: Path, grind: Grind) -> None:
    path = tmp_path / "shop.toml"
    path.write_text('base = "oracle6"\nblocks = 3\n', encoding="utf-8")
    status, out, _ = grind("evaluate", "--task", path, "--policy", "E9000D1", "--episodes", 2, "--json")
    answer = json.loads(out)
    assert (status, answer["env"], answer["name"]) == (0, "grind/Task-v0", "shop")
    assert "score" not in answer
    wanted = run(Fixed(9000.0, 1), find_problem(str(path)).simulation(), episode_seeds("evaluation", 2))
    assert answer["cost_per_good_part"] == pytest.approx(wanted.cost.sum() / wanted.good.sum())


BAD = {
    "a misspelt id": (("--env", "grind/JobShp-v0"), "(did you mean grind/JobShop-v0?)"),
    "a misspelt policy": (("--policy", "look_ahed"), "(did you mean look_ahead?)"),
    "no task file": (("--task", "no_such.toml"), "no_such.toml"),
    "a task file that is none": (("--task", "junk.toml"), "junk.toml"),
    "a policy of other environments": (
        ("--env", "reciprocation", "--policy", "constant_per_kind"),
        "there is no policy 'constant_per_kind' (did you mean constant?) for reciprocation",
    ),
    "no agent": (("--policy", "no_such.safetensors"), "there is no trained agent at no_such.safetensors"),
    "no E": (("--policy", "E99000D1"), "E99000D1: E is 99000 mm/min, but power_limited has 3000 to 30000"),
    "E in m/min": (("--policy", "E9D1"), "E9D1: E is 9 mm/min (did you mean 9000?), but power_limited has"),
    "no D": (("--policy", "E9000D7"), "E9000D7: D is 7, but power_limited has 0 to 3"),
    "nothing tuned": (("--policy", "mpc", "--parameters", "no_such"), "full_state_rule has no parameters in no_such"),
    "a program without a job": (("--program", "JOBLESS"), "jobless.toml"),
    "a program that is none": (("--program", "JUNK", "--job", str(EXAMPLES / "plate_g82.toml")), "junk.nc"),
}


@pytest.mark.parametrize("command", ["evaluate", "play"])
@pytest.mark.parametrize(("words", "sentence"), BAD.values(), ids=BAD)
def test_a_users_mistake_gives_one_sentence(
    command: str, words: tuple[str, ...], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, grind: Grind
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("jobless.nc").write_text((EXAMPLES / "plate_g82.nc").read_text(encoding="utf-8"), encoding="utf-8")
    Path("junk.nc").write_text("G82 X[ I\n", encoding="utf-8")
    Path("junk.toml").write_text("kinds = 3\n", encoding="utf-8")
    words = tuple({"JOBLESS": "jobless.nc", "JUNK": "junk.nc"}.get(word, word) for word in words)
    given = words if "--policy" in words else (*words, "--policy", "handbook")
    status, out, err = grind(command, *given)
    assert (status, out) == (2, "")
    assert sentence in err
    assert err.startswith("grind: ") and err.count("\n") == 1


def test_play_draws_contexts_of_the_named_split(tmp_path: Path, grind: Grind) -> None:
    simulation = find_problem("power_limited").simulation()
    for split in ("all", "interpolation"):
        words = ("--seed", 3_000_000, "--split", split, "--output", tmp_path / f"{split}.nc")
        status, out, _ = grind("play", "--policy", "E12000D1", *words)
        (cost,) = run(Fixed(12_000.0, 1), simulation, [3_000_000], split).cost
        assert (status, f"seed 3000000, split {split}: {cost:.2f} $" in out) == (0, True)
    assert (tmp_path / "all.toml").read_bytes() != (tmp_path / "interpolation.toml").read_bytes()


def test_a_users_policy_is_imported_from_the_working_folder(
    grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = "from grind_env.policies.scripted.rules import Fixed\n\nown = Fixed(E=9000.0, D=1, name='own')\n"
    (tmp_path / "policy_of_ones_own.py").write_text(code, encoding="utf-8")
    monkeypatch.setattr("sys.path", [each for each in sys.path if each])  # as for the command that pip installs
    monkeypatch.chdir(tmp_path)
    status, out, _ = grind("evaluate", "--policy", "policy_of_ones_own:own", "--task", "oracle6", "--episodes", 2)
    assert status == 0 and out.startswith("own in oracle6")
