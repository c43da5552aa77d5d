import dataclasses
import math
import pickle
import re
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import pytest

from grind_env.errors import GrindError
from grind_env.process import catalogue
from grind_env.process.catalogue import (
    KINDS,
    CatalogueError,
    Entry,
    Material,
    Wheel,
    load_catalogue,
    quantities,
)
from grind_env.process.entries import Quantity
from grind_env.process.tables import keys

BUILT_IN = load_catalogue()
ENTRIES: list[Entry] = [
    *BUILT_IN.materials.values(),
    *BUILT_IN.wheels.values(),
    *BUILT_IN.dressers.values(),
    *BUILT_IN.fluids.values(),
    *BUILT_IN.machines.values(),
]
FIELDS = [pytest.param(entry, key, id=f"{entry.name}-{key}") for entry in ENTRIES for key in quantities(type(entry))]

# Symbols and numbers of model.md sections 0, 8 and 9, typed from there row by row.
MATERIAL_ROWS = """
              u_ch Fpl0 k    rho  c   Ew  nuw  kA      kL    T_temper T_aus gm   pm  u0  Bm
aisi_52100    13.8 1.0  34.3 7815 506 208 0.30 1.24e-6 2e-4  450      780   1    1   6.2 7.18
aisi_1020     13.8 1.0  50   7850 480 205 0.29 0.9e-6  8e-4  600      800   1.3  0.8 6.2 7.18
inconel_718   16   1.6  11.4 8190 435 205 0.29 3.0e-6  12e-4 600      900   0.18 1.2 7.2 5.36
"""
WHEEL_ROWS = """
     dg    Cref kg  Es   mu   kc  pa pb  Gref mG  fc  kf dr    RaRef Af    ka   Ad0   kU     cs
a60j 0.25  3    35  49.6 0.40 2.0 60 7e5 40   0.8 1.2 3  0.030 0.50  0.006 1    0.003 0.0022 1e-4
b126 0.126 8    240 60   0.35 2.6 60 7e5 2500 0.6 1.5 2  0.010 0.40  0.004 0.06 0.004 0.0012 2e-2
"""
COMMON_WHEEL_ROWS = """
     nus  Rr Vr Vt kt  href Amax AL   Vchi ks   kr   alw0 cw   dd    x    ds0 bs
a60j 0.22 5  40 40 1.5 0.1  0.15 0.02 600  0.15 0.45 0.03 0.25 0.010 0.30 300 25
b126 0.22 5  40 40 1.5 0.1  0.15 0.02 600  0.15 0.45 0.03 0.25 0.010 0.30 300 25
"""
OTHER_ROWS = {
    "dresser": "rd kd cD \n single_point 0.5 1.5e-7 0.10",
    "fluid": "hf Tb \n emulsion 1.5e5 110 \n dry 50 110",
    "machine": "ke Pmax acc t_rev Cm \n default 20_000 7500 1000 0.15 80",
}


def by_symbol(entry: Entry) -> dict[str, float]:
    return {quantity.symbol: getattr(entry, key) for key, quantity in quantities(type(entry)).items()}


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


@pytest.mark.parametrize(
    ("kind", "rows"),
    [
        ("material", MATERIAL_ROWS),
        ("wheel", WHEEL_ROWS),
        ("wheel", COMMON_WHEEL_ROWS),
        *OTHER_ROWS.items(),
    ],
)
def test_built_in_entries_hold_the_published_numbers(kind: str, rows: str) -> None:
    header, *lines = rows.strip().splitlines()
    for line in lines:
        name, *numbers = line.split()
        entry = getattr(BUILT_IN, kind)(name)
        expected = dict(zip(header.split(), map(float, numbers), strict=True))
        assert {symbol: by_symbol(entry)[symbol] for symbol in expected} == expected


def test_wheel_layers() -> None:
    a60j, b126 = BUILT_IN.wheel("a60j"), BUILT_IN.wheel("b126")
    assert (a60j.diameter - a60j.minimum_diameter) / 2 == 40.0
    assert (b126.diameter - b126.minimum_diameter) / 2 == 5.0


@pytest.mark.parametrize(
    ("name", "effusivity", "diffusivity"),  # material_thermal_properties.csv
    [("aisi_52100", 11646, 8.67), ("aisi_1020", 13726, 13.27), ("inconel_718", 6373, 3.2)],
)
def test_thermal_properties(name: str, effusivity: float, diffusivity: float) -> None:
    material = BUILT_IN.material(name)
    assert material.effusivity == pytest.approx(effusivity, abs=0.5)
    assert material.diffusivity == pytest.approx(diffusivity, abs=0.005)


def test_steel_burns_at_600_to_700_kelvin_on_malkins_contact() -> None:
    steel = BUILT_IN.material("aisi_52100")
    assert 600 < 1.13 * steel.burn_factor / (1e-6 * steel.effusivity) < 700


def test_every_kind_has_its_table_and_every_field_its_own_symbol() -> None:
    assert {type(entry) for entry in ENTRIES} == set(KINDS.values())
    for heading, kind in KINDS.items():
        assert heading == kind.__name__.lower()
        symbols = [quantity.symbol for quantity in quantities(kind).values()]
        assert len(set(symbols)) == len(symbols)
        assert set(quantities(kind)) == {field.name for field in dataclasses.fields(kind)} - {"name"}


def test_entries_are_frozen_and_survive_pickling() -> None:
    wheel = BUILT_IN.wheel("a60j")
    with pytest.raises(dataclasses.FrozenInstanceError):
        wheel.width = 30.0
    assert pickle.loads(pickle.dumps(BUILT_IN)) == BUILT_IN


@pytest.mark.parametrize(("entry", "key"), FIELDS)
def test_replace_refuses_what_lies_just_outside_the_range(entry: Entry, key: str) -> None:
    quantity = quantities(type(entry))[key]
    for value in (math.nextafter(quantity.low, -math.inf), math.nextafter(quantity.high, math.inf), math.nan):
        with pytest.raises(CatalogueError, match=re.escape(f"'{entry.name}': {key} is {value!r}, ")):
            changed(entry, {key: value})


@pytest.mark.parametrize(("entry", "key"), FIELDS)
def test_replace_accepts_both_ends_of_the_range(entry: Entry, key: str) -> None:
    quantity = quantities(type(entry))[key]
    partners = {pair for pair in entry.ASCENDING if key in pair}
    for value in (quantity.low, quantity.high):
        if all(value < getattr(entry, other) for lesser, other in partners if lesser == key) and all(
            getattr(entry, other) < value for other, greater in partners if greater == key
        ):
            assert getattr(changed(entry, {key: value}), key) == value


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
        (
            BUILT_IN.material("aisi_52100"),
            {"tempering_rise": 780},
            "tempering_rise is 780, but must be below austenitising_rise, 780",
        ),
        (
            BUILT_IN.wheel("a60j"),
            {"diameter": 220},
            "minimum_diameter is 220, but must be below diameter, 220",
        ),
        (
            BUILT_IN.wheel("a60j"),
            {"chatter_reference": 0.1},
            "chatter_onset is 0.15, but must be below chatter_reference, 0.1",
        ),
        (
            BUILT_IN.wheel("a60j"),
            {"wear_flat_limit": 0.02, "wear_flat_floor": 0.03},
            "wear_flat_floor is 0.03",
        ),
        (
            BUILT_IN.wheel("a60j"),
            {"wear_flat_limit": 0.02, "dressed_wear_flat": 0.03},
            "dressed_wear_flat is 0.03",
        ),
        (
            BUILT_IN.machine("default"),
            {"idle_power": 7500},
            "idle_power is 7500, but must be below power_limit, 7500",
        ),
    ],
)
def test_fields_that_must_ascend(entry: Entry, change: dict[str, float], message: str) -> None:
    with pytest.raises(CatalogueError, match=message):
        changed(entry, change)


def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(GrindError) as caught:
        BUILT_IN.material("AISI 52100")
    assert str(caught.value) == (
        "there is no material 'AISI 52100' (did you mean aisi_52100?); known are aisi_1020, aisi_52100, inconel_718."
    )
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


def test_user_entry_can_be_complete(tmp_path: Path) -> None:
    path = write(tmp_path, "[fluid.oil]\nconvection = 2e4\nboiling_rise = 250")
    oil = load_catalogue(str(path)).fluid("oil")
    assert (oil.name, oil.convection, oil.boiling_rise) == ("oil", 2e4, 250.0)


def test_a_key_with_a_default_may_be_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
    class Mist(Entry):
        convection: Annotated[float, Quantity("hf", "W/(m2 K)", 10, 1e6)]
        share: Annotated[float, Quantity("", "", 0, 10)] = 1.0

    monkeypatch.setattr(catalogue, "Fluid", Mist)
    monkeypatch.setattr(catalogue, "KINDS", {"fluid": Mist})
    path = write(tmp_path, '[fluid.thin]\nconvection = 500\n[fluid.oily]\nbase = "thin"\nshare = 0.5')
    fluids = load_catalogue(path).fluids
    assert fluids == {"thin": Mist(name="thin", convection=500.0), "oily": Mist(name="oily", convection=500, share=0.5)}
    assert fluids["thin"].share == 1.0
    with pytest.raises(CatalogueError, match=r"mist 'none': add convection \(10 to 1e\+06 W/\(m2 K\)\), or"):
        load_catalogue(write(tmp_path, "[fluid.none]\nshare = 2"))


def test_later_files_redefine_and_build_on_earlier_ones(tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text('[machine.default]\nbase = "default"\nstiffness = 50_000')
    second.write_text('[machine.default]\nbase = "default"\npower_limit = 15e3')
    machine = load_catalogue(first, second).machine("default")
    assert (machine.stiffness, machine.power_limit, machine.acceleration) == (50_000.0, 15_000.0, 1000.0)
    assert load_catalogue(second).machine("default").stiffness == 20_000.0
    assert load_catalogue() == BUILT_IN


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '[fluid.oil]\nbase = "emulsion"\nconvection = -3',
            "fluid 'oil': convection is -3, but must be a number from 10 to 1e+06 W/(m2 K).",
        ),
        (
            '[fluid.oil]\nbase = "emulsion"\nconvection = "high"',
            "fluid 'oil': convection is 'high', but must be a number from 10 to 1e+06 W/(m2 K).",
        ),
        (
            "[fluid.oil]\nconvection = 2e4",
            "fluid 'oil': add boiling_rise (20 to 1000 K), or name a base that supplies what is missing.",
        ),
        (
            "[fluid.oil]\nconvectoin = 2e4",
            "fluid 'oil': there is no key convectoin (= 20000.0) (did you mean convection?); "
            "the keys are base, convection, boiling_rise.",
        ),
        (
            '[fluid.oil]\nname = "oil"',
            "fluid 'oil': there is no key name (= 'oil'); the keys are base, convection, boiling_rise.",
        ),
        (
            '[fluid.oil]\nbase = "emulsoin"',
            "fluid 'oil': base: there is no fluid 'emulsoin' (did you mean emulsion?); known are dry, emulsion.",
        ),
        (
            '[fluid.oil]\nbase = ["dry"]',
            "fluid 'oil': base: there is no fluid ['dry'] (did you mean dry?); known are dry, emulsion.",
        ),
        (
            "[fluids.oil]\nconvection = 2e4",
            "there is no kind of entry 'fluids' (did you mean fluid?); tables are headed [KIND.NAME], "
            "KIND being one of material, wheel, dresser, fluid, machine.",
        ),
        (
            "[fluid]\nconvection = 2e4",
            "fluid 'convection': found 20000.0 where a table headed [KIND.NAME] belongs.",
        ),
        ("fluid = 3", "fluid: found 3 where a table headed [KIND.NAME] belongs."),
    ],
)
def test_refusals_name_file_entry_key_value_and_range(tmp_path: Path, text: str, message: str) -> None:
    assert refusal(tmp_path, text) == f"{tmp_path / 'shop.toml'}: {message}"


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(CatalogueError, match=r"none\.toml: the catalogue cannot be read: No such file"):
        load_catalogue(tmp_path / "none.toml")
    assert re.search(r"shop\.toml: the catalogue is not valid TOML: .*line 1", refusal(tmp_path, "[fluid.oil\n"))
    (tmp_path / "latin.toml").write_bytes(b"# caf\xe9")
    with pytest.raises(CatalogueError, match=r"latin\.toml: the catalogue is not valid TOML: .*utf-8"):
        load_catalogue(tmp_path / "latin.toml")


def test_a_refused_file_leaves_the_built_in_entries_alone(tmp_path: Path) -> None:
    refusal(tmp_path, '[machine.default]\nbase = "default"\nstiffness = 50_000\n[fluid.oil]\nconvection = 0')
    assert load_catalogue() == BUILT_IN


@pytest.mark.parametrize("kind", [Material, Wheel])
def test_a_missing_entry_lists_all_its_keys(tmp_path: Path, kind: type[Entry]) -> None:
    message = refusal(tmp_path, f"[{kind.__name__.lower()}.bare]")
    required = keys(kind, required=True)
    assert all(f"{key} ({quantity})" in message for key, quantity in quantities(kind).items() if key in required)
