"""exp and log of the kernels, against mpmath."""

import math

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.kernel import exp, log, logistic, power, tanh

TOLERANCE = 4e-16


def relative_error(value: float, exact: mpmath.mpf) -> float:
    return float(abs((mpmath.mpf(value) - exact) / exact))


@given(st.floats(-699.0, 699.0))
def test_exp(x):
    with mpmath.workdps(40):
        assert relative_error(exp(x), mpmath.exp(x)) < TOLERANCE


@given(st.one_of(st.floats(1e-300, 1e300), st.floats(0.99, 1.01)))
def test_log_is_accurate_even_near_one(x):
    with mpmath.workdps(40):
        exact = mpmath.log(x)
        if exact != 0:
            assert relative_error(log(x), exact) < TOLERANCE


def test_exact_values():
    assert exp(0.0) == 1.0
    assert log(1.0) == 0.0
    assert logistic(0.0) == 0.5


def test_exp_saturates_instead_of_overflowing():
    assert exp(1e6) == exp(700.0) < math.inf
    assert 0.0 < exp(-1e6) == exp(-700.0)


@given(st.floats(1e-6, 1e6), st.floats(-3.0, 3.0))
def test_power(x, exponent):
    assert power(x, exponent) == pytest.approx(x**exponent, rel=2e-14)


@given(st.floats(-1000.0, 1000.0))
def test_tanh(x):
    with mpmath.workdps(40):
        assert abs(mpmath.mpf(tanh(x)) - mpmath.tanh(x)) < 4e-16
