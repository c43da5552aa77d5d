"""Costs against numbers by hand, and properties of costs for any wheel."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.process import cost
from grind_env.process.stroke_and_dress import dress_wheel, dressed_wheel
from grind_env.process.stroke_types import WheelState
from tests.process.harness import grinder, parameters

RATES = cost.Rates(hourly=80.0, wheel=1e-4, dress=0.10)
LIMITS = cost.Limits(rise=450.0, power=7500.0, roughness=0.50, size=9.0)
MEDIUM = (2.0, 0.10, 0.020)  #: passes, lead and depth of the medium dress

ONE_DRESS = 0.86091445  #: $ of a medium dress in 30 s: 80*30/3600 + 1e-4*(0.04 pi 300*25) + 0.10


def test_running_cost() -> None:
    # a minute and a half at 80 $/h, 1000 mm3 of wheel, two dresses
    assert cost.expenses(90.0, 1000.0, 2.0, RATES) == pytest.approx((2.0, 0.1, 0.2), rel=1e-12)
    assert cost.running_cost(90.0, 1000.0, 2.0, RATES) == pytest.approx(2.0 + 0.1 + 0.2, rel=1e-12)


def test_dress_cost() -> None:
    assert cost.dress_cost(2.0, 0.020, 30.0, 300.0, 25.0, RATES) == pytest.approx(ONE_DRESS, rel=1e-8)


@pytest.mark.parametrize(
    ("rise", "torque", "roughness", "size_error", "probability"),
    [
        (100.0, 0.3, 0.20, 3.0, 0.999447),  # 6 um inside: 1 - 1/(1 + e^7.5)
        (450.0, 0.3, 0.20, 0.0, 0.5),  # each value at its limit: a half
        (100.0, 1.0 - 1e-12, 0.20, 0.0, 0.5),
        (100.0, 0.3, 0.50, 0.0, 0.5),
        (100.0, 0.3, 0.20, 9.0, 0.499993),
        (450.0, 1.0 - 1e-12, 0.50, 9.0, 0.0625),  # and all at once
        (462.0, 0.3, 0.20, 0.0, 0.268941),  # one width beyond: 1/(1 + e)
        (100.0, 0.3, 0.52, 0.0, 0.268941),
        (100.0, 0.3, 0.20, 9.8, 0.268941),
        (100.0, 0.3, 0.20, -9.8, 0.268941),  # a part may be too small as well
        (438.0, 0.3, 0.20, 0.0, 0.731059),  # one width inside
        (100.0, 0.98, 0.20, 0.0, 0.731059),
        (100.0, 1.0, 0.20, 0.0, 0.0),  # a spindle that has stalled leaves no good part
        (100.0, 1.5, 0.20, 0.0, 0.0),
    ],
)
def test_survival(rise: float, torque: float, roughness: float, size_error: float, probability: float) -> None:
    found = cost.survival(rise, torque, roughness, size_error, LIMITS)
    assert found == pytest.approx(probability, rel=2e-5)


def test_a_limit_of_zero_means_no_limit() -> None:
    free = cost.Limits(rise=450.0, power=7500.0, roughness=cost.NO_LIMIT, size=cost.NO_LIMIT)
    assert cost.survival(100.0, 0.3, 50.0, 5000.0, free) == pytest.approx(1.0, abs=1e-9)
    assert cost.survival(450.0, 0.3, 50.0, 5000.0, free) == pytest.approx(0.5, abs=1e-9)
    assert cost.survival(100.0, 1.0, 50.0, 5000.0, free) == 0.0
    # the one limit that is set still counts
    assert cost.survival(100.0, 0.3, 0.5, 5000.0, free._replace(roughness=0.5)) == pytest.approx(0.5, abs=1e-9)
    assert cost.survival(100.0, 0.3, 50.0, 9.0, free._replace(size=9.0)) == pytest.approx(0.5, abs=1e-9)


def test_passed_limits_lists_the_exceeded_limits() -> None:
    assert cost.passed_limits(450.0, 0.99, 0.50, -9.0, LIMITS) == ()  # each value at its limit, the torque below
    assert cost.passed_limits(451.0, 1.0, 0.51, -9.1, LIMITS) == ("rise", "power", "roughness", "size")
    free = LIMITS._replace(roughness=cost.NO_LIMIT, size=cost.NO_LIMIT)
    assert cost.passed_limits(451.0, 0.99, 50.0, 5000.0, free) == ("rise",)


@settings(deadline=None)
@given(st.floats(0.0, 2000.0), st.floats(0.0, 3.0), st.floats(0.0, 10.0), st.floats(-1e4, 1e4), st.floats(0.0, 5.0))
def test_survival_is_a_probability_and_falls_with_worse_results(
    rise: float, torque: float, roughness: float, size_error: float, worse: float
) -> None:
    here = cost.survival(rise, torque, roughness, size_error, LIMITS)
    assert 0.0 <= here <= 1.0
    assert cost.survival(rise + 100.0 * worse, torque, roughness, size_error, LIMITS) <= here
    assert cost.survival(rise, torque + worse, roughness, size_error, LIMITS) <= here
    assert cost.survival(rise, torque, roughness + worse, size_error, LIMITS) <= here
    assert cost.survival(rise, torque, roughness, math.copysign(abs(size_error) + worse, size_error), LIMITS) <= here


def handover(wheel: WheelState) -> float:
    return cost.handover_cost(wheel, *MEDIUM, 30.0, parameters(), RATES)


def test_handing_over_a_dressed_wheel_costs_nothing() -> None:
    wheel = grinder(parameters()).wheel
    assert handover(wheel) == 0.0
    # still within a tenth of a dressed wheel
    assert handover(wheel._replace(A=1.09 * wheel.A, lam=0.049)) == 0.0
    # sharper than a dressed one
    assert handover(wheel._replace(A=0.5 * wheel.A)) == 0.0


def test_handing_over_a_dull_or_loaded_wheel_costs_the_dresses_it_needs() -> None:
    wheel = grinder(parameters()).wheel
    # Ad = 0.008; ln(0.022/0.0008) = 3.314186; one dress does 4/(1 + 0.6) = 2.5
    assert handover(wheel._replace(A=0.03)) == pytest.approx(3.314186 / 2.5 * ONE_DRESS, rel=1e-6)
    # ln(0.5/0.05) = 2.302585; one dress does 4/(1 + 0.5 + 0.16) = 2.409639
    assert handover(wheel._replace(lam=0.5)) == pytest.approx(2.302585 / 2.409639 * ONE_DRESS, rel=1e-6)


def test_handing_over_costs_at_most_four_dresses() -> None:
    ruined = grinder(parameters(), A=0.149, lam=1.0).wheel
    assert handover(ruined) == pytest.approx(4.0 * ONE_DRESS, rel=1e-8)


@settings(deadline=None)
@given(
    A=st.floats(0.0005, 0.149),
    lam=st.floats(0.0, 1.0),
    wd=st.floats(0.0, 0.2),
    lead=st.floats(0.04, 0.20),
    depth=st.floats(0.005, 0.030),
    passes=st.floats(1.0, 6.0),
)
def test_the_charged_dresses_restore_the_wheel(
    A: float, lam: float, wd: float, lead: float, depth: float, passes: float
) -> None:
    p = parameters()
    wheel = grinder(p, A=A, lam=lam, wd=wd).wheel
    price = cost.dress_cost(passes, depth, 30.0, wheel.ds, p.bs, RATES)
    dresses = cost.handover_cost(wheel, passes, lead, depth, 30.0, p, RATES) / price
    assert 0.0 <= dresses <= 4.0 * (1.0 + 1e-12)
    restored, _ = dress_wheel(wheel, passes * dresses, lead, depth, p)
    dressed = dressed_wheel(wheel.ds, wd, lead, depth, p).A
    excess = max((restored.A - dressed) / (0.1 * dressed), restored.lam / 0.05)
    if dresses == 0.0:
        assert excess <= 1.0
    elif dresses < 4.0:
        assert excess == pytest.approx(1.0, rel=1e-9)
    else:
        assert excess >= 1.0 - 1e-9
