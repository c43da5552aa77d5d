"""Vector environments whose episodes several threads grind."""

from pathlib import Path

import numpy as np
import pytest

from grind_env.envs.tasks import TaskError
from grind_env.envs.transition import TOGETHER
from tests.envs.harness import MODES, assert_same, every_id, native, sampled
from tests.envs.test_vector_promises import grooved

N = 11


@pytest.mark.bits
@pytest.mark.parametrize("env_id", every_id())
def test_threads_change_no_bit(env_id: str) -> None:
    one, three = (native(env_id, N, MODES[every_id().index(env_id) % 2], threads=threads) for threads in (1, 3))
    assert_same(one.reset(seed=0), three.reset(seed=0))
    for number, batch in enumerate(sampled(env_id, 8, N)):
        if number == 4:  # from here on some episodes end, and with them some threads have nothing to do
            assert_same(*(each.reset(options={"reset_mask": np.arange(N) < 9}) for each in (one, three)))
        assert_same(one.step(batch), three.step(batch))
    for name in ("block", "wheels", "parts", "memory", "tape"):
        assert_same(getattr(one.episodes, name), getattr(three.episodes, name))


@pytest.mark.parametrize("n", [2, TOGETHER + 2])
def test_more_threads_than_episodes_and_more_episodes_than_are_stepped_in_one_go(n: int) -> None:
    one, many = (native("grind/Oracle6-v0", n, "NextStep", threads=threads) for threads in (1, 5))
    assert_same(one.reset(seed=3), many.reset(seed=3))
    for batch in sampled("grind/Oracle6-v0", 14, n):
        assert_same(one.step(batch), many.step(batch))


def test_a_program_that_python_runs_has_one_thread(tmp_path: Path) -> None:
    program = grooved(tmp_path)
    native("grind/Job-v0", 2, program=program, threads=1)
    with pytest.raises(TaskError, match="threads is 2, but Python runs this program"):
        native("grind/Job-v0", 2, program=program, threads=2)
