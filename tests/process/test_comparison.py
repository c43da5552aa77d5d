"""Numbers to compare cycles by, worked out by hand."""

import numpy as np
import pytest

from grind_env.process import comparison


def test_by_hand() -> None:
    # 0.01 mm deep, 20 mm wide, 200 mm long at 12 m/min by a wheel of 400 mm at 32 m/s with 1.5 kW
    assert comparison.ground_volume(0.01, 20.0, 200.0) == pytest.approx(40.0)
    assert comparison.grinding_energy(1500.0, 200.0, 200.0) == pytest.approx(1500.0)
    assert comparison.speed_ratio(32.0, 200.0) == pytest.approx(160.0)
    assert comparison.aggressiveness(200.0, 32.0, 0.01, 400.0) == pytest.approx(31.25)  # 10^6/160 times 1/200


def test_arrays_are_as_their_numbers() -> None:
    ae = np.array([0.004, 0.01])
    found = comparison.aggressiveness(np.full(2, 200.0), np.full(2, 32.0), ae, np.full(2, 400.0))
    assert found.tolist() == [comparison.aggressiveness(200.0, 32.0, each, 400.0) for each in ae.tolist()]
