import math
import warnings
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from hypothesis import given
from hypothesis import strategies as st

from grind_env.envs.actions import ActionCodec, ActionError
from grind_env.envs.tasks import load_task
from tests.envs.harness import FORMS, assert_same, native, rows_of

ID = "grind/PowerLimited-v0"

RANGE = ActionCodec(load_task("power_limited"))
LEVELS = ActionCodec(load_task("oracle6"))
unit = st.floats(-1.0, 1.0, width=32)


def test_every_speed_in_whole_millimetres_and_every_D_can_be_chosen() -> None:
    E, D = (grid.ravel() for grid in np.meshgrid(np.arange(3000.0, 30001.0), np.arange(4.0)))
    actions = RANGE.encode(E, D)
    assert actions.dtype == np.float32 and actions.shape == (108004, 2)
    speeds, executions = RANGE.decode(actions)
    np.testing.assert_array_equal(speeds, E)
    np.testing.assert_array_equal(executions, D)


@given(unit, unit)
def test_decoding_follows_the_published_map(u0: float, u1: float) -> None:
    (speed,), (executions,) = RANGE.decode([[u0, u1]])
    assert speed == math.floor(speed)
    assert speed == pytest.approx(3000.0 * 10.0 ** ((u0 + 1.0) / 2.0), abs=0.5 + 1e-6)
    # thirds of [-1, 1]: the first two dress nothing, the last one has a ninth for each D
    assert executions == sum(np.float32(u1) > edge for edge in np.float32([1.0 / 3.0, 5.0 / 9.0, 7.0 / 9.0]))
    (speed,), (executions,) = LEVELS.decode([[u0, u1]])
    assert speed == (6000.0, 9000.0, 14000.0, 21000.0)[min(3, math.floor((u0 + 1.0) / 2.0 * 4))]
    assert executions == (np.float32(u1) > np.float32(1.0 / 3.0))


def test_uniform_actions_dress_in_a_third_of_blocks_and_choose_D_and_levels_evenly() -> None:
    u = np.linspace(-1.0, 1.0, 12001)[:-1] + 1.0 / 12000.0
    actions = np.stack([u, u], axis=1)
    for codec, most in ((RANGE, 3), (LEVELS, 1), (ActionCodec(load_task("slot")), 4)):
        executions = codec.decode(actions)[1]
        assert np.bincount(executions.astype(int)).tolist() == pytest.approx([8000] + [4000 / most] * most, abs=1)
    assert np.unique(LEVELS.decode(actions)[0], return_counts=True)[1].tolist() == [3000] * 4


def test_a_third_is_the_last_action_without_a_dress() -> None:
    third = np.float32(1.0) / np.float32(3.0)
    edges = np.array([[0.0, third], [0.0, np.nextafter(third, np.float32(1.0))]], np.float32)
    for codec in (RANGE, LEVELS):
        D = codec.decode(edges)[1]
        assert D.tolist() == [0.0, 1.0] and not np.signbit(D).any()


def test_a_task_without_dresses_has_one_D() -> None:
    task = load_task("power_limited")
    codec = ActionCodec(replace(task, action=replace(task.action, executions=0)))
    assert codec.decode([[0.0, -1.0], [0.0, 1.0]])[1].tolist() == [0.0, 0.0]
    assert codec.decode(codec.encode([9000.0], [0.0]))[1].tolist() == [0.0]


@pytest.mark.parametrize(
    ("speed", "executions", "part"),
    [
        (2999.0, 0, "2999"),
        (30001.0, 0, "30001"),
        (math.nan, 0, "nan"),
        (9000.0, 4, "D is 4"),
        (9000.0, -1, "D is -1"),
        (9000.0, 0.5, "D is 0.5"),
        (9000.0, math.nan, "D is nan"),
    ],
)
def test_encode_refuses_an_illegal_E_or_D(speed: float, executions: float, part: str) -> None:
    with pytest.raises(ActionError, match=part):
        RANGE.encode(speed, executions)


@pytest.mark.parametrize("speed", [6001.0, 0.0, math.nan])
def test_a_speed_between_the_levels_is_refused(speed: float) -> None:
    with pytest.raises(ActionError, match="6000, 9000, 14000, 21000"):
        LEVELS.encode(speed, 0)


CODECS = [
    ActionCodec(load_task(name), form, predress=predress)
    for name in ("power_limited", "oracle6", "slot")
    for form in FORMS
    for predress in (False, True)
]


@given(st.data())
def test_every_form_can_express_every_choice(data: st.DataObject) -> None:
    codec = data.draw(st.sampled_from(CODECS))
    if codec.levels.size:
        E = data.draw(st.sampled_from(codec.levels.tolist()))
    else:
        E = float(data.draw(st.integers(int(codec.low), int(codec.high))))
    choice = [E, data.draw(st.integers(0, codec.executions)), data.draw(st.integers(0, 1))][: len(codec.names)]
    encoded = codec.encode(*choice)
    assert codec.space.contains(rows_of(encoded, 1)[0])
    assert [values[0] for values in codec.decode(encoded)] == choice


def test_the_discrete_forms_have_24_geometric_levels_of_speed() -> None:
    for name, low, high in (("power_limited", 3000.0, 30000.0), ("slot", 6000.0, 18000.0)):
        codec = ActionCodec(load_task(name), "multidiscrete")
        assert codec.space.nvec.tolist() == [24, codec.executions + 1]
        levels, _ = codec.decode([[k, 0] for k in range(24)])
        assert (levels[0], levels[-1]) == (low, high)
        np.testing.assert_allclose(levels, np.geomspace(low, high, 24), atol=0.5)
    assert ActionCodec(load_task("oracle6"), "multidiscrete", predress=True).space.nvec.tolist() == [4, 2, 2]
    assert ActionCodec(load_task("power_limited"), "discrete").space.n == 24 * 4
    assert ActionCodec(load_task("power_limited"), "discrete", predress=True).space.n == 24 * 4 * 2


def test_the_discrete_number_counts_pre_dress_then_dresses_then_speeds() -> None:
    codec = ActionCodec(load_task("power_limited"), "discrete", predress=True)
    speeds, executions, dressed = codec.decode(np.arange(192))
    levels = np.floor(np.geomspace(3000.0, 30000.0, 24) + 0.5)
    np.testing.assert_array_equal(speeds, np.repeat(levels, 8))
    np.testing.assert_array_equal(executions, np.tile(np.repeat(np.arange(4.0), 2), 24))
    np.testing.assert_array_equal(dressed, np.tile([0.0, 1.0], 96))


def test_a_pre_dress_is_asked_for_above_zero() -> None:
    codec = ActionCodec(load_task("power_limited"), predress=True)
    asked = codec.decode([[0.0, 0.0, u] for u in (-1.0, -1e-6, 0.0, 1e-6, 1.0)])[2]
    assert asked.tolist() == [0.0, 0.0, 0.0, 1.0, 1.0]


def test_physical_actions_are_rounded_to_whole_mm_per_min_or_a_level() -> None:
    free, levels = (ActionCodec(load_task(name), "dict") for name in ("power_limited", "oracle6"))
    assert free.decode({"E": [8999.4, 8999.6], "D": [0, 3]})[0].tolist() == [8999.0, 9000.0]
    # the nearest level by ratio: 6000, 9000, 14000, 21000
    assert levels.decode({"E": [7300.0, 7400.0], "D": [0, 1]})[0].tolist() == [6000.0, 9000.0]


@pytest.mark.parametrize("form", ["single", "vector"])
def test_an_action_beyond_the_box_is_clipped_with_one_warning(form: str) -> None:
    def made(**arguments: Any) -> tuple[Any, Any]:
        env = gym.make(ID, **arguments) if form == "single" else native(ID, 1, **arguments)
        return env, env.reset(seed=3)[0]

    def shaped(*numbers: float) -> Any:
        return np.array(numbers, np.float32) if form == "single" else np.array([numbers], np.float32)

    (env, _), (twin, _) = made(), made()
    with pytest.warns(UserWarning, match=r'action 0 has 12 for E, clipped to 1.*action="dict" takes E in mm/min'):
        beyond = env.step(shaped(12.0, 1.0))
    assert_same(beyond, twin.step(shaped(1.0, 1.0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert_same(env.step(shaped(-7.0, -3.0)), twin.step(shaped(-1.0, -1.0)))
        rounded = made(out_of_range="raise")[0].step(shaped(float(np.nextafter(np.float32(1), np.float32(2))), 0.0))
    assert_same(rounded, made(out_of_range="raise")[0].step(shaped(1.0, 0.0)))
    for strict in ("clip", "raise"):
        for number in (math.nan, math.inf, -math.inf):
            with pytest.raises(ActionError, match="which is no number"):
                made(out_of_range=strict)[0].step(shaped(0.0, number))
    with pytest.raises(ActionError, match="out_of_range is 'wrap', but must be one of clip, raise"):
        made(out_of_range="wrap")


def test_physical_units_are_clipped_only_if_asked_for() -> None:
    fast = {"E": np.array([1e6], np.float32), "D": 0}
    refusing, clipping = (gym.make(ID, action="dict", **given) for given in ({}, {"out_of_range": "clip"}))
    refusing.reset(seed=1)
    clipping.reset(seed=1)
    with pytest.raises(ActionError, match="must lie between 3000 and 30000 mm/min"):
        refusing.step(fast)
    with pytest.warns(UserWarning, match="1000000 for E, clipped to 30000"):
        assert clipping.step(fast)[4]["E"] == 30000.0
    assert gym.make(EnvSpec.from_json(clipping.spec.to_json())).unwrapped.codec.clips


def test_a_discrete_action_may_be_an_array_of_one_number() -> None:
    envs = [gym.make(ID, action="discrete") for _ in range(2)]
    for env in envs:
        env.reset(seed=1)
    assert_same(envs[0].step(np.array([7])), envs[1].step(7))
