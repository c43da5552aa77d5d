import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.envs.actions import ActionCodec, ActionError
from grind_env.envs.choice import Choice, Choices
from grind_env.envs.tasks import load_task

CHOICES = Choices(3000.0, 30_000.0, 3)
UNIT = st.floats(-1.0, 1.0, width=32)


@settings(max_examples=200)
@given(first=UNIT, second=UNIT)
def test_an_action_means_what_it_means_in_the_other_environments(first: float, second: float) -> None:
    speeds, executions = ActionCodec(load_task("power_limited")).decode([[first, second]])
    assert CHOICES.decode(np.array([first, second])) == (speeds[0], executions[0], False)


@given(speed=st.integers(3000, 30_000), executions=st.integers(0, 3), pre_dress=st.booleans())
def test_decoding_undoes_encoding(speed: int, executions: int, pre_dress: bool) -> None:
    choices = Choices(3000.0, 30_000.0, 3, pre_dress=True)
    choice = Choice(float(speed), executions, pre_dress)
    found = choices.decode(choices.encode(choice))
    # float32 resolves E to one part in a million
    assert found.speed == pytest.approx(speed, abs=1.0)
    assert found[1:] == choice[1:]


def test_the_ends_of_the_ranges_can_be_chosen() -> None:
    assert CHOICES.decode([-1.0, -1.0]) == (3000.0, 0, False)
    assert CHOICES.decode([1.0, 1.0]) == (30_000.0, 3, False)
    assert CHOICES.decode([0.0, 0.0])[0] == round(np.sqrt(3000.0 * 30_000.0))


@pytest.mark.parametrize(
    ("action", "part"),
    [
        (np.zeros(3), "shape (3,)"),
        (0.5, "shape ()"),
        (None, "shape ()"),
        ([0.1, [0.2]], "numbers"),
        ({"E": 1.0}, "numbers"),
        ([np.nan, 0.0], "nan for E"),
        ([0.0, 1.5], "1.5 for D"),
    ],
)
def test_what_is_no_action_is_refused(action: object, part: str) -> None:
    with pytest.raises(ActionError) as caught:
        CHOICES.decode(action)
    assert part in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("choice", "part"),
    [
        (Choice(2999.0, 0), "from 3000 to 30000"),
        (Choice(9000.0, 4), "from 0 to 3"),
        (Choice(9000.0, 0, True), "predress=True"),
    ],
)
def test_what_no_action_stands_for_is_refused(choice: Choice, part: str) -> None:
    with pytest.raises(ActionError, match=part):
        CHOICES.encode(choice)
