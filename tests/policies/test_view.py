import numpy as np
import pytest
from gymnasium import spaces

from grind_env.envs import task_env_factory
from grind_env.envs.observation_memory import BeliefMemory, belief_entries
from grind_env.policies.learned.agent_spaces import STACKED, LearnerView, MemoryKind
from grind_env.policies.scripted.rules import REFERENCE_AREA
from grind_env.policies.scripted.sharpness_estimator import SharpnessEstimator
from tests.policies.harness import simulated

pytestmark = pytest.mark.bits

PLATES = simulated("power_limited")
ENTRIES = len(PLATES.entries)
KINDS: tuple[MemoryKind, ...] = ("belief", "stack", "none")

ESTIMATES = 4


def observations(n: int, blocks: int, seed: int = 3) -> list[np.ndarray]:
    """Return the measurements of `n` episodes under random actions."""
    env = task_env_factory.make_vector(n, observation="measured", autoreset_mode="SameStep")
    seen = [env.reset(seed=seed)[0]]
    rng = np.random.default_rng(seed)
    for _ in range(blocks):
        seen.append(env.step(rng.uniform(-1, 1, (n, 2)).astype(np.float32))[0].copy())
    return seen


@pytest.mark.parametrize("memory", KINDS)
def test_features_do_not_depend_on_other_episodes(memory: MemoryKind):
    seen = observations(3, 12)
    together = LearnerView(PLATES, memory)
    together.begin(3)
    shown = [together.features(each) for each in seen]
    for i in range(3):
        alone = LearnerView(PLATES, memory)
        alone.begin(1)
        for each, features in zip(seen, shown, strict=True):
            assert np.array_equal(alone.features(each[i : i + 1])[0], features[i])
            assert alone.observation_space.contains(features[i])


@pytest.mark.parametrize("memory", KINDS)
def test_a_restart_clears_the_memory_of_its_episode_only(memory: MemoryKind):
    seen, later = observations(2, 6), observations(2, 4, seed=8)
    view, plain, fresh = (LearnerView(PLATES, memory) for _ in range(3))
    for each in (view, plain, fresh):
        each.begin(2)
    for each in seen:
        view.features(each)
        plain.features(each)
    first = np.array([True, False])
    view.restart(first)
    for each in later:
        shown = view.features(each)
        assert np.array_equal(shown[0], fresh.features(each)[0])
        assert np.array_equal(shown[1], plain.features(each)[1])


@pytest.mark.parametrize("memory", KINDS)
def test_episodes_outside_the_mask_remember_nothing_new(memory: MemoryKind):
    seen, strange = observations(2, 6), observations(2, 6, seed=9)
    view, plain = LearnerView(PLATES, memory), LearnerView(PLATES, memory)
    view.begin(2)
    plain.begin(2)
    second = np.array([False, True])
    for each, other in zip(seen, strange, strict=True):
        shown = view.features(each)
        assert np.array_equal(shown[0], plain.features(each)[0])
        view.features(other, second)


def test_the_belief_view_joins_the_estimates_and_the_belief_of_the_wrapper():
    view, belief, estimator = LearnerView(PLATES, "belief"), BeliefMemory(PLATES, 16), SharpnessEstimator(PLATES)
    for each in (view, belief, estimator):
        each.begin(2)
    scale = belief_entries()[0].scale
    for each in observations(2, 10):
        shown = view.features(each)
        assert np.array_equal(shown[:, :ENTRIES], each)
        wear_flat = estimator.update(each).wear_flat
        assert np.array_equal(shown[:, ENTRIES], np.log(wear_flat / REFERENCE_AREA).astype(np.float32))
        wrapped = belief.take(each, None, np.ones(2, bool))
        assert np.array_equal(shown[:, ENTRIES + ESTIMATES : -1], wrapped[:, ENTRIES:])
        believed = scale * wrapped[:, ENTRIES].astype(np.float64)
        assert shown[:, -1] == pytest.approx(np.log(believed / REFERENCE_AREA), abs=1e-5)
    assert shown.shape[1] == ENTRIES + ESTIMATES + len(belief_entries()) + 1


def test_a_stack_shows_the_last_observations_oldest_first():
    view = LearnerView(PLATES, "stack")
    view.begin(2)
    seen = observations(2, 10)
    before = [np.zeros((2, ENTRIES), np.float32)] * (STACKED - 1)
    for k, each in enumerate(seen):
        wanted = np.concatenate([*before, *seen][k : k + STACKED], axis=1)
        assert np.array_equal(view.features(each), wanted)


def test_the_speed_grid_of_a_task_with_levels_equals_the_levels():
    simulation = simulated("oracle6")
    view, task = LearnerView(simulation), simulation.task
    assert view.action_space == spaces.MultiDiscrete([len(task.action.speed_levels or ()), task.action.executions + 1])
    levels = np.arange(len(task.action.speed_levels or ()))
    decision = view.decide(np.stack([levels, np.zeros_like(levels)], axis=1))
    assert decision.speeds.tolist() == [*(task.action.speed_levels or ())]
