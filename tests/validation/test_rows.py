"""Validation rows: values from the functions of the process, verdicts by bands, known failures with reasons."""

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
    is_expected,
    known_failures,
    measured_data,
    row_of,
    validate,
)
from grind_env.validation.check import Band, band_of
from grind_env.validation.fitted_slopes import exponent, exponents, largest_step, smallest_step
from grind_env.validation.rig import NO_GROWTH, Grinder, RigError
from grind_env.validation.unused_fields import idle_fields

#: rows whose value is a count, a limit or a result of a job, and does not depend on the catalogue
COUNTS = (
    *("catalogue gaps", "idle fields", "cut below the threshold"),
    *("no stall", "stall", "stall is told", "stall is scrap"),
    "roughness scatter",
)
#: rows whose value follows from geometry or the form of a relation, not from constants of the catalogue
SHAPES = (
    *("dress width", "dress overlap", "flats on depth", "flats on lead", "flats at equal overlap"),
    *("flats of a coarse dress", "flats by depth", "flats by lead", "temperature factor of a fast table"),
    *("rubbing force", "power within the limit", "energy linear in flats"),
    *("texture after the lightest stroke", "temperature factor of a usual table"),
)

#: permitted evidence of rows based on files of recalled or derived numbers, by name of the file
MEMORIES = {
    "expected_magnitudes": {Evidence.REMEMBERED},
    "specific_energy_ranges": {Evidence.REMEMBERED},
    "malkin_energy_wearflat": {Evidence.REMEMBERED},
    "burn_threshold_grid": {Evidence.REMEMBERED},
    "wen_optima": {Evidence.REMEMBERED},
    "thermal_partition": {Evidence.REMEMBERED, Evidence.OWN},
    "dressing_overlap": {Evidence.DRAWN},
}


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {row.check.name: row for row in validate()}


def scaled(entry: Entry, factor: float) -> Entry:
    """Return an entry with every number multiplied where ranges and the order of fields allow."""
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


def check_of(value: float, **changes) -> Check:
    """Return a check that measures a given value."""
    fields = {"name": "made up", "group": 1, "what": "a number", "at": "anywhere", "band": Band(1.0, 2.0), **changes}
    return Check(measure=lambda rig: value, **fields)


def test_names_are_unique_and_every_group_has_rows():
    assert len({check.name for check in CHECKS}) == len(CHECKS)
    assert [check.group for check in CHECKS] == sorted(check.group for check in CHECKS)
    assert {check.group for check in CHECKS} == set(GROUPS)
    assert all(check.what and check.at and check.basis.text for check in CHECKS)


def test_every_row_outside_counts_and_shapes_depends_on_the_catalogue(rows):
    moved = {row.check.name: row for row in validate(other_catalogue())}
    fixed = (*COUNTS, *SHAPES)
    still = [
        name for name, row in rows.items() if name not in fixed and not row.missing and row.value == moved[name].value
    ]
    assert still == []


def test_every_measured_reference_lies_within_the_band_of_its_row(rows):
    outside = {check.name for check in CHECKS if check.reference is not None and not check.band.holds(check.reference)}
    assert outside == set()


def test_the_evidence_of_a_row_matches_its_reference_and_file():
    for check in CHECKS:
        basis = check.basis
        assert basis.evidence is not Evidence.MEASURED or check.reference is not None, check.name
        assert basis.evidence is not Evidence.OWN or check.reference is None, check.name
        for name, lines in MEMORIES.items():
            assert name not in basis.text or basis.evidence in lines, f"{check.name}: {name}"


def test_data_recalled_from_memory_are_marked_in_their_files():
    rows = measured_data.rows("specific_energy_ranges") + measured_data.rows("malkin_energy_wearflat")
    assert all("from memory" in row["provenance"] for row in rows)
    readme = (measured_data.DATA / "README.md").read_text(encoding="utf-8")
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
def test_a_band_holds_only_values_within_its_limits(band, inside, outside):
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
def test_a_reference_equals_the_number_in_its_file(rows, name, file, key, column):
    (found,) = (float(row[column]) for row in measured_data.rows(file) if key in (row.get("id"), row.get("quantity")))
    assert rows[name].check.reference == found


def test_a_row_fails_and_names_a_missing_catalogue_entry():
    def measure(rig: Rig) -> float:
        return rig.fresh(wheel="cardboard").wheel.A

    row = row_of(replace(check_of(1.5), measure=measure), Rig(load_catalogue()))
    assert not row.passed and math.isnan(row.value)
    assert "cardboard" in row.missing


@pytest.mark.parametrize("name", known_failures())
def test_a_known_failure_has_a_reason_and_fails(rows, name):
    assert len(known_failures()[name]) > 20
    assert not rows[name].passed, f"{name} passes: take it out of known_failures.toml"


def test_a_row_is_expected_to_pass_unless_it_is_a_known_failure():
    rig = Rig(load_catalogue())
    failing = next(iter(known_failures()))
    assert is_expected(row_of(check_of(1.5), rig))
    assert not is_expected(row_of(check_of(3.0), rig))
    assert is_expected(row_of(check_of(3.0, name=failing), rig))
    assert not is_expected(row_of(check_of(1.5, name=failing), rig))


def test_exponents_and_steps_are_recovered_from_series():
    x = [1.0, 2.0, 5.0]
    assert exponent(x, [3.0 * each**-1.1 for each in x]) == pytest.approx(-1.1)
    z = [2.0, 1.0, 7.0]
    y = [4.0 * one**0.3 * two**-0.8 for one, two in zip(x, z, strict=True)]
    assert exponents([x, z], y) == pytest.approx([0.3, -0.8])
    assert largest_step([4.0, 2.0, 1.5]) == 0.75
    assert smallest_step([1.0, 2.0, 2.5]) == 1.25


def test_idle_fields_finds_a_field_without_effect():
    known = load_catalogue()
    assert "wheel.initial_wear_volume" not in idle_fields(Rig(known))
    firm = {name: replace(wheel, initial_wear=0.0) for name, wheel in known.wheels.items()}
    assert "wheel.initial_wear_volume" in idle_fields(Rig(replace(known, wheels=firm)))


@pytest.mark.parametrize("check", [check for check in CHECKS if check.group < 10], ids=lambda check: check.name)
def test_the_model_shows_every_trend_within_its_band(check: Check, rows: dict[str, Row]) -> None:
    assert rows[check.name].passed, f"{check.what}, {check.at}: {rows[check.name].value}"


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig(load_catalogue())


def states(grinder: Grinder) -> tuple[float, ...]:
    return (*grinder.wheel, grinder.S, grinder.Rs, grinder.Z)


def test_strokes_in_one_call_equal_single_strokes(rig):
    one, many = rig.fresh(), rig.fresh()
    for _ in range(7):
        one.grind()
    many.grind(7)
    assert states(one) == states(many)
    assert one.worn == pytest.approx(many.worn, rel=1e-12)


def test_the_next_cut_follows_from_downfeed_less_wear_and_removed_stock(rig):
    grinder = rig.fresh(changes=NO_GROWTH)
    grinder.grind(10)
    before, wear = grinder.S, grinder.wheel.W
    done = grinder.trial(grinder.Z - wear - before)
    again = grinder.grind(1, 0.0)
    assert again.ae == pytest.approx(done.ae, rel=1e-9)
    assert pytest.approx(before + again.ae, rel=1e-12) == grinder.S


@pytest.mark.parametrize("depth", [1e-4, 0.010, 0.080])
def test_cut_reaches_the_requested_depth(rig, depth):
    assert rig.sharp(width=5.0).cut(depth).ae == pytest.approx(depth, rel=1e-6)


def test_a_trial_stroke_changes_no_state(rig):
    grinder = rig.sharp()
    before = states(grinder)
    grinder.trial(0.02)
    grinder.threshold()
    assert states(grinder) == before


def test_g_ratio_is_work_over_wheel_volume(rig):
    grinder = rig.sharp()
    done = grinder.grind(5)
    assert grinder.g_ratio() == pytest.approx(done.G, rel=0.05)


def test_a_field_that_an_entry_lacks_is_refused(rig):
    with pytest.raises(RigError, match="wheel 'a60j' has no colour"):
        rig.fresh(changes={"wheel": {"colour": 1.0}})


def measured_row(measure) -> Row:
    return row_of(replace(check_of(0.0), measure=measure), Rig(load_catalogue()))


@pytest.mark.parametrize(
    ("setup", "found"),
    [
        ({}, []),
        ({"wheel_speed": 35.0, "width": 25.0}, []),
        ({"wheel_speed": 35.1}, ["wheel speed 35.1 m/s (a60j: at most 35)"]),
        ({"wheel": "b126", "wheel_speed": 60.0}, []),
        ({"wheel": "b126", "diameter": 280.0}, ["wheel diameter 280 mm (b126: at least 290)"]),
        ({"width": 40.0}, ["width 40 mm (a60j: at most 25)"]),
        ({"table_speed": 1000.0}, ["table speed 60 m/min (default: at most 40)"]),
        ({"changes": {"wheel": {"maximum_speed": 50.0}}, "wheel_speed": 45.0}, []),
        # a worn wheel keeps its revolutions or its surface speed
        ({"wheel_speed": 40.0, "diameter": 250.0}, []),
        (
            {"wheel_speed": 36.0, "diameter": 250.0, "constant_surface_speed": True},
            ["wheel speed 36 m/s (a60j: at most 35)"],
        ),
    ],
)
def test_setups_outside_the_catalogue_are_listed(setup, found):
    assert [str(each) for each in measured_row(lambda rig: rig.fresh(**setup).wheel.A).outside] == found


@pytest.mark.nightly
def test_the_spindle_speed_follows_from_wheel_speed_and_diameter():
    (row,) = (row for row in validate() if row.check.name == "valve cBN 80 Ra on removal rate")
    (only,) = row.outside
    assert only.what == "spindle speed"
    assert only.value == pytest.approx(80.0 * 60.0 / (math.pi * 0.3))


def test_a_row_keeps_only_its_farthest_value_outside_the_catalogue():
    rig = Rig(load_catalogue())

    def measure(own: Rig) -> float:
        wheel = own.fresh(wheel_speed=40.0)
        own.with_setup(wheel, wheel_speed=45.0)
        return own.with_setup(wheel, wheel_speed=36.0).wheel.A

    check = Check(name="made up", group=1, what="a number", at="anywhere", band=Band(0.0, 1.0), measure=measure)
    assert [each.value for each in row_of(check, rig).outside] == [45.0]
    assert rig.outside == {}


def test_rows_above_the_wheel_speed_limit_are_marked():
    marked = {row.check.name: row.outside for row in validate() if row.outside}
    fast = {name for name, found in marked.items() if any(each.what == "wheel speed" for each in found)}
    valve = {
        f"valve 3NQ {speed} {response} on {factor}"
        for speed in (45, 80)
        for response in ("wear", "Ra")
        for factor in ("removal rate", "volume removed")
    }
    optima = {check.name for check in CHECKS if check.name.startswith("optimum ")}
    assert fast == valve | optima | {"roughness on wheel speed"} and len(optima) == 5
