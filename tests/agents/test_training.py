import json
import math
import pickle
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
import typer
from safetensors import safe_open
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from agents.budgets import TUNING_EPISODES as TUNED_ON
from agents.commands.train import register
from agents.learning import batches
from agents.learning import train as training
from agents.learning.curve import SPENT, Point, curve_path, read_curve, seconds_to, write_curve
from agents.learning.settings import CONFIGS, DEFAULTS, LAST_SEED, SEED_STRIDE, TRAINING_SEEDS, settings_folder
from agents.learning.train import fingerprint, new_model, train, trained_agent
from agents.learning.validation import EPISODES, Validation
from grind_env import evaluate
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.errors import GrindError
from grind_env.policies.evaluation import SEEDS, SEEDS_EACH, episode_seeds, run_seeds
from grind_env.policies.held import on
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import UNIFORM_PLANS, make_policy
from grind_env.policies.tuned import ConfigError
from grind_env.scores import reference
from tests.policies.harness import changed

PROBLEM = find_problem("oracle6")
SIMULATION = PROBLEM.simulation()
TINY = replace(
    DEFAULTS["ppo"], steps=144, envs=4, hidden=(8,), hyper={**DEFAULTS["ppo"].hyper, "n_steps": 6, "batch_size": 12}
)


@pytest.mark.bits
def test_training_is_reproducible_and_its_agent_sees_measurements_only(tmp_path: Path):
    paths = [train(PROBLEM, "ppo", 3, TINY, tmp_path / name, quiet=True) for name in ("one", "two")]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert load_policy(paths[0]).sees == "measurements"
    other = train(PROBLEM, "ppo", 4, TINY, tmp_path / "one", quiet=True)
    assert other.read_bytes() != paths[0].read_bytes()


def test_the_curve_tells_what_the_agent_costs_and_where_the_time_went(tmp_path: Path):
    path = train(PROBLEM, "ppo", 3, TINY, tmp_path, quiet=True)
    points = read_curve(curve_path(path))
    assert [point.steps for point in points] == list(range(24, 145, 24))
    cost = run_seeds(load_policy(path), SIMULATION, episode_seeds("validation", EPISODES)).cost.mean()
    assert points[-1].cost == pytest.approx(cost)
    for point in points:
        spent = sum(getattr(point, name) for name in SPENT)
        assert all(getattr(point, name) >= 0.0 for name in SPENT)
        assert 0.0 < spent <= point.seconds
        assert point.environment > 0.0


def test_on_other_machines_an_agent_in_training_holds_the_model_as_it_does_later(tmp_path: Path):
    path = train(on(PROBLEM, "public"), "ppo", 3, TINY, tmp_path, quiet=True)
    last = read_curve(curve_path(path))[-1]
    later = evaluate(load_policy(path), PROBLEM, plant="public", seeds="validation", episodes=EPISODES)
    assert last.cost == pytest.approx(later.evaluation.cost.mean()) and math.isnan(last.score)
    simulation = on(PROBLEM, "public").simulation()
    again = pickle.loads(pickle.dumps(simulation))
    assert (again.process, again.gauge, again.plants) == (simulation.process, simulation.gauge, simulation.plants)


def test_validation_scores_as_the_reference_scores_do():
    problem = find_problem("power_limited")
    validation, simulation = Validation(problem, 16), problem.simulation()
    costs = {name: validation.score(make_policy(name, simulation)) for name in (*UNIFORM_PLANS, "adaptive_rule")}
    assert max(costs[name][1] for name in UNIFORM_PLANS) == pytest.approx(0.0)
    scale = reference("grind/PowerLimited-v0")
    fixed = min(costs[name][0] for name in UNIFORM_PLANS)
    saved = (fixed - costs["adaptive_rule"][0]) / fixed
    assert costs["adaptive_rule"][1] == pytest.approx(100.0 * saved / (1.0 - scale.J_plan / scale.J_fix))


def points(*scores: float) -> list[Point]:
    zeros = dict.fromkeys(("reward", "cost", *SPENT), 0.0)
    return [Point(steps=k, seconds=10.0 * k, score=score, **zeros) for k, score in enumerate(scores, start=1)]


@pytest.mark.parametrize(
    ("scores", "seconds"),
    [
        ((1.0, 50.0, 96.0, 97.0, 100.0), 30.0),
        ((96.0, 40.0, 100.0), 30.0),
        ((99.0, 99.0, 99.0), 10.0),
        ((5.0,), 10.0),
        # 5 % of 40 is 2: from -42 on
        ((-43.0, -41.9, -41.0, -40.0), 20.0),
        ((-40.0, -40.0), 10.0),
        ((-30.0, -43.0, -40.0), 30.0),
    ],
)
def test_the_time_to_a_score_is_when_it_is_reached_for_good(scores: tuple[float, ...], seconds: float):
    assert seconds_to(points(*scores)) == seconds


def test_a_curve_is_read_as_it_was_written(tmp_path: Path):
    path = tmp_path / "curve.csv"
    written = points(1.0, 1.0 / 3.0, -2.5)
    write_curve(path, written)
    assert read_curve(path) == written
    write_curve(path, points(math.nan))
    assert math.isnan(read_curve(path)[0].score)
    path.write_text("steps,score\n1,2\n")
    with pytest.raises(ConfigError, match=r"curve\.csv is no learning curve"):
        read_curve(path)
    with pytest.raises(ConfigError):
        read_curve(tmp_path / "none.csv")


def test_tensorboard_shows_metrics_of_the_algorithm_and_terms_of_the_reward(tmp_path: Path):
    path = train(PROBLEM, "ppo", 3, TINY, tmp_path, quiet=True)
    events = EventAccumulator(str(tmp_path / "oracle6" / "tensorboard" / path.stem))
    events.Reload()
    tags = set(events.Tags()["scalars"])
    assert {"train/loss", "reward/time", "reward/dress", "reward/scrap", "cost/part", "blocks/burnt_share"} <= tags
    assert {"actions/E_mean", "actions/D_mean", "time/environment_share", "validation/score"} <= tags
    assert {event.step for event in events.Scalars("reward/time")} == set(range(24, 145, 24))
    shares = [events.Scalars(f"time/{name}_share")[-1].value for name in SPENT]
    assert 0.0 < sum(shares) <= 1.0


def test_an_agent_of_the_same_settings_is_kept_and_a_fresh_one_is_the_same(tmp_path: Path):
    path = train(PROBLEM, "ppo", 3, TINY, tmp_path, quiet=True)
    made, text = path.stat().st_mtime_ns, path.read_bytes()
    assert train(PROBLEM, "ppo", 3, TINY, tmp_path, quiet=True) == path
    assert path.stat().st_mtime_ns == made
    train(PROBLEM, "ppo", 3, TINY, tmp_path, fresh=True, quiet=True)
    assert path.stat().st_mtime_ns != made
    assert path.read_bytes() == text


def test_the_name_of_an_agent_stands_for_all_that_decides():
    names = {
        fingerprint(PROBLEM, "ppo", TINY, 0),
        fingerprint(PROBLEM, "ppo", TINY, 1),
        fingerprint(PROBLEM, "ppo_stack", TINY, 0),
        fingerprint(PROBLEM, "ppo", replace(TINY, steps=145), 0),
        fingerprint(PROBLEM, "ppo", replace(TINY, split="all"), 0),
        fingerprint(PROBLEM, "ppo", replace(TINY, hyper={**TINY.hyper, "gamma": 0.5}), 0),
        fingerprint(find_problem("slot"), "ppo", TINY, 0),
        fingerprint(changed(PROBLEM, reference_cost=2.0), "ppo", TINY, 0),
    }
    assert len(names) == 8
    assert fingerprint(PROBLEM, "ppo", replace(TINY, hyper=dict(reversed(TINY.hyper.items()))), 0) in names


@pytest.mark.parametrize("seed", [0, 3, LAST_SEED])
def test_an_agent_trains_on_inner_contexts_and_on_seeds_of_its_own(seed: int):
    problem, plates = find_problem("power_limited"), gym.make_vec("grind/PowerLimited-v0", num_envs=4)
    model = new_model(problem, "ppo", seed, TINY)
    assert model.env is not None
    features = np.asarray(model.env.reset())
    seeds = [TRAINING_SEEDS + SEED_STRIDE * seed + i for i in range(4)]
    observations, _ = plates.reset(seed=seeds, options={"split": "inner"})
    # the features begin with what is measured
    assert np.array_equal(features[:, : observations.shape[1]], observations)
    assert len(np.unique(observations, axis=0)) == 4
    # far from the seeds of tuning, validation and evaluation
    assert SEEDS["training"] + SEEDS_EACH >= seeds[-1] >= TRAINING_SEEDS > TUNED_ON


def test_the_split_of_a_training_can_be_named():
    problem, plates = find_problem("power_limited"), gym.make_vec("grind/PowerLimited-v0", num_envs=4)
    model = new_model(problem, "ppo", 0, replace(TINY, split="all"))
    assert model.env is not None
    observations, _ = plates.reset(seed=[TRAINING_SEEDS + i for i in range(4)])
    assert np.array_equal(np.asarray(model.env.reset())[:, : observations.shape[1]], observations)
    with pytest.raises(GrindError, match="split is 'train', which is called 'inner' now"):
        replace(TINY, split="train")


@pytest.mark.parametrize("seed", [-1, LAST_SEED + 1])
def test_a_seed_beyond_those_of_training_is_refused(seed: int, tmp_path: Path):
    with pytest.raises(GrindError, match="training has seeds from 0 to"):
        trained_agent(PROBLEM, "ppo", seed, 20, tmp_path)


@pytest.fixture
def app() -> typer.Typer:
    application = typer.Typer()
    application.callback()(lambda: None)
    register(application)
    return application


def test_the_train_command_trains_and_keeps(app: typer.Typer, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    arguments = ["train", "--task", "oracle6", "--kind", "dqn", "--steps", "400", "--runs", str(tmp_path)]
    app(arguments, standalone_mode=False)
    (path,) = (tmp_path / "oracle6").glob("dqn-0-*.safetensors")
    assert f"agent trained on split inner: {path}\n" in capsys.readouterr().out
    made = path.stat().st_mtime_ns
    app(arguments, standalone_mode=False)
    assert path.stat().st_mtime_ns == made
    app([*arguments, "--split", "all"], standalone_mode=False)
    (other,) = set((tmp_path / "oracle6").glob("dqn-0-*.safetensors")) - {path}
    assert f"agent trained on split all: {other}\n" in capsys.readouterr().out
    splits = {json.loads(text)["settings"]["split"] for text in described(tmp_path / "oracle6")}
    assert splits == {"inner", "all"}


def test_an_interrupted_training_says_how_it_goes_on(
    app: typer.Typer, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "write_checkpoint", interrupted)
    with pytest.raises(SystemExit) as ended:
        app(["train", "--task", "oracle6", "--steps", "40000", "--runs", str(tmp_path)])
    assert ended.value.code == 130
    (line,) = capsys.readouterr().err.splitlines()
    assert line == "agents: interrupted; the same command goes on from the last checkpoint"


def test_large_and_small_batches_are_drawn_beside_each_other(
    app: typer.Typer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(batches, "SMALL_ENVS", 1)
    app(
        ["train", "--task", "oracle6", "--steps", "200", "--runs", str(tmp_path), "--compare-batches"],
        standalone_mode=False,
    )
    assert (tmp_path / "oracle6" / "batches.png").read_bytes().startswith(b"\x89PNG")
    sizes = {json.loads(text)["settings"]["hyper"]["batch_size"] for text in described(tmp_path / "oracle6")}
    assert sizes == {DEFAULTS["ppo"].hyper["batch_size"], 64}


def described(folder: Path) -> list[str]:
    texts = []
    for path in folder.glob("*.safetensors"):
        with safe_open(path, "numpy") as file:
            texts += list((file.metadata() or {}).values())
    return texts


@pytest.mark.parametrize("kind", ["ppo", "dqn"])
def test_where_no_belief_can_follow_it_is_said_what_can_be_trained(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(BlockSimulation, "compiled", False)
    with pytest.raises(
        GrindError, match=f"{kind} remembers a belief.*oracle6 has none: train ppo_stack or recurrent_ppo"
    ):
        trained_agent(find_problem("oracle6"), kind, 0, 100, tmp_path, quiet=True)


def test_settings_that_were_tuned_for_a_users_file_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "shop.toml"
    path.write_text('base = "oracle6"', encoding="utf-8")
    task = find_problem(str(path)).simulation().task
    assert settings_folder(task) == Path("runs/parameters/learning")
    assert settings_folder(SIMULATION.task) == CONFIGS
    settings_folder(task).mkdir(parents=True)
    (settings_folder(task) / "shop.toml").write_text("[ppo]\nhidden = [0]\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="hidden is"):
        trained_agent(find_problem("shop.toml"), "ppo", 0, 100, tmp_path, quiet=True)
