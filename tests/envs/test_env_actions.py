import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.envs.actions import ActionCodec, ActionError
from grind_env.envs.tasks import load_task

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


def test_every_level_and_every_D_can_be_chosen() -> None:
    E, D = (grid.ravel() for grid in np.meshgrid([6000.0, 9000.0, 14000.0, 21000.0], [0.0, 1.0]))
    speeds, executions = LEVELS.decode(LEVELS.encode(E, D))
    np.testing.assert_array_equal(speeds, E)
    np.testing.assert_array_equal(executions, D)


@given(unit, unit)
def test_decoding_follows_the_published_map(u0: float, u1: float) -> None:
    (speed,), (executions,) = RANGE.decode([[u0, u1]])
    assert speed == math.floor(speed)
    assert speed == pytest.approx(3000.0 * 10.0 ** ((u0 + 1.0) / 2.0), abs=0.5 + 1e-6)
    assert executions == min(3, math.floor((u1 + 1.0) / 2.0 * 4))
    (speed,), (executions,) = LEVELS.decode([[u0, u1]])
    assert speed == (6000.0, 9000.0, 14000.0, 21000.0)[min(3, math.floor((u0 + 1.0) / 2.0 * 4))]
    assert executions == min(1, math.floor((u1 + 1.0) / 2.0 * 2))


@given(unit, unit)
def test_encoding_undoes_decoding(u0: float, u1: float) -> None:
    for codec in (RANGE, LEVELS):
        chosen = codec.decode([[u0, u1]])
        action = codec.encode(*chosen)
        assert codec.space.contains(action[0])
        assert np.array_equal(codec.decode(action), chosen)


@given(unit, unit)
def test_a_higher_action_is_never_slower(a: float, b: float) -> None:
    for codec in (RANGE, LEVELS):
        speeds, executions = codec.decode([[min(a, b), min(a, b)], [max(a, b), max(a, b)]])
        assert speeds[0] <= speeds[1] and executions[0] <= executions[1]


def test_the_ends_are_exact() -> None:
    ends = np.array([[-1.0, -1.0], [1.0, 1.0]], np.float32)
    assert [values.tolist() for values in RANGE.decode(ends)] == [[3000.0, 30000.0], [0.0, 3.0]]
    assert [values.tolist() for values in LEVELS.decode(ends)] == [[6000.0, 21000.0], [0.0, 1.0]]


def test_uniform_actions_choose_every_D_and_every_level_alike() -> None:
    u = np.linspace(-1.0, 1.0, 12001)[:-1] + 1.0 / 12000.0
    actions = np.stack([u, u], axis=1)
    for codec, count in ((RANGE, 4), (LEVELS, 2)):
        executions = codec.decode(actions)[1]
        assert np.bincount(executions.astype(int)).tolist() == [12000 // count] * count
    assert np.unique(LEVELS.decode(actions)[0], return_counts=True)[1].tolist() == [3000] * 4


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
def test_what_cannot_be_chosen_is_refused(speed: float, executions: float, part: str) -> None:
    with pytest.raises(ActionError, match=part):
        RANGE.encode(speed, executions)


@pytest.mark.parametrize("speed", [6001.0, 0.0, math.nan])
def test_a_speed_between_the_levels_is_refused(speed: float) -> None:
    with pytest.raises(ActionError, match="6000, 9000, 14000, 21000"):
        LEVELS.encode(speed, 0)
