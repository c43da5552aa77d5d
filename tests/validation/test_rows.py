"""The rows: taken from the functions of the process, judged by their bands, and known to fail only with a reason."""

import math
from dataclasses import replace

import pytest

from grind_env.process.catalogue import Catalogue, load_catalogue
from grind_env.process.entries import CatalogueError, Entry, quantities
from grind_env.validation import (
    CHECKS,
    GROUPS,
    Check,
    Evidence,
    Rig,
    Row,
    data,
    is_as_known,
    known_failures,
    row_of,
    validate,
)
from grind_env.validation.check import Band, band_of
from grind_env.validation.entry_fields import idle_fields
from grind_env.validation.slopes import exponent, exponents, largest_step, smallest_step

COUNTS = (
    *("catalogue gaps", "idle fields", "cut below the threshold"),
    *("no stall", "stall", "stall is told", "stall is scrap"),
    "roughness scatter",
)
"""Rows whose number is a count or a limit that is reached, or one of a job, and stays."""
SHAPES = (
    *("dress width", "dress overlap", "flats on depth", "flats on lead", "flats at equal overlap"),
    *("flats of a coarse dress", "flats by depth", "flats by lead", "temperature factor of a fast table"),
    *("rubbing force", "power within the limit", "energy linear in flats"),
    *("texture after the lightest stroke", "temperature factor of a usual table"),
)
"""Rows that geometry or the form of a relation decides, and no constant of the catalogue."""

MEMORIES = {
    "expected_magnitudes": {Evidence.REMEMBERED},
    "specific_energy_ranges": {Evidence.REMEMBERED},
    "malkin_energy_wearflat": {Evidence.REMEMBERED},
    "burn_threshold_grid": {Evidence.REMEMBERED},
    "wen_optima": {Evidence.REMEMBERED},
    "thermal_partition": {Evidence.REMEMBERED, Evidence.OWN},
    "dressing_overlap": {Evidence.DRAWN},
}
"""What may be made of a file whose numbers nobody measured for this package, by name of the file."""


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {row.check.name: row for row in validate()}


def scaled(entry: Entry, factor: float) -> Entry:
    """An entry with every number multiplied, as far as ranges and the order of fields allow."""
    for name, quantity in quantities(type(entry)).items():
        value = getattr(entry, name)
        if isinstance(value, float) and quantity.allows(value * factor):
            try:
                entry = replace(entry, **{name: value * factor})
            except CatalogueError:
                continue
    return entry


def other_catalogue() -> Catalogue:
    known = load_catalogue()
    kinds = {"materials": 1.07, "wheels": 1.11, "dressers": 1.05, "fluids": 0.93, "machines": 0.9}
    return replace(
        known,
        **{
            kind: {name: scaled(entry, factor) for name, entry in getattr(known, kind).items()}
            for kind, factor in kinds.items()
        },
    )


def made(value: float, **changes) -> Check:
    """A check whose number is given."""
    fields = {"name": "made up", "group": 1, "what": "a number", "at": "anywhere", "band": Band(1.0, 2.0), **changes}
    return Check(measure=lambda rig: value, **fields)


def test_names_are_unique_and_every_group_has_rows():
    assert len({check.name for check in CHECKS}) == len(CHECKS)
    assert [check.group for check in CHECKS] == sorted(check.group for check in CHECKS)
    assert {check.group for check in CHECKS} == set(GROUPS)
    assert all(check.what and check.at and check.basis.text for check in CHECKS)


def test_every_number_comes_from_the_process(rows):
    moved = {row.check.name: row for row in validate(other_catalogue())}
    fixed = (*COUNTS, *SHAPES)
    still = [
        name for name, row in rows.items() if name not in fixed and not row.missing and row.value == moved[name].value
    ]
    assert still == []


def test_a_measured_number_may_lie_outside_the_band_of_its_row_only_where_the_band_is_of_the_trend(rows):
    outside = {check.name for check in CHECKS if check.reference is not None and not check.band.holds(check.reference)}
    assert outside == set()


def test_what_is_called_measured_has_its_number_and_is_no_file_of_the_memory():
    for check in CHECKS:
        basis = check.basis
        assert basis.evidence is not Evidence.MEASURED or check.reference is not None, check.name
        assert basis.evidence is not Evidence.OWN or check.reference is None, check.name
        for name, lines in MEMORIES.items():
            assert name not in basis.text or basis.evidence in lines, f"{check.name}: {name}"


def test_a_band_of_the_memory_is_so_called_where_the_file_says_so():
    rows = data.rows("specific_energy_ranges") + data.rows("malkin_energy_wearflat")
    assert all("from memory" in row["provenance"] for row in rows)
    readme = (data.DATA / "README.md").read_text(encoding="utf-8")
    for name in ("expected_magnitudes", "burn_threshold_grid"):
        assert "from memory" in next(line for line in readme.splitlines() if f"`{name}.csv`" in line)


@pytest.mark.parametrize(
    ("band", "inside", "outside"),
    [
        ("0.4 to 0.7", (0.4, 0.7), (0.39, 0.71)),
        ("at most 1", (-5.0, 1.0), (1.1,)),
        ("at least 1", (1.0, 9.0), (0.9,)),
        ("-1", (-1.0,), (1.0,)),
    ],
)
def test_bands(band, inside, outside):
    read = band_of(band)
    assert all(map(read.holds, inside)) and str(read) == band
    assert not any(map(read.holds, (*outside, math.nan)))


@pytest.mark.parametrize(
    ("name", "file", "key", "column"),
    [
        ("least specific energy", "malkin_energy_wearflat", "u_ch", "value_or_min"),
        ("flats at burn", "malkin_energy_wearflat", "A_burn", "value_or_min"),
        ("dress width", "dressing_overlap_worked_example", "pitch_for_one_overlay", "value"),
    ],
)
def test_a_reference_is_the_number_of_its_file(rows, name, file, key, column):
    (found,) = (float(row[column]) for row in data.rows(file) if key in (row.get("id"), row.get("quantity")))
    assert rows[name].check.reference == found


def test_what_the_catalogue_lacks_is_a_row_that_fails_and_says_so():
    def measure(rig: Rig) -> float:
        return rig.fresh(wheel="cardboard").wheel.A

    row = row_of(replace(made(1.5), measure=measure), Rig(load_catalogue()))
    assert not row.passed and math.isnan(row.value)
    assert "cardboard" in row.missing


@pytest.mark.parametrize("name", known_failures())
def test_a_known_failure_is_a_row_with_a_reason_and_fails(rows, name):
    assert len(known_failures()[name]) > 20
    assert not rows[name].passed, f"{name} passes: take it out of known_failures.toml"


def test_a_row_is_as_known():
    rig = Rig(load_catalogue())
    failing = next(iter(known_failures()))
    assert is_as_known(row_of(made(1.5), rig))
    assert not is_as_known(row_of(made(3.0), rig))
    assert is_as_known(row_of(made(3.0, name=failing), rig))
    assert not is_as_known(row_of(made(1.5, name=failing), rig))


def test_exponents_and_steps():
    x = [1.0, 2.0, 5.0]
    assert exponent(x, [3.0 * each**-1.1 for each in x]) == pytest.approx(-1.1)
    z = [2.0, 1.0, 7.0]
    y = [4.0 * one**0.3 * two**-0.8 for one, two in zip(x, z, strict=True)]
    assert exponents([x, z], y) == pytest.approx([0.3, -0.8])
    assert largest_step([4.0, 2.0, 1.5]) == 0.75
    assert smallest_step([1.0, 2.0, 2.5]) == 1.25


def test_a_field_that_does_nothing_is_found():
    known = load_catalogue()
    assert "wheel.initial_wear_volume" not in idle_fields(Rig(known))
    firm = {name: replace(wheel, initial_wear=0.0) for name, wheel in known.wheels.items()}
    assert "wheel.initial_wear_volume" in idle_fields(Rig(replace(known, wheels=firm)))


@pytest.mark.parametrize("check", [check for check in CHECKS if check.group < 10], ids=lambda check: check.name)
def test_the_model_shows_every_trend_within_its_band(check: Check, rows: dict[str, Row]) -> None:
    assert rows[check.name].passed, f"{check.what}, {check.at}: {rows[check.name].value}"
