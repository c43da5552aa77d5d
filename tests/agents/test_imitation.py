from pathlib import Path

import numpy as np
import pytest
import torch

from agents.learning import imitation
from agents.learning.checkpoint import Training, read_checkpoint, write_checkpoint
from agents.learning.imitation import WORST, ClonedPPO, CostPlanner, Teacher, cheapest
from agents.learning.saving import save_policy
from agents.learning.settings import settings_for
from agents.learning.training_env import LearnerVecEnv
from grind_env.envs.tables import Outcome
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision, all_choices
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.planners.known_state import ModelPredictive
from grind_env.policies.policy import reveal
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy
from tests.policies.optimum import exact_optimum

PROBLEM, RUSH = find_problem("oracle6"), find_problem("rush")
ORACLE, PLATES = PROBLEM.simulation(), find_problem("power_limited").simulation()
COST = Outcome._fields.index("cost")
ENVS = 32


def cloned(labels: int, steps: int, envs: int = ENVS, **arguments: object) -> ClonedPPO:
    env = LearnerVecEnv(PROBLEM, envs)
    model = ClonedPPO(
        "MlpPolicy",
        env,
        labels=labels,
        policy_kwargs={"net_arch": [32]},
        n_steps=6,
        batch_size=6 * envs,
        seed=1,
        device="cpu",
        **arguments,
    )
    env.seed(100_000)
    model.learn(steps)
    return model


@pytest.mark.parametrize("problem", [PROBLEM, RUSH], ids=lambda problem: problem.name)
def test_the_cost_of_a_choice_is_that_of_grinding_it_and_then_by_the_rule(problem):
    # in the stocks, lots and due dates that do come
    simulation = problem.simulation()
    task, rule = simulation.task, make_policy("full_state_rule", simulation)
    start = start_episodes(simulation, [3])
    choices = all_choices(task, 5)
    planner = CostPlanner(rule, horizon=task.blocks)
    planner.begin(simulation, 1)
    costs = planner.costs(reveal("future", simulation, start), choices)[0]
    for k in range(0, len(choices.speeds), 5):
        episodes = start.pick([0])
        rule.begin(simulation, 1)
        decision = Decision(choices.speeds[k : k + 1], choices.executions[k : k + 1])
        total = 0.0
        for _ in range(task.blocks):
            total += simulation.step(episodes, *decision)[0][0, COST]
            if not simulation.over(episodes)[0]:
                decision = rule.act(np.zeros((1, 0), np.float32), reveal("state", simulation, episodes))
        assert costs[k] == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize(("problem", "foresight"), [(PROBLEM, False), (RUSH, False), (RUSH, True)])
def test_the_best_label_is_the_decision_of_the_planner(problem, foresight):
    simulation = problem.simulation()
    episodes = start_episodes(simulation, episode_seeds("training", 3))
    levels = len(LearnerVecEnv(problem, 1).view.codec.levels)
    teacher = Teacher(simulation, levels, horizon=5, temperature=0.1, foresight=foresight)
    planner = ModelPredictive(make_policy("full_state_rule", simulation), horizon=5, speeds=levels)
    teacher.begin(3)
    planner.begin(simulation, 3)
    view = LearnerVecEnv(problem, 1).view
    for _ in range(4):
        worse = teacher.labels(episodes)
        assert worse.min(axis=(1, 2)) == pytest.approx(0.0)
        assert worse.max() <= WORST
        mine = view.decide(cheapest(worse))
        shown = reveal("future" if foresight else "state", simulation, episodes)
        theirs = planner.act(np.zeros((3, 0), np.float32), shown)
        assert np.array_equal(mine.executions, theirs.executions)
        # the planner looks between the levels, too
        step = np.log(view.codec.levels[1] / view.codec.levels[0])
        assert np.abs(np.log(mine.speeds / theirs.speeds)).max() < 1.1 * step
        simulation.step(episodes, *mine)


def test_without_a_horizon_the_labels_are_the_rule():
    episodes = start_episodes(PLATES, episode_seeds("training", 5))
    teacher = Teacher(PLATES, 24, horizon=0, temperature=0.1, foresight=False)
    teacher.begin(5)
    worse = teacher.labels(episodes)
    likely = np.exp(-worse / 0.1)
    likely /= likely.sum(axis=(1, 2), keepdims=True)
    rule = make_policy("full_state_rule", PLATES)
    rule.begin(PLATES, 5)
    decision = rule.act(np.zeros((5, 0), np.float32), reveal("state", PLATES, episodes))
    levels = np.unique(teacher.choices.speeds)
    assert np.exp(likely.sum(axis=2) @ np.log(levels)) == pytest.approx(decision.speeds, rel=1e-5)
    assert likely.sum(axis=1).argmax(axis=1).tolist() == decision.executions.tolist()
    assert ((likely.sum(axis=2) > 1e-6).sum(axis=1) <= 2).all()


def test_a_clone_of_the_planner_finds_the_optimum_of_oracle6(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    # as many updates as in a long training
    monkeypatch.setattr(imitation, "BATCH", 8)
    rounds, envs = 3, 8
    model = cloned(rounds * envs * ORACLE.task.blocks, rounds * envs * ORACLE.task.blocks, envs)
    assert model.num_timesteps == rounds * envs * ORACLE.task.blocks
    save_policy(tmp_path / "clone.safetensors", model, ORACLE, "bc", settings_for("ppo", PROBLEM.name, tmp_path))
    cost = run_seeds(load_policy(tmp_path / "clone.safetensors"), ORACLE, [0]).cost[0]
    planner = run_seeds(make_policy("mpc", ORACLE), ORACLE, [0]).cost[0]
    assert planner == pytest.approx(exact_optimum(ORACLE).cost)
    assert cost <= 1.01 * planner


def test_the_critic_knows_what_the_student_earns(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(imitation, "BATCH", 8)  # as many updates as in a long training
    model = cloned(labels=3 * ENVS * ORACLE.task.blocks, steps=3 * ENVS * ORACLE.task.blocks)
    first = torch.as_tensor(model.features[-1][:ENVS])
    with torch.no_grad():
        known = model.policy.predict_values(first).mean().item()
    assert known == pytest.approx(model.returns[:ENVS].mean(), abs=0.3)


def test_the_returns_are_the_discounted_rewards_of_the_round():
    # the expert grinds the first one, and its decisions are the best labels
    model = cloned(ENVS * ORACLE.task.blocks, ENVS * ORACLE.task.blocks)
    decisions = LearnerVecEnv(PROBLEM, 1).view.decide(cheapest(model.labelled[0][::ENVS]))
    episodes = start_episodes(ORACLE, [0])
    costs = [ORACLE.step(episodes, *(part[k : k + 1] for part in decisions))[0][0, COST] for k in range(6)]
    rewards = 1.0 - np.array(costs) / ORACLE.task.reference_cost
    assert model.returns[0] == pytest.approx((model.gamma ** np.arange(6) * rewards).sum(), abs=1e-6)
    assert model.returns[-1] == pytest.approx(rewards[-1], rel=1e-5)


def test_what_is_best_on_average_is_learned_even_if_it_is_never_the_best(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(imitation, "BATCH", 16)
    model = cloned(ENVS * ORACLE.task.blocks, ENVS * ORACLE.task.blocks)
    seen = model.features[0][:1]
    # two states that look the same: what is best in one scraps the part in the other
    one = np.full(model.labelled[0].shape[1:], WORST, np.float32)
    other = one.copy()
    one[0, 0], one[1, 0] = 0.0, 0.3
    other[2, 0], other[1, 0] = 0.0, 0.3
    model.features = [np.repeat(seen, 256, axis=0)]
    model.labelled = [np.stack([one, other] * 128)]
    model.returns = np.zeros(256, np.float32)
    model.train()
    assert model.predict(seen[0], deterministic=True)[0].tolist() == [1, 0]


def test_after_its_labels_it_goes_on_as_ppo():
    labels = ENVS * ORACLE.task.blocks
    clone, further = cloned(labels, labels), cloned(labels, 3 * labels)
    assert clone.features and not further.features
    assert further.num_timesteps == 3 * labels
    before, after = (model.policy.action_net.weight.detach().numpy() for model in (clone, further))
    change = np.abs(after - before).max()
    assert 0.0 < change < 0.1


def test_interrupted_cloning_goes_on_to_the_same_agent(tmp_path: Path):
    labels = 2 * ENVS * ORACLE.task.blocks
    whole = cloned(labels, labels + ENVS * ORACLE.task.blocks)
    half = cloned(labels, labels // 2)
    write_checkpoint(tmp_path / "half", Training(half, [], {}))
    np.random.seed(0)
    torch.manual_seed(99)
    again = read_checkpoint(tmp_path / "half").model
    again.learn(labels, reset_num_timesteps=False)
    assert again.num_timesteps == whole.num_timesteps
    for one, other in zip(whole.policy.parameters(), again.policy.parameters(), strict=True):
        assert torch.equal(one, other)


def test_only_a_grid_is_labelled(tmp_path: Path):
    settings = settings_for("sac", PROBLEM.name, tmp_path)
    with pytest.raises(GrindError, match="set actions to 'grid'"):
        ClonedPPO("MlpPolicy", LearnerVecEnv(PROBLEM, 2, settings.memory, settings.actions))
