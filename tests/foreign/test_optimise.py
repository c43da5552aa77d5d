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
            assert found.low <= found.after <= found.high


def test_a_model_that_scraps_what_a_machine_grinds_well_stops(tmp_path: Path) -> None:
    """The catalogue scraps every part of Werner's machine, whose parts are good."""
    shop = SHOPS["Werner"]
    job = shop.write(tmp_path)
    assert optimised(shop, tmp_path, job) is None
