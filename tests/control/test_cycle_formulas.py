"""The rules of a cycle, without a program."""

import itertools
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from grind_env.control.cycles import RULES, Rules, plunge, traverse

picks = st.integers(1, 40)


def ground(rules: Rules, cycle: Any, most: int = 10_000) -> list[Any]:
    """Return the progress of a cycle before every stroke and at its end."""
    found = [rules.begin(cycle)]
    while not rules.finished(cycle, found[-1]):
        found.append(rules.after_reversal(cycle, found[-1]))
        assert len(found) < most
    return found


@given(depth=st.integers(0, 60), J=picks, Q=st.integers(0, 40), at_depth=st.integers(0, 4), D=st.integers(0, 5))
def test_a_plunge_reaches_its_depth_dresses_and_sparks_out(depth: int, J: int, Q: int, at_depth: int, D: int) -> None:
    cycle = plunge.PlungeCycle(depth / 1000, J / 1000, Q / 1000, at_depth, D, pre_dress=0.0)
    found = ground(RULES["G82"], cycle)
    h, strokes = 0, 0
    while h < depth:
        strokes += 1
        h = min(depth, h + (J if strokes % 2 else Q))
    assert len(found) - 1 == strokes + at_depth
    assert found[-1].depth == cycle.depth
    assert sum(each.dresses for each in found) == (D if depth else 0)


@given(
    depth=st.integers(0, 30),
    J=picks,
    Q=st.integers(0, 40),
    width=st.integers(0, 60),
    K=picks,
    R=st.integers(0, 40),
    at_depth=st.integers(0, 3),
    D=st.integers(0, 3),
)
def test_a_traverse_plunges_only_at_the_ends_of_its_crossover(
    depth: int, J: int, Q: int, width: int, K: int, R: int, at_depth: int, D: int
) -> None:
    cycle = traverse.TraverseCycle(depth / 1000, J / 1000, Q / 1000, width, K, R, at_depth, D, pre_dress=0.0)
    found = ground(RULES["G83"], cycle)
    assert found[-1].depth == cycle.depth
    assert sum(each.dresses for each in found) == (D if depth else 0)
    turns = 0
    for before, after in itertools.pairwise(found):
        at_end = before.crossed >= width
        assert after.depth == before.depth or at_end
        assert (after.forward != before.forward) == at_end
        assert after.crossed == 0.0 if at_end else after.crossed >= before.crossed
        turns += at_end
    plunges = sum(after.depth > before.depth for before, after in itertools.pairwise(found))
    assert turns == max(found[-1].plunges, 1.0) + at_depth
    assert plunges <= found[-1].plunges
