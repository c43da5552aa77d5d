"""Foreign machines share no physics with the package, and `grind optimise` makes no program dearer on them."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.examples import few
from tests.foreign.shop import SHOPS, Shop, cost, depths_of, plans, run, shift, trace, volumes_of
from tests.foreign.tools import calibrated, optimised

each_shop = pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)


@pytest.fixture(scope="module", params=few(SHOPS, 2))
def programmed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Shop, Path, Any]:
    """Return a shop, the folder of its files, and the motions of its lot."""
    shop, folder = SHOPS[request.param], tmp_path_factory.mktemp("shop")
    return shop, folder, trace(folder / "lot.nc", shop.write(folder))


def test_foreign_shops_import_nothing_from_the_package() -> None:
    code = "import sys, tests.foreign.shop; sys.exit(any(name.startswith('grind_env') for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_foreign_machines_grind_the_stock_within_small_errors(programmed: Any) -> None:
    shop, _, motions = programmed
    machine = shop.machine(1)
    parts = [*run(shop, machine, motions)]
    assert len(parts) == 30 and all(abs(part.size) < shop.tolerance for part in parts)
    assert 0.5 * sum(volumes_of(shop)) < machine.volume < sum(volumes_of(shop))
    assert machine.ground == pytest.approx(shop.stock, abs=0.006)


@each_shop
def test_power_grows_with_speed_depth_and_dullness_and_roughness_with_speed(shop: Shop) -> None:
    laws = shop.laws()
    usual = laws.power(0.01, 200.0, 0.01)
    assert usual < laws.power(0.01, 300.0, 0.01) < 1.5 * usual
    assert usual < laws.power(0.02, 200.0, 0.01) < 2.0 * usual
    assert usual < laws.power(0.01, 200.0, 0.03)
    assert laws.roughness(0.01, 300.0, 50.0, 0.01) > laws.roughness(0.01, 200.0, 50.0, 0.01)


def test_a_shift_costs_the_same_as_a_program_with_the_same_settings(programmed: Any) -> None:
    shop, folder, motions = programmed
    depths = depths_of(folder / "one.nc", folder / "job.toml")
    program = cost(shop, [p for k in range(8) for p in run(shop, shop.machine(k), motions)])
    planned = cost(shop, [p for k in range(8) for p in shift(shop, depths, plans(shop)[0], k)])
    assert planned.each == pytest.approx(program.each, rel=0.1)
    assert planned.scrap == program.scrap == 0.0


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_optimise_makes_no_program_dearer_on_a_foreign_machine(shop: Shop, tmp_path: Path) -> None:
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
def test_the_true_cost_lies_in_the_interval_of_a_calibrated_search(shop: Shop, tmp_path: Path) -> None:
    fitted = calibrated(tmp_path, shop.write(tmp_path))
    assert fitted is not None
    for seed in (1, 2, 3):
        found = optimised(shop, tmp_path, fitted, seed)
        assert found is not None and found.low <= found.after <= found.high, seed
