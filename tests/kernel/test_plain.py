"""What is called as it is written has the bits of what is compiled."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.kernel import plain
from grind_env.process import equations as eq
from grind_env.process.cost import volume_left

numbers = st.floats(1e-4, 1e3)


@pytest.mark.parametrize(
    ("function", "count"), [(eq.overlap_ratio, 2), (eq.blunting, 2), (eq.severity, 4), (volume_left, 2)]
)
@given(data=st.data())
def test_the_bits_are_those_of_the_compiled_function(
    function: Callable[..., float], count: int, data: st.DataObject
) -> None:
    given_numbers = data.draw(st.lists(numbers, min_size=count, max_size=count))
    assert plain(function)(*given_numbers).hex() == function(*given_numbers).hex()


@given(radius=st.floats(0.01, 2.0), share=st.floats(0.001, 1.0), flat=st.floats(0.0, 0.5))
def test_so_are_those_of_the_width_of_a_dress(radius: float, share: float, flat: float) -> None:
    depth = radius * share
    assert plain(eq.dress_width)(depth, radius, flat).hex() == eq.dress_width(depth, radius, flat).hex()
