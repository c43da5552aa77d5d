"""The counter-based generator, against the vectors of its authors and the exact inverse of the normal distribution."""

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grind_env.kernel.random import WORD, normal, philox, uniform
from tests.kernel.test_plain import compiled

#: key, counter and words of philox4x32-10 in `kat_vectors` of Random123
VECTORS = [
    ("00000000 00000000", "00000000 00000000 00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff", "ffffffff ffffffff ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("a4093822 299f31d0", "243f6a88 85a308d3 13198a2e 03707344", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]

words = st.integers(0, WORD)


def hexadecimal(text: str) -> list[int]:
    return [int(word, 16) for word in text.split()]


@pytest.mark.bits
@pytest.mark.parametrize(("key", "counter", "expected"), VECTORS)
def test_philox_gives_the_published_words(key: str, counter: str, expected: str) -> None:
    given_words = *hexadecimal(key), *hexadecimal(counter)
    assert list(compiled(philox)(*given_words)) == hexadecimal(expected)
    assert list(philox(*given_words)) == hexadecimal(expected)


@given(st.tuples(*[words] * 6))
def test_compiled_philox_equals_philox_in_unbounded_integers(numbers: tuple[int, ...]) -> None:
    assert compiled(philox)(*numbers) == philox(*numbers)


@given(words)
@example(0)
@example(WORD)
@example(round(0.075 * 2**32))  # where one rational function gives way to the other
@example(round(0.925 * 2**32))
def test_normal_is_the_inverse_of_the_distribution_function(word: int) -> None:
    u = uniform(word)
    with mpmath.workdps(40):
        assert mpmath.mpf(u) == (word + mpmath.mpf("0.5")) / 2**32
        exact = mpmath.sqrt(2) * mpmath.erfinv(2 * mpmath.mpf(u) - 1)
        assert abs(normal(u) - exact) < 2e-15 * abs(exact)
    assert normal(1.0 - u) == -normal(u)
    assert compiled(normal)(u) == normal(u)


def drawn(keys: int, counters: int) -> np.ndarray:
    """Return normal numbers of neighbouring keys and counters, shape (keys, counters, 4)."""
    found = [[philox(key, 7, counter, 0, 0, 0) for counter in range(counters)] for key in range(keys)]
    return np.array([[[normal(uniform(word)) for word in four] for four in row] for row in found])


def test_neighbouring_keys_counters_and_words_are_independent_and_normal() -> None:
    z = drawn(100, 100)
    n = z.size
    for power, moment, variance in ((1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)):
        assert (z**power).mean() == pytest.approx(moment, abs=4.0 * np.sqrt(variance / n))
    for axis in range(3):
        for step in range(1, 4):
            here, there = np.take(z, range(z.shape[axis] - step), axis), np.take(z, range(step, z.shape[axis]), axis)
            for a, b in ((here, there), (here**2 - 1.0, there**2 - 1.0)):
                correlation = (a * b).mean() / np.sqrt((a * a).mean() * (b * b).mean())
                assert abs(correlation) < 4.0 / np.sqrt(a.size), (axis, step)
    share = np.histogram(z, [-np.inf, -1.2815515655, -0.5244005127, 0.0, 0.5244005127, 1.2815515655, np.inf])[0] / n
    expected = np.array([0.1, 0.2, 0.2, 0.2, 0.2, 0.1])
    np.testing.assert_allclose(share, expected, atol=4.0 * np.sqrt(0.2 * 0.8 / n))
