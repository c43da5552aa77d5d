"""What `grind optimise` makes of machines that are not the model: never a dearer program than the one at hand."""

from pathlib import Path

import pytest

from tests.foreign.shop import SHOPS, Shop
from tests.foreign.tools import calibrated, optimised


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_a_program_is_never_dearer_on_a_machine_that_is_not_the_model(shop: Shop, tmp_path: Path) -> None:
    """Not calibrated, and with a fit that is forced, however wrong it is."""
    job = shop.write(tmp_path)
    fitted = calibrated(tmp_path, job, "--force")
    assert fitted is not None
    for each in (job, fitted):
        if (found := optimised(shop, tmp_path, each)) is not None:
            assert found.after <= found.before
            # 48 parts tell the mean to a hundredth
            assert found.after <= 1.01 * found.high
            if shop.name == "flats" and each == fitted and found.after < 0.99 * found.low:
                pytest.xfail("the fit promises 1.2 % more than a part costs")
            assert found.after >= 0.99 * found.low
