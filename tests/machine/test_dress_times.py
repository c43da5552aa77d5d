"""The time of a dress with other passes, feed and infeed against the control that executes it."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grind_env.control import Control, read
from grind_env.machine.dress.dress_run import DressRun, run_dress
from grind_env.machine.dress.dress_time import dress_seconds
from tests.machine.harness import job

AT_PRIMARY = (230.0, -0.05, 0.0)
CONTROL = Control(acceleration=1000.0, rapid_feed=15_000.0)


def back_and_forth(passes: int, feed: int, depth: int) -> str:
    steps = [f"G91 G01 Y-{depth / 1000:.3f} F60.\nZ{'-' if k % 2 else ''}35. F{feed}." for k in range(passes)]
    return "\n".join(["G71 G90 G94", "G00 Y20.", "X-120. Z-40.", "Y10.", *steps, "G90 G00 Y20."])


def one_way(passes: int, feed: int, depth: int) -> str:
    """Return a dress that goes off the diamond and back to the start between its passes."""
    again, turn = f"G01 Y-{depth / 1000:.3f} F60.\nZ35. F{feed}.", "G00 X1.\nZ-35.\nX-1."
    return "\n".join(["G71 G91 G94", "G00 Y2.", f"\n{turn}\n".join([again] * passes), "G90 G00 Y20. X-50.", "G04 X.5"])


def remembered(passes: int, feed: int, depth: int) -> str:
    """Return a dress of infeeds and passes alone, which the way back retraces."""
    steps = [f"G01 Y-{depth / 1000:.3f} F60.\nZ{'-' if k % 2 else ''}30. F{feed}." for k in range(passes)]
    return "\n".join(["G71 G91 G94", *steps])


def around(passes: int, feed: int, depth: int) -> str:
    """Return a dress with an arc as the way to the diamond, which is not retraced."""
    lead = "G00 Y5.\nG18 G03 X-10. Z-10. I-10. K0 F900."
    return f"G71 G91 G94\n{lead}\n{back_and_forth(passes, feed, depth).partition('Y10.')[2]}"


Write = Callable[[int, int, int], str]

PROGRAMS: tuple[Write, ...] = (back_and_forth, one_way, remembered, around)


def planned(body: str) -> DressRun:
    return run_dress(read(f"M30\nO9100\n{body}\nM99\n"), 9100, job(), CONTROL, AT_PRIMARY, 0)


dresses = st.tuples(st.integers(1, 5), st.integers(100, 900), st.integers(2, 100))


@given(written=st.sampled_from(PROGRAMS), own=dresses, others=st.lists(dresses, min_size=1, max_size=5))
def test_the_time_of_a_changed_dress_equals_a_rewritten_program(
    written: Write, own: tuple[int, int, int], others: list[tuple[int, int, int]]
) -> None:
    assume(written is not one_way or own[0] > 1)  # a single pass does not show the way to the next one
    plan = planned(written(*own))
    rewritten = [planned(written(*other)) for other in others]
    numbers = np.array([other.plan[:3] for other in rewritten]).T
    expected = [other.plan.seconds for other in rewritten]
    assert dress_seconds(plan, CONTROL, *numbers) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("written", PROGRAMS)
@pytest.mark.parametrize("own", [(1, 300, 10), (2, 191, 20), (3, 777, 7)])
def test_a_dress_with_its_programmed_numbers_takes_exactly_its_time(written: Write, own: tuple[int, int, int]) -> None:
    plan = planned(written(*own))
    among_others = np.array([plan.plan[:3], (5, 2.0, 0.03)]).T
    assert dress_seconds(plan, CONTROL, *among_others)[0] == plan.plan.seconds


def test_all_moves_at_the_feed_of_the_passes_change_with_it() -> None:
    body = "G71 G91 G94\nG00 Y20.\nX-120.\nG01 Y-.02 F60.\nZ35. F{0}.\nY-.02\nZ-35.\nY1."
    plan, other = planned(body.format(300)), planned(body.format(180))
    found = dress_seconds(plan, CONTROL, np.array([2.0]), np.array([3.0]), np.array([0.02]))
    assert found == pytest.approx([other.plan.seconds], rel=1e-12)
