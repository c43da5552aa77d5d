import dataclasses
import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from grind_env.errors import GrindError
from grind_env.machine.job import WheelStart
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.catalogue_parameters import stroke_parameters
from grind_env.process.entries import CatalogueError, Entry, Fluid, Material, Quantity, Wheel, quantities
from grind_env.process.stroke_types import StrokeParameters
from grind_env.process.toml_tables import keys
from tests.machine.harness import HEAD, job, run

BUILT_IN = load_catalogue()
ENTRIES: list[Entry] = [
    *BUILT_IN.materials.values(),
    *BUILT_IN.wheels.values(),
    *BUILT_IN.dressers.values(),
    *BUILT_IN.fluids.values(),
    *BUILT_IN.machines.values(),
]
FIELDS = [
    (entry, key)
    for entry in ENTRIES
    for key, quantity in quantities(type(entry)).items()
    if isinstance(quantity, Quantity)
]


def changed(entry: Entry, change: dict[str, Any]) -> Entry:
    return dataclasses.replace(entry, **change)


def write(folder: Path, text: str) -> Path:
    path = folder / "shop.toml"
    path.write_text(text, encoding="utf-8")
    return path


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(CatalogueError) as caught:
        load_catalogue(write(folder, text))
    return str(caught.value)


GENTLE, DEEP, TOO_MUCH = (
    f"G00 X-30. Y0\nG82 X230. I-30. Y-.1 {rest} F60. P9100 D1\nG80\nG00 Y20.\n"
    for rest in ("J-.01 L2 E12000.", "J-.03 L2 E12000.", "J-.1 L2 E30000.")
)
#: three parts with a dress in each, ground harder and harder; the spindle stalls in the third
BATCH = HEAD + f"{GENTLE}M00\n{DEEP}M00\n{TOO_MUCH}M30\n"


#: one entry of each kind, away from the reference conditions of the other entries
USUAL: dict[str, Entry] = {
    "material": BUILT_IN.material("aisi_52100"),
    "wheel": changed(BUILT_IN.wheel("a60j"), {"maximum_speed": 23.0}),  # slightly exceeded
    "dresser": changed(BUILT_IN.dresser("rotary"), {"speed_ratio": 0.7}),
    "fluid": changed(BUILT_IN.fluid("oil"), {"boiling_rise": 200.0}),  # exceeded in the second part
    "machine": changed(
        BUILT_IN.machine("default"),  # all maxima are exceeded
        {
            "maximum_table_speed": 29_000,
            "maximum_plunge_feed": 50,
            "maximum_cross_feed": 150,
            "maximum_spindle_speed": 1850,
        },
    ),
}


def run_batch(**entries: Entry) -> tuple[object, ...]:
    """Return all results of the batch: strokes, dresses, parts with times and costs, and warnings."""
    setup = USUAL | entries
    material = setup.pop("material")
    # a wheel just above the diameter at which the operator changes it
    ground = job(setup=setup, wheel_start=WheelStart(diameter=min(220.1, setup["wheel"].diameter), diamond_flat=0.05))
    part = dataclasses.replace(ground.part, material=material)
    times = dataclasses.replace(ground.times, wheel_change=100.0)
    ground = dataclasses.replace(ground, part=part, times=times)
    record = run(BATCH, ground)
    assert record.parts["peak_torque"][-1] >= 1.0
    return record.strokes.tobytes(), record.dresses.tobytes(), record.parts.tobytes(), record.warnings


@pytest.mark.parametrize("kind", USUAL)
def test_every_number_of_an_entry_affects_the_results(kind: str) -> None:
    entry, before = USUAL[kind], run_batch()
    without_effect = []
    for key, quantity in quantities(type(entry)).items():
        # alumina does not use the factor of CBN; a maximum only causes warnings; meter_scale only scales readings
        elsewhere = key in ("g_ratio_factor_cbn", "meter_scale") or key.startswith("maximum_")
        if isinstance(quantity, Quantity) and not elsewhere:
            value = getattr(entry, key)
            other = 0.9 * value if value else -0.01 if quantity.low < 0.0 else 100.0
            after = run_batch(**{kind: changed(entry, {key: other})})
            without_effect += [key] if after == before else []
    assert without_effect == []


def test_the_abrasive_selects_material_factor_and_reference_grade() -> None:
    def of(abrasive: str, fracture_force: float) -> StrokeParameters:
        change = {"abrasive": abrasive, "fracture_force": fracture_force}
        return stroke_parameters(
            BUILT_IN.material("inconel_718"),
            changed(BUILT_IN.wheel("a60j"), change),
            BUILT_IN.dresser("single_point"),
            BUILT_IN.fluid("emulsion"),
            BUILT_IN.machine("default"),
            wheel_speed=30.0,
            width=20.0,
            height=20.0,
        )

    wheel = BUILT_IN.wheel("a60j")
    alumina, cbn = of("alumina", 1.2), of("cbn", 4.0)  # both of their reference grade
    assert (alumina.gm, cbn.gm) == (0.18, 0.038)
    assert alumina.Gref == pytest.approx(wheel.g_ratio * 0.18, rel=1e-12)
    assert cbn.Gref == pytest.approx(wheel.g_ratio * 0.038, rel=1e-12)
    assert alumina.dr == cbn.dr == wheel.renewal_depth
    assert cbn == alumina._replace(Gref=cbn.Gref, gm=cbn.gm, fc=4.0)
    # the force that breaks alumina of grade J is that of a very soft CBN wheel
    soft = of("cbn", 1.2)
    assert soft.Gref == pytest.approx(math.sqrt(0.3) * cbn.Gref, rel=1e-12)
    assert soft.dr < 0.3 * cbn.dr


@pytest.mark.parametrize("value", ["diamond", "CBN", "", 1.0, True, None])
def test_an_unknown_abrasive_is_rejected(value: object) -> None:
    with pytest.raises(CatalogueError, match=r"^wheel 'a60j': abrasive is .*, but must be 'alumina' or 'cbn'\.$"):
        dataclasses.replace(BUILT_IN.wheel("a60j"), abrasive=value)


def test_the_burn_threshold_grows_with_the_conductivity_of_the_work() -> None:
    steel = BUILT_IN.material("aisi_52100")
    assert steel.burn_rise < 700
    twice = changed(steel, {"conductivity": 2.0 * steel.conductivity})
    assert twice.burn_factor == pytest.approx(math.sqrt(2.0) * steel.burn_factor)  # as the flux of a moving source


def test_every_kind_has_its_table_and_every_field_its_own_symbol() -> None:
    assert {type(entry) for entry in ENTRIES} == set(KINDS.values())
    for heading, kind in KINDS.items():
        assert heading == kind.__name__.lower()
        symbols = [quantity.symbol for quantity in quantities(kind).values() if isinstance(quantity, Quantity)]
        assert len(set(symbols)) == len(symbols)
        assert set(quantities(kind)) == {field.name for field in dataclasses.fields(kind)} - {"name", "aliases"}


def test_replace_refuses_values_just_outside_the_range() -> None:
    for entry, key in FIELDS:
        quantity = quantities(type(entry))[key]
        for value in (math.nextafter(quantity.low, -math.inf), math.nextafter(quantity.high, math.inf), math.nan):
            with pytest.raises(CatalogueError, match=re.escape(f"'{entry.name}': {key} is {value!r}, ")):
                changed(entry, {key: value})


def test_replace_accepts_both_ends_of_the_range() -> None:
    for entry, key in FIELDS:
        quantity = quantities(type(entry))[key]
        partners = {pair for pair in entry.ASCENDING if key in pair}
        for value in (quantity.low, quantity.high):
            if all(value < getattr(entry, other) for lesser, other in partners if lesser == key) and all(
                getattr(entry, other) < value for other, greater in partners if greater == key
            ):
                assert getattr(changed(entry, {key: value}), key) == value, (entry.name, key)


@pytest.mark.parametrize("value", ["1", True, None, [1.0], 1j])
def test_only_numbers_are_accepted(value: object) -> None:
    with pytest.raises(CatalogueError, match=r"pressure_factor is .*, but must be a number from 0\.1 to 10\."):
        dataclasses.replace(BUILT_IN.material("aisi_52100"), pressure_factor=value)


@pytest.mark.parametrize("value", [7815, Fraction(7815)])
def test_numbers_are_stored_as_floats(value: float) -> None:
    density = dataclasses.replace(BUILT_IN.material("aisi_52100"), density=value).density
    assert (type(density), density) == (float, 7815.0)


@pytest.mark.parametrize(
    ("entry", "change", "message"),
    [
        (BUILT_IN.wheel("a60j"), {"diameter": 220}, "minimum_diameter is 220, but must be below diameter, 220"),
        (BUILT_IN.wheel("a60j"), {"wear_flat_limit": 0.02, "wear_flat_floor": 0.03}, "wear_flat_floor is 0.03"),
        (BUILT_IN.wheel("a60j"), {"wear_flat_limit": 0.02, "dressed_wear_flat": 0.03}, "dressed_wear_flat is 0.03"),
        (BUILT_IN.machine("default"), {"idle_power": 7500}, "idle_power is 7500, but must be below power_limit, 7500"),
    ],
)
def test_fields_out_of_ascending_order_are_rejected(entry: Entry, change: dict[str, float], message: str) -> None:
    with pytest.raises(CatalogueError, match=message):
        changed(entry, change)


def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(GrindError) as caught:
        BUILT_IN.material("AISI 52101")
    assert str(caught.value).startswith("there is no material 'AISI 52101' (did you mean aisi_52100?); known are ")
    for look_up in (BUILT_IN.wheel, BUILT_IN.dresser, BUILT_IN.fluid, BUILT_IN.machine):
        with pytest.raises(CatalogueError, match=r"^there is no \w+ 'xyz'; known are \w+"):
            look_up("xyz")


def test_user_entry_inherits_from_its_base(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        """
        [material.lot_7]
        base = "aisi_52100"
        wear_flat_growth = 2.5e-6
        [material.lot_8]
        base = "lot_7"
        conductivity = 30
        """,
    )
    expected = dataclasses.replace(
        BUILT_IN.material("aisi_52100"), name="lot_8", wear_flat_growth=2.5e-6, conductivity=30.0
    )
    catalogue = load_catalogue(path)
    assert catalogue.material("lot_8") == expected
    assert set(catalogue.materials) == {*BUILT_IN.materials, "lot_7", "lot_8"}
    assert catalogue.wheels == BUILT_IN.wheels


def test_user_entry_may_omit_fields_with_a_default(tmp_path: Path) -> None:
    path = write(tmp_path, "[fluid.mist]\nconvection = 2e4\nboiling_rise = 250")
    mist = load_catalogue(str(path)).fluid("mist")
    assert (mist.name, mist.convection, mist.boiling_rise) == ("mist", 2e4, 250.0)
    emulsion = BUILT_IN.fluid("emulsion")
    factors = {key for key in quantities(Fluid) if key.endswith("_factor")}
    assert len(factors) == 6
    assert {key: getattr(mist, key) for key in factors} == {key: getattr(emulsion, key) for key in factors}


def test_later_files_redefine_and_build_on_earlier_ones(tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text('[machine.default]\nbase = "default"\nstiffness = 50_000')
    second.write_text('[machine.default]\nbase = "default"\npower_limit = 15e3')
    machine = load_catalogue(first, second).machine("default")
    assert (machine.stiffness, machine.power_limit, machine.acceleration) == (50_000.0, 15_000.0, 1000.0)
    assert load_catalogue(second).machine("default").stiffness == 20_000.0
    assert load_catalogue() == BUILT_IN


@pytest.mark.parametrize(
    ("text", "place", "remedy"),
    [
        (
            '[fluid.mist]\nbase = "emulsion"\nconvection = -3',
            "fluid 'mist': convection is -3, ",
            "from 10 to 1e+06 W/(m2 K)",
        ),
        ("[fluid.mist]\nconvection = 2e4", "fluid 'mist': ", "add boiling_rise (20 to 100000 K)"),
        ("[fluid.mist]\nconvectoin = 2e4", "fluid 'mist': there is no key convectoin ", "(did you mean convection?)"),
        ('[wheel.soft]\nbase = "a60j"\nforce_ratio = 2', "wheel 'soft': ", "was renamed to normal_force_ratio"),
        ('[fluid.mist]\nbase = "emulsoin"', "fluid 'mist': base: ", "(did you mean emulsion?)"),
        ("[fluids.mist]\nconvection = 2e4", "there is no kind of entry 'fluids' ", "(did you mean fluid?)"),
        ("[fluid]\nconvection = 2e4", "fluid 'convection': found 20000.0 ", "where a table headed [KIND.NAME] belongs"),
    ],
)
def test_refusals_name_file_entry_key_value_and_range(tmp_path: Path, text: str, place: str, remedy: str) -> None:
    message = refusal(tmp_path, text)
    assert message.startswith(f"{tmp_path / 'shop.toml'}: {place}") and remedy in message


def test_unreadable_catalogue_files_are_reported(tmp_path: Path) -> None:
    with pytest.raises(CatalogueError, match=r"none\.toml: the catalogue cannot be read: No such file"):
        load_catalogue(tmp_path / "none.toml")
    assert re.search(r"shop\.toml: the catalogue is not valid TOML: .*line 1", refusal(tmp_path, "[fluid.oil\n"))
    assert "in line 2 write -1.5, with a decimal point" in refusal(tmp_path, "[fluid.oil]\nconvection = -1,5  # W\n")
    (tmp_path / "latin.toml").write_bytes(b"# caf\xe9")
    with pytest.raises(CatalogueError, match=r"latin\.toml: the catalogue is not valid TOML: line 1 is not in UTF-8"):
        load_catalogue(tmp_path / "latin.toml")


@pytest.mark.parametrize("kind", [Material, Wheel])
def test_a_missing_entry_lists_all_its_keys(tmp_path: Path, kind: type[Entry]) -> None:
    message = refusal(tmp_path, f"[{kind.__name__.lower()}.bare]")
    required = keys(kind, required=True)
    assert all(f"{key} ({quantity})" in message for key, quantity in quantities(kind).items() if key in required)


# As steel keys (DIN EN 10027-2, EN 1561, JIS, UNS) and makers list them.
NAMES_ELSEWHERE = {
    "aisi_52100": ("100Cr6", "1.3505", "SUJ2"),
    "aisi_1020": ("1.0402",),
    "aisi_1045": ("C45", "1.1191"),
    "aisi_d2": ("1.2379", "SKD11"),
    "aisi_m2": ("HS6-5-2", "1.3343"),
    "case_hardened_16mncr5": ("16 MnCr 5", "1.7131"),
    "grey_cast_iron": ("EN-GJL-250", "gg 25"),
    "inconel_718": ("2.4668", "Inconel 718"),
    "inc751": ("2.4694",),
    "ti_6al_4v": ("TiAl6V4", "3.7165", "Ti-6Al-4V"),
}


def test_materials_are_found_by_the_names_of_standards() -> None:
    known = load_catalogue()
    assert NAMES_ELSEWHERE.keys() == known.materials.keys()
    for entry, names in NAMES_ELSEWHERE.items():
        assert {known.material(name).name for name in names} == {entry}
    folded = [
        "".join(filter(str.isalnum, each.lower())) for entry in known.materials.values() for each in entry.aliases
    ]
    assert len(set(folded)) == len(folded)
    with pytest.raises(CatalogueError, match=r"there is no material 'SUJ3' \(did you mean SUJ2\?\)"):
        known.material("SUJ3")


def test_user_names_precede_aliases_of_other_entries(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(
        '[material.aisi_52100]\nbase = "SUJ2"\n[material.lot]\nbase = "100Cr6"\naliases = ["LOT 7"]\n'
        '[material.C45]\nbase = "1.1191"\n'
    )
    known = load_catalogue(path)
    names = {"100Cr6": "aisi_52100", "lot7": "lot", "C45": "C45", "1.0503": "aisi_1045"}
    assert {name: known.material(name).name for name in names} == names
    path.write_text('[material.lot]\nbase = "aisi_52100"\naliases = "LOT 7"\n')
    with pytest.raises(CatalogueError, match="aliases is 'LOT 7', but must be a list of texts"):
        load_catalogue(path)
