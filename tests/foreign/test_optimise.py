"""What `grind optimise` makes of machines that are not the model: never a dearer program than the one at hand."""

from pathlib import Path

import pytest

from tests.foreign.shop import SHOPS, Shop
from tests.foreign.tools import calibrated, optimised


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_a_program_is_never_dearer_on_a_machine_that_is_not_the_model(shop: Shop, tmp_path: Path) -> None:
    """Not calibrated, where the promise holds as well, and with a fit that is forced, however wrong it is."""
    job = shop.write(tmp_path)
    found = optimised(shop, tmp_path, job)
    assert found is not None and found.after <= found.before
    assert found.low <= found.after <= found.high
    fitted = calibrated(tmp_path, job, "--force")
    assert fitted is not None
    again = optimised(shop, tmp_path, fitted)
    assert again is None or again.after <= again.before


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_the_truth_lies_in_what_a_calibrated_search_promises(shop: Shop, tmp_path: Path) -> None:
    fitted = calibrated(tmp_path, shop.write(tmp_path))
    assert fitted is not None
    found = optimised(shop, tmp_path, fitted)
    assert found is not None and found.low <= found.after <= found.high
