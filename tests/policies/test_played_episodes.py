import re
from pathlib import Path

import pytest

from grind_env.envs.task_names import CORE, shipped_names
from grind_env.errors import GrindError
from grind_env.policies import policy_lookup
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.played_episodes import play
from grind_env.policies.policy_lookup import SHIPPED, chosen_policy, named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import TRAINED, make_policy
from grind_env.policies.scoring import evaluate
from tests.command import status
from tests.policies.untrained import save, untrained

PROBLEM, PLATES, SLOT = (find_problem(name) for name in ("oracle6", "power_limited", "slot"))
SIMULATION = PROBLEM.simulation()
SEED, TEST_SEED = 2_000_007, 3_000_007
CYCLE = re.compile(r"^G82 .*E(\d+)\. P\d+ D(\d+)$", re.MULTILINE)


@pytest.fixture
def agent(tmp_path: Path) -> Path:
    path = tmp_path / "plain_gru" / "oracle6.safetensors"
    save(path, untrained(PROBLEM), SIMULATION)
    return path


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        ("adaptive_rule", SEED),
        ("adaptive_rule", TEST_SEED),
        *((name, SEED) for name in ("full_state_rule", "hindsight", "E9000D1")),
    ],
)
def test_a_played_episode_equals_its_evaluation(name: str, seed: int):
    problem = PLATES if name == "adaptive_rule" else PROBLEM
    simulation = problem.simulation()
    played = play(chosen_policy(name, simulation), problem, seed)
    run = run_seeds(chosen_policy(name, simulation), simulation, [seed])
    assert played.cost == pytest.approx(run.cost[0])
    assert (played.good, played.finished) == pytest.approx((run.good[0], run.finished[0]))
    assert played.dresses == run.executions.sum()
    blocks = CYCLE.findall(played.program)
    assert [float(speed) for speed, _ in blocks] == run.speeds[0].tolist()
    assert [float(dresses) for _, dresses in blocks] == run.executions[0].tolist()


def test_the_bundled_policy_is_the_default(
    agent: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(policy_lookup, "SHIPPED", agent.parents[1])
    assert chosen_policy(None, SIMULATION).name == "plain_gru"
    assert capsys.readouterr().err == ""
    assert chosen_policy(None, SLOT.simulation()).name == "adaptive_rule"
    said = capsys.readouterr().err
    assert said == "no trained policy is shipped for slot: adaptive_rule plays in its place\n"
    with pytest.raises(GrindError, match="was trained for oracle6, not for slot"):
        chosen_policy(str(agent), SLOT.simulation())


def test_bundled_policies_are_small_and_fit_their_tasks():
    found = [path for name in TRAINED for path in (SHIPPED / name).iterdir()]
    assert len(found) >= 2 * len(CORE)
    for path in found:
        assert path.stem in shipped_names() and path.stat().st_size < 1_000_000
        assert load_policy(path, simulation=find_problem(path.stem).simulation())


def test_core_tasks_have_every_bundled_agent():
    for task in CORE:
        simulation = find_problem(task).simulation()
        for name in TRAINED:
            policy = named_policy(name, simulation)
            assert (policy.name, policy.sees) == (name, "measurements")
    with pytest.raises(GrindError, match="no policy 'robust' comes with the package for oracle6: name a rule"):
        named_policy("robust", find_problem("oracle6").simulation())


@pytest.mark.nightly
def test_a_robust_policy_is_much_cheaper_on_out_of_model_machines():
    costs = {
        (name, plant): evaluate(name, "power_limited", plant=plant, episodes=512).evaluation.cost.mean()
        for name in TRAINED
        for plant in ("public", None)
    }
    assert costs["robust", "public"] < 0.75 * costs["plain_gru", "public"]
    assert costs["robust", None] < 1.1 * costs["plain_gru", None]


def test_the_command_shows_the_episode_and_prints_the_program(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    played = play(make_policy("constant", SIMULATION), PROBLEM, SEED)

    def printed(*options: str) -> str:
        assert status("play", "--env", "oracle6", "--policy", "constant", "--seed", SEED, *options) == 0
        return capsys.readouterr().out

    shown = printed("--no-window")
    assert played.program in shown
    assert f"constant, seed {SEED}, split all: {played.cost:.2f} $ for " in shown
    for speed, dresses in CYCLE.findall(played.program):
        # the text picture of each block
        assert re.search(rf"E{speed}\. P\d+ D{dresses}", shown.partition(played.program)[0])
    assert "G82" not in printed("--output", str(tmp_path / "played.nc"))
    assert (tmp_path / "played.nc").read_text("utf-8") == played.program
