"""Each valve alloy left out: what predicts it, and what is said of that."""

from dataclasses import replace

import numpy as np
import pytest

from grind_env.process.catalogue import load_catalogue
from grind_env.validation import Rig, data
from grind_env.validation.leave_out import (
    CONSTANT,
    MODEL,
    POWER_LAW,
    PREDICTORS,
    SHIPPED,
    WEAR_KNOWN,
    Error,
    LeftOut,
    difference,
    error,
    left_out,
    mean_errors,
)
from grind_env.validation.report import comparison, prediction_rows


@pytest.fixture(scope="module")
def found() -> list[LeftOut]:
    return left_out(Rig(load_catalogue()))


def runs(wheel: str, speed: str, alloy: str, response: str) -> np.ndarray:
    """Logarithms of rate, volume and a response, shape (9, 3)."""
    names = ("removal_rate_per_s", "volume_removed", response)
    rows = [
        row for row in data.rows("valve_alloys") if (row["wheel"], row["vs_m_s"], row["mat"]) == (wheel, speed, alloy)
    ]
    return np.log([[float(row[name]) for name in names] for row in rows])


def test_an_error_is_that_of_the_mean_and_that_beside_it():
    truth = np.array([1.0, 2.0, 4.0])
    assert error(3.0 * truth, truth) == pytest.approx(Error(200.0, 0.0), abs=1e-9)
    assert error(truth / 3.0, truth) == pytest.approx(Error(200.0, 0.0), abs=1e-9)  # a factor of three, either way
    level, course = error(np.full(3, 2.0), truth)
    assert (level, course) == pytest.approx((0.0, 100.0 * (2.0 ** np.sqrt(2.0 / 3.0) - 1.0)), abs=1e-9)


def test_constant_and_power_law_are_those_of_least_squares(found):
    for each in found:
        wheel, speed, _ = each.wheel.split()
        other = "21-43" if each.alloy == "INC751" else "INC751"
        column = {"wear": "wheel_wear_um", "Ra": "Ra_um"}[each.response]
        source, truth = (runs(wheel, speed, alloy, column) for alloy in (other, each.alloy))
        fit = np.linalg.lstsq(np.column_stack([source[:, :2], np.ones(9)]), source[:, 2], rcond=None)[0]
        off = truth[:, :2] @ fit[:2] + fit[2] - truth[:, 2]
        assert each.errors[POWER_LAW].level == pytest.approx(100.0 * np.expm1(abs(off.mean())), rel=1e-6)
        assert each.errors[POWER_LAW].course == pytest.approx(100.0 * np.expm1(off.std()), rel=1e-6)
        assert each.errors[CONSTANT].course == pytest.approx(100.0 * np.expm1(truth[:, 2].std()), rel=1e-6)


def test_what_is_fitted_to_the_other_alloy_has_its_level(found):
    assert len(found) == 12
    for each in found:
        levels = [each.errors[name].level for name in (CONSTANT, POWER_LAW, MODEL)]
        assert levels == pytest.approx([levels[0]] * 3, rel=2e-3)
        assert (WEAR_KNOWN in each.errors) == (each.response == "Ra")
        assert SHIPPED in each.errors


def test_the_model_is_fitted_whatever_material_is_shipped(found):
    known = load_catalogue()
    worn = replace(known.material("inc751"), g_ratio_factor=0.1, g_ratio_factor_cbn=0.02, g_ratio_exponent=0.5)
    other = left_out(Rig(replace(known, materials={**known.materials, "inc751": worn})))
    for one, two in zip(found, other, strict=True):
        assert two.errors[MODEL].course == pytest.approx(one.errors[MODEL].course, rel=1e-2)
        assert two.errors[SHIPPED] != one.errors[SHIPPED] or one.response == "Ra"


def made(*courses: tuple[float, float, float]) -> list[LeftOut]:
    """Predictions of wear with course errors of constant, power law and model."""
    names = (CONSTANT, POWER_LAW, MODEL)
    return [
        LeftOut(
            "3NQ 45 m/s", "wear", "INC751", {name: Error(50.0, value) for name, value in zip(names, each, strict=True)}
        )
        for each in courses
    ]


def test_means_and_differences_are_of_all_predictions():
    each = made((50.0, 20.0, 10.0), (70.0, 24.0, 20.0))
    assert mean_errors(each)[CONSTANT] == (50.0, 60.0)
    assert difference(each, MODEL, POWER_LAW) == pytest.approx((-7.0, 3.0))


def test_what_wins_is_said_only_where_the_difference_is_beyond_its_error():
    (level, course) = comparison(made((50.0, 20.0, 10.0), (70.0, 24.0, 20.0), (60.0, 22.0, 30.0)))
    assert level == "Level of wear: 50.0 % by whatever is fitted to the other alloy."
    assert "constant 60.0 %, power law 22.0 %, model 20.0 %" in course
    assert "neither wins; Model less constant -40.0 +- 5.8 %: the model wins" in course
    (_, course) = comparison(made((50.0, 9.0, 20.0), (70.0, 10.0, 21.5), (60.0, 8.0, 19.2)))
    assert "the power law wins" in course


def test_the_table_ends_with_the_means(found):
    rows = prediction_rows(found)
    assert len(rows) == 14
    assert [row[:3] for row in rows[12:]] == [("mean", "wear", ""), ("mean", "Ra", "")]
    assert all(len(row) == 3 + len(PREDICTORS) for row in rows)
