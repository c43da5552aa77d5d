"""The measured data of the package, compared with their README, their formulas and each other."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from grind_env.validation import measured_data
from grind_env.validation.fitted_slopes import exponents

README = (measured_data.DATA / "README.md").read_text(encoding="utf-8")
LISTED = {name: int(rows) for name, rows in re.findall(r"^\| `(\w+)\.csv` \| (\d+) \|", README, re.MULTILINE)}


def test_the_readme_lists_every_file():
    assert set(LISTED) == {path.stem for path in measured_data.DATA.glob("*.csv")}


@pytest.mark.parametrize("name", LISTED)
def test_each_file_has_the_stated_number_of_rows_and_no_gaps(name):
    found = measured_data.rows(name)
    assert len(found) == LISTED[name]
    assert all(None not in row and None not in row.values() for row in found)  # as many cells as columns


@pytest.mark.parametrize(
    "owner",
    ["Copyright (c) 2019 Ciniro Nametala", "Copyright (c) 2025 KSF Institute", "CC BY 4.0", "10.5281/zenodo.17873859"],
)
def test_the_readme_names_the_owners_and_licences(owner):
    assert owner in README
    assert "The above copyright notice and this permission notice" in README


def test_the_derived_exponents_follow_from_the_runs():
    runs = measured_data.rows("valve_alloys")
    for row in measured_data.rows("derived_targets"):
        if row["dataset"] != "valve_alloys":
            continue
        wheel, speed, alloy = re.fullmatch(r"(\w+) vs=(\d+) (\S+)", row["subset"]).groups()
        nine = [run for run in runs if (run["wheel"], run["vs_m_s"], run["mat"]) == (wheel, speed, alloy)]
        columns = ("removal_rate_per_s", "volume_removed")
        fitted = exponents(
            [[float(run[name]) for run in nine] for name in columns], [float(run[row["response"]]) for run in nine]
        )
        place = ["exponent on removal rate", "exponent on volume removed"].index(row["quantity"])
        assert fitted[place] == pytest.approx(float(row["value"]), abs=6e-4)


def test_the_rotary_exponents_follow_from_the_eight_runs():
    runs = measured_data.rows("flat_grinding_L8_dressing")
    names = ("dressing_overlap_Ud", "vc_m_per_s", "ae_um", "vw_mm_per_min", "dressing_speed_ratio_qd")
    fitted = exponents([[float(run[name]) for run in runs] for name in names], [float(run["Ra_um"]) for run in runs])
    stated = [float(row["value"]) for row in measured_data.rows("derived_targets") if row["dataset"] == "flat_L8"]
    np.testing.assert_allclose(fitted, stated, atol=6e-4)


def test_the_burn_grid_follows_from_its_formula():
    for row in measured_data.rows("burn_threshold_grid"):
        diameter, depth, speed = float(row["De_mm"]), float(row["ae_um"]) / 1000.0, float(row["vw_m_min"])
        wanted = 6.2 + 1.76 * diameter**0.25 * depth**-0.75 / math.sqrt(speed)
        assert float(row["ustar_J_mm3"]) == pytest.approx(wanted, abs=0.006)


def test_data_lie_inside_the_package():
    assert measured_data.DATA.parents[1].name == "grind_env"
    assert not [path for path in Path(measured_data.DATA).iterdir() if path.suffix not in (".csv", ".md")]
