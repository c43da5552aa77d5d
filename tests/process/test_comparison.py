"""Numbers to compare cycles by, worked out by hand."""

import numpy as np
import pytest

from grind_env.process import comparison


def test_by_hand() -> None:
    # 0.01 mm deep at 12 m/min, wheel of 400 mm at 32 m/s; then a fourth as deep
    ae, vw, vs, ds = np.array([0.01, 0.0025]), np.full(2, 200.0), np.full(2, 32.0), np.full(2, 400.0)
    assert comparison.speed_ratio(vs, vw) == pytest.approx([160.0, 160.0])
    # 10^6/160 times 1/200, and half of that
    assert comparison.aggressiveness(vw, vs, ae, ds) == pytest.approx([31.25, 15.625])
