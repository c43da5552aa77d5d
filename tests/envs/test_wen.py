"""The Wen problem: published values, known optima, and the contract of its environments."""

import itertools
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from hypothesis import given
from hypothesis import strategies as st

from grind_env.envs.actions import ActionError
from grind_env.envs.contexts import ContextError
from grind_env.envs.tasks import TaskError
from grind_env.envs.wen.actions import HIGH, LOW, action_array, decode
from grind_env.envs.wen.env import WenEnv
from grind_env.envs.wen.judging import judged
from grind_env.envs.wen.model import CASES, Setting, WenVerdict
from grind_env.envs.wen.vector_env import WenVectorEnv
from grind_env.errors import GrindError
from tests.envs.harness import Array, assert_same

pytestmark = pytest.mark.filterwarnings("error")

NUMBER = {name: k for k, name in enumerate(CASES)}
MODES = list(AutoresetMode)
cases = pytest.mark.parametrize("case", list(CASES))
modes = pytest.mark.parametrize("mode", MODES)


def encode(setting: Setting) -> Array:
    """The action, shape (4,), that chooses a setting."""
    return (2.0 * (np.array(setting) - LOW) / (HIGH - LOW) - 1.0).astype(np.float32)


def verdict(case: str, settings: Any) -> WenVerdict:
    """Verdict with columns, of settings of shape (N, 4)."""
    table = np.atleast_2d(np.asarray(settings, float))
    return WenVerdict(*judged(table, np.full(len(table), NUMBER[case])).T)


def loss(case: str, settings: Any, weight: float = 1.0) -> Array:
    seen = verdict(case, settings)
    return seen.objective + weight * seen.violation


# scenarios, section 4.3: the least COF + v and its setting
OPTIMA = {
    "rough": (-0.22925, (2023.0, 13.148, 0.07424, 0.137)),
    "finish": (0.52242, (2023.0, 22.7, 0.01093, 0.137)),
}

# Vs, Vw, doc, L; CT, WRP, Ra as published: rows whose objective could be recomputed from the formulas
PUBLISHED = [
    ("rough", (2000.0, 19.96, 0.055, 0.044), (6.2, 17.47, 1.74)),  # Wen, Tay & Nee 1992
    ("rough", (2019.35, 12.455, 0.079, 0.136), (7.4, 23.89, 1.796)),  # Rao & Pawar 2010, harmony search
    ("rough", (2023.0, 11.48, 0.089, 0.137), (7.755, 24.45, 1.789)),  # Rao & Pawar 2010, simulated annealing
    ("rough", (2023.0, 11.537, 0.0899, 0.137), (7.742, 24.551, 1.798)),  # Pawar & Rao 2013
    ("finish", (2000.0, 19.99, 0.052, 0.091), (7.7, None, 0.83)),  # Wen, Tay & Nee 1992
]

# the same formulas by another hand (published/wen1992_evaluation_points.csv): Vs, Vw, doc, L; CT, WRP, Ra, U, U*
RECOMPUTED = [
    ("rough", (1365.0, 22.581, 0.1322, 0.064), (6.30476, 20.8433, 3.17876, 14.9545, 21.2914)),
    ("rough", (1103.4, 13.169, 0.0509, 0.0577), (7.17882, 10.06832, 1.86215, 15.40023, 25.96172)),
    ("rough", (1534.8, 11.266, 0.0879, 0.0152), (7.8433, 18.31792, 2.15591, 16.40187, 27.56566)),
    ("finish", (1707.4, 17.549, 0.1364, 0.0874), (8.55875, 24.86336, 1.1747, 22.73491, 61.79703)),
    ("finish", (1148.8, 14.799, 0.0127, 0.1311), (8.77997, 11.43824, 0.83523, 20.92885, 66.74267)),
    ("finish", (1693.7, 22.454, 0.0166, 0.0711), (7.19056, 12.90393, 0.70868, 20.72708, 55.35084)),
]


@pytest.mark.parametrize(("case", "setting", "published"), PUBLISHED)
def test_published_optima_are_reproduced(case: str, setting: Any, published: Any) -> None:
    for value, expected in zip(verdict(case, setting)[:3], published, strict=True):
        assert expected is None or value[0] == pytest.approx(expected, rel=0.008)


@pytest.mark.parametrize(("case", "setting", "expected"), RECOMPUTED)
def test_another_implementation_agrees(case: str, setting: Any, expected: Any) -> None:
    values = [column[0] for column in verdict(case, setting)[:5]]
    assert values == pytest.approx(expected, rel=2e-5)


def test_the_terms_of_the_cost_are_the_published_ones() -> None:
    # at the TLBO row: grinding 3.317, idle and load 2.697, set-up 1.250, dressing 0.003, wheel 0.466, dresser 0.013
    assert verdict("rough", PUBLISHED[3][1]).production_cost[0] == pytest.approx(
        3.317 + 2.697 + 1.250 + 0.003 + 0.466 + 0.013, abs=0.003
    )


def descend(case: str, weight: float, seed: int) -> tuple[Array, float]:
    """Differential evolution (rand-to-best/1/bin) on objective + weight times violation."""
    rng = np.random.default_rng(seed)
    members = rng.uniform(LOW, HIGH, (48, 4))
    value = loss(case, members, weight)
    for _ in range(1500):
        a, b = (members[rng.permutation(48)] for _ in range(2))
        best = members[value.argmin()]
        trial = members + 0.7 * (best - members) + 0.6 * (a - b)
        trial = np.where(rng.random(members.shape) < 0.9, trial, members)
        # a component beyond its bound goes half way to it, so that optima on a bound are reached
        trial = np.where(trial < LOW, 0.5 * (members + LOW), np.where(trial > HIGH, 0.5 * (members + HIGH), trial))
        there = loss(case, trial, weight)
        members[there < value], value = trial[there < value], np.minimum(value, there)
    return members[value.argmin()], float(value.min())


@pytest.mark.parametrize("weight", [1.0, 2.0, 5.0])
@cases
def test_the_optimum_is_the_published_one_and_the_penalty_is_exact(case: str, weight: float) -> None:
    setting, value = descend(case, weight, seed=int(weight))
    best, where = OPTIMA[case]
    assert value == pytest.approx(best, abs=1e-5)
    assert setting.tolist() == pytest.approx(where, rel=1e-3)
    assert verdict(case, setting).violation[0] < 1e-5


@cases
def test_random_settings_and_the_feasible_share_are_the_published_ones(case: str) -> None:
    count = 50_000
    settings = np.random.default_rng(0).uniform(LOW, HIGH, (count, 4))
    values = loss(case, settings)
    mean = {"rough": 0.1478, "finish": 0.8426}[case]
    assert values.mean() == pytest.approx(mean, abs=4 * values.std() / np.sqrt(count))
    assert values.std() / np.sqrt(count) == pytest.approx({"rough": 0.0009, "finish": 0.0007}[case], abs=5e-5)
    feasible = float((verdict(case, settings).violation == 0.0).mean())
    assert feasible == pytest.approx({"rough": 0.289, "finish": 0.252}[case], abs=0.008)
    centre = loss(case, 0.5 * (LOW + HIGH))[0]
    assert centre == pytest.approx({"rough": 0.0744, "finish": 0.8009}[case], abs=1e-4)


def reset_to(env: WenEnv, case: str) -> None:
    while env.case != NUMBER[case]:
        env.reset()


@cases
def test_the_reward_of_the_best_action_is_minus_the_optimum(case: str) -> None:
    env = WenEnv()
    env.reset(seed=0)
    reset_to(env, case)
    best, where = OPTIMA[case]
    observation, reward, terminated, truncated, info = env.step(encode(Setting(*where)))
    assert reward == pytest.approx(-best, abs=2e-4)
    assert observation.tolist() == [float(case == name) for name in CASES]
    assert (terminated, truncated) == (True, False)
    assert sum(info["reward_terms"].values()) == reward
    assert info["cost"] == -info["reward_terms"]["violation"]
    assert [info[name] for name in Setting._fields] == pytest.approx(where, rel=1e-6)
    assert info["production_cost"] == pytest.approx({"rough": 7.2726, "finish": 7.1299}[case], rel=1e-4)


@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_the_action_space_is_the_box_of_the_settings(share: list[float]) -> None:
    setting = Setting(*(LOW + np.array(share) * (HIGH - LOW)).clip(LOW, HIGH))
    assert decode(action_array([encode(setting)], 1))[0] == pytest.approx(list(setting), rel=1e-5)


def test_both_cases_are_drawn_equally_often() -> None:
    env = WenVectorEnv(1000)
    observations, _ = env.reset(seed=3)
    assert (observations.sum(axis=1) == 1.0).all()
    assert abs(observations[:, 0].mean() - 0.5) < 4 * 0.5 / np.sqrt(1000)


BAD_ACTIONS: list[tuple[Any, str]] = [
    (np.zeros(3), "shape"),
    (np.zeros((1, 4)), "shape"),
    (0.5, "shape"),
    (None, "shape"),
    ([0.1, 0.2, [0.3], 0.0], "numbers"),
    (["a", "b", "c", "d"], "numbers"),
    ([np.nan, 0.0, 0.0, 0.0], "nan for Vs"),
    ([0.0, 1.0001, 0.0, 0.0], "1.0001 for Vw"),
    ([0.0, 0.0, -1.5, 0.0], "-1.5 for doc"),
    ([0.0, 0.0, 0.0, np.inf], "inf for L"),
    ([0.0, 0.0, 0.0, 1.0 + 1e-9], "1.000000001 for L"),
    (["0"] * 4, "numbers"),
    ([10**400] * 4, "numbers"),
    (np.zeros(4, complex), "numbers"),
    (np.zeros(4, "m8[s]"), "numbers"),
]


@pytest.mark.parametrize(("action", "part"), BAD_ACTIONS)
def test_a_bad_action_is_refused_and_changes_nothing(action: Any, part: str) -> None:
    env = WenEnv()
    vector = WenVectorEnv(2)
    env.reset(seed=1)
    vector.reset(seed=1)
    for make in (lambda: env.step(action), lambda: vector.step([np.zeros(4), action])):
        with pytest.raises(ActionError) as caught:
            make()
        message = str(caught.value)
        assert "\n" not in message
        assert part in message or "numbers" in message or "shape" in message
    if part == "shape":
        with pytest.raises(ActionError, match=r"^the action has shape .* must have shape \(4,\): Vs, Vw, doc, L$"):
            env.step(action)
    good = np.zeros((2, 4), np.float32)
    env.step(good[0])
    vector.step(good)


def test_stepping_out_of_turn_and_bad_choices_are_refused() -> None:
    env = WenEnv()
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(4))
    env.reset(seed=0)
    env.step(np.zeros(4))
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(4))
    for mode in MODES:
        vector = WenVectorEnv(2, mode)
        with pytest.raises(ResetNeeded):
            vector.step(np.zeros((2, 4)))
        vector.reset(options={"reset_mask": np.array([True, False])})
        with pytest.raises(ResetNeeded):
            vector.step(np.zeros((2, 4)))
    vector.reset()
    vector.step(np.zeros((2, 4)))
    with pytest.raises(ResetNeeded, match="episode 0"):
        vector.step(np.zeros((2, 4)))
    for error, make in (
        (TaskError, lambda: WenEnv(render_mode="svg")),
        (TaskError, lambda: WenVectorEnv(0)),
        (TaskError, lambda: WenVectorEnv(2, "Sometimes")),
        (GrindError, lambda: WenVectorEnv(2).reset(seed=[1, 2, 3])),
        (GrindError, lambda: WenVectorEnv(2).reset(options={"reset_mask": [True, False]})),
    ):
        with pytest.raises(error):
            make()


def both(a: Any, b: Any, call: Any) -> Any:
    result = call(a)
    assert_same(result, call(b))
    return result


def masked_reset(env: Any, mask: list[bool], seed: Any = None) -> Any:
    return env.reset(seed=seed, options={"reset_mask": np.array(mask)})


@pytest.mark.bits
@modes
def test_native_and_sync_give_the_same_bits(mode: AutoresetMode) -> None:
    n = 4
    native, sync = WenVectorEnv(n, mode), SyncVectorEnv([WenEnv] * n, autoreset_mode=mode)
    plan = np.random.default_rng(0).uniform(-1.0, 1.0, (40, n, 4)).astype(np.float32)
    both(native, sync, lambda env: env.reset(seed=5))
    over = np.zeros(n, bool)
    for k, action in enumerate(plan):
        if mode == AutoresetMode.DISABLED and over.any():
            mask = over.tolist()
            both(native, sync, lambda env, mask=mask: masked_reset(env, mask))
        elif k % 7 == 3:  # so that some episodes end a step later than the others
            both(native, sync, lambda env: masked_reset(env, [False, True, False, True], [None, 77, None, None]))
            over = over & np.array([True, False, True, False])
        if mode == AutoresetMode.NEXT_STEP:
            action = np.where(over[:, None], np.float32(np.nan), action)  # which must be ignored
        _, _, over, _, _ = both(native, sync, lambda env, action=action: env.step(action))
    both(native, sync, lambda env: env.reset(seed=[4, None, 2, 1]))
    both(native, sync, lambda env: env.step(plan[0]))
    both(native, sync, lambda env: env.reset())


@modes
def test_results_are_the_callers_and_copies_of_the_env_go_on_alone(mode: AutoresetMode) -> None:
    env = WenVectorEnv(3, mode)
    kept = [env.reset(seed=2)[0]]
    for action in np.random.default_rng(1).uniform(-1.0, 1.0, (6, 3, 4)):
        if mode == AutoresetMode.DISABLED and len(kept) > 1:
            env.reset()
        kept += env.step(action)[:4]
    before = [each.copy() for each in kept]
    twin = pickle.loads(pickle.dumps(env))
    ahead = twin.reset(), twin.step(np.zeros((3, 4)))
    assert_same((env.reset(), env.step(np.zeros((3, 4)))), ahead)
    assert_same(kept, before)
    assert not any(np.shares_memory(a, b) for a, b in itertools.combinations(kept, 2))


def test_the_spaces_of_two_envs_have_random_numbers_of_their_own() -> None:
    a, b = WenEnv(), WenEnv()
    a.action_space.seed(1)
    b.action_space.seed(1)
    assert_same(a.action_space.sample(), b.action_space.sample())
    assert a.observation_space == WenVectorEnv(2).single_observation_space
    assert [entry.name for entry in a.observation_info()] == list(CASES)
    assert isinstance(a.observation_space, gym.spaces.Box)


def test_a_context_fixes_the_case_until_another_is_given() -> None:
    env, free = WenEnv(), WenEnv()
    free.reset(seed=0)
    for seed in range(8):
        for name, number in NUMBER.items():
            observation, _ = env.reset(seed=seed, options={"context": {"case": name}})
            assert observation.tolist() == np.eye(2)[number].tolist() and env.case == number
    env.reset(seed=0)
    assert [env.reset()[0].tolist() for _ in range(9)] == [[0.0, 1.0]] * 9
    # the draws go on beneath
    env.reset(seed=0, options={"context": None})
    assert_same([env.reset() for _ in range(20)], [free.reset() for _ in range(20)])
    env.reset(options={"context": {"case": "rough"}})
    env.reset(options={"context": {}})
    assert len({int(env.reset()[0][0]) for _ in range(30)}) == 2


@modes
def test_sub_envs_have_cases_of_their_own_through_autoresets(mode: AutoresetMode) -> None:
    vector = WenVectorEnv(3, mode)
    free = WenVectorEnv(3, mode)
    observations, _ = vector.reset(seed=0, options={"context": [{"case": "rough"}, {"case": "finish"}, None]})
    other, _ = free.reset(seed=0)
    seen = []
    for _ in range(30):
        seen.append(observations[:2].tolist())
        assert_same(observations[2], other[2])
        if mode is AutoresetMode.DISABLED:
            (observations, _), (other, _) = vector.reset(), free.reset()
        else:
            observations, other = (env.step(np.zeros((3, 4), np.float32))[0] for env in (vector, free))
    assert seen == [[[1.0, 0.0], [0.0, 1.0]]] * 30
    vector.reset(options={"context": {"case": "finish"}, "reset_mask": np.array([True, False, False])})
    assert vector.fixed == [1, 1, None]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"split": "inner"}, "there is no reset option 'split' in grind/Wen-v0; legal is context"),
        ({"context": "nominal"}, "context is 'nominal', but must be a dict with the key case, or None"),
        ({"context": {"kA": 2.0}}, "context is {'kA': 2.0}, but must be a dict with the key case, or None"),
        ({"context": {"case": "fine"}}, "case is 'fine', but must be one of rough, finish"),
        ({"context": {"case": 1}}, "case is 1, but must be one of rough, finish"),
    ],
)
def test_a_bad_option_is_refused_and_changes_nothing(options: Any, sentence: str) -> None:
    for env, twin in ((WenEnv(), WenEnv()), (WenVectorEnv(2), WenVectorEnv(2))):
        for each in (env, twin):
            each.reset(seed=1)
        with pytest.raises(ContextError) as caught:
            env.reset(seed=2, options=options)
        assert str(caught.value) == sentence
        assert_same([env.reset() for _ in range(9)], [twin.reset() for _ in range(9)])
