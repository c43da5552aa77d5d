"""Machines by name, and the numbers drawn for them."""

import math
from hashlib import sha256

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.plants import FAMILIES, Family, Plant, PlantError, find_plant, find_plants
from grind_env.plants.family import HELD_OUT, PUBLIC
from grind_env.plants.plant import mixed
from grind_env.plants.plant_names import PUBLIC_FAMILIES
from grind_env.process.gauge_readings import TRUTH
from grind_env.process.process_interface import PROCESS

SEEDS = st.integers(0, 2**32 - 1)
GAUGED = ("thermal", "meter", "drift")
NAMES = [each.name for each in FAMILIES]
#: hash of the draws of the first machines. Scores on them are comparable only while it stays the same
DIGEST = "276515d58c2b59d1"
#: hashes of the first 40 machines of each set, recorded before the newest family was added
SET_DIGESTS = {"public": "2ae7feb7a61781d5", "held-out": "dbe19a364599d121"}


def differing(plant: Plant) -> set[str]:
    """Return the families in which a machine differs from neutral numbers."""
    numbers = zip(plant.remembers._fields, plant.own, plant.remembers(), strict=True)
    return {name.partition("_")[0] for name, number, neutral in numbers if number != neutral}


@given(family=st.sampled_from(FAMILIES), seed=SEEDS, stream=st.sampled_from([PUBLIC, HELD_OUT]))
def test_a_family_draws_repeatable_numbers_within_its_ranges(family: Family, seed: int, stream: int) -> None:
    numbers = family.drawn(seed, stream)
    assert numbers == family.drawn(seed, stream)
    assert all(each.ends(stream)[0] <= numbers[each.field] <= each.ends(stream)[1] for each in family.ranges)
    assert set(numbers) == {each.field for each in family.ranges} | (
        {f"{family.name}_seed"} if family.chances else set()
    )


@pytest.mark.parametrize("each", [each for family in FAMILIES for each in family.ranges], ids=lambda each: each.field)
def test_a_range_covers_both_ends_and_spaces_factors_logarithmically(each) -> None:
    assert (each.at(0.0), each.at(1.0)) == (pytest.approx(each.low), pytest.approx(each.high)) and each.low < each.high
    middle = math.sqrt(each.low * each.high) if each.factor else 0.5 * (each.low + each.high)
    assert each.at(0.5) == pytest.approx(middle)
    assert each.basis.text


@pytest.mark.bits
def test_draws_of_the_first_machines_match_the_recorded_hash() -> None:
    streams = (PUBLIC, HELD_OUT)
    drawn = [family.drawn(seed, stream) for family in PUBLIC_FAMILIES for seed in range(3) for stream in streams]
    names = [sorted(differing(find_plant(f"held-out:{seed}"))) for seed in range(20)]
    assert sha256(repr((drawn, names)).encode()).hexdigest()[:16] == DIGEST


@pytest.mark.bits
@pytest.mark.parametrize("name", SET_DIGESTS)
def test_the_first_machines_of_a_set_match_the_recorded_hash(name: str) -> None:
    plants = [find_plant(f"{name}:{seed}") for seed in range(40)]
    ours = len(PROCESS.own._fields)
    text = repr([(plant.name, plant.remembers._fields[ours:], plant.own[ours:], plant.anew) for plant in plants])
    assert sha256(text.encode()).hexdigest()[:16] == SET_DIGESTS[name]


@given(name=st.sampled_from(NAMES), seed=SEEDS)
def test_a_machine_has_the_numbers_of_its_family_and_shares_its_functions(name: str, seed: int) -> None:
    plant, other = find_plant(f"{name}:{seed}"), find_plant(f"{name}:1")
    assert plant.name == f"{name}:{seed}"
    assert plant.process == other.process and plant.gauge == other.gauge
    assert differing(plant) <= {name}
    drawn = FAMILIES[NAMES.index(name)].drawn(seed)
    assert {field: dict(zip(plant.remembers._fields, plant.own, strict=True))[field] for field in drawn} == drawn
    assert (plant.process is PROCESS) == (name == "meter") and (plant.gauge is not TRUTH) == (name in GAUGED)


def test_a_mix_combines_its_members_in_any_order() -> None:
    mix = find_plant("meter:7+foreign:3")
    assert mix == find_plant("foreign:3+meter:07") and mix.name == "foreign:3+meter:7"
    foreign, meter = find_plant("foreign:3"), find_plant("meter:7")
    assert mix.process == foreign.process and mix.gauge == meter.gauge
    assert mix.own == foreign.of_process + meter.own[len(meter.of_process) :]


@given(name=st.sampled_from(["public", "held-out"]), seed=SEEDS)
def test_sets_mix_two_to_four_families_and_held_out_sets_avoid_public_numbers(name: str, seed: int) -> None:
    plant, first = find_plant(f"{name}:{seed}"), find_plant("held-out:0")
    families = differing(plant)
    assert 2 <= len(families) <= 4 and families <= {*NAMES} and not {"foreign", "bursts"} <= families
    assert (plant.process, plant.gauge) == (first.process, first.gauge)
    numbers = {*zip(plant.remembers._fields, plant.own, strict=True)}
    for family in FAMILIES:
        if family.name in families:
            public = {*family.drawn(seed).items()}
            assert public <= numbers if name == "public" else not public & numbers


def test_public_and_held_out_draws_share_no_number() -> None:
    def all_of(stream: int) -> set[tuple[str, float]]:
        drawn = [family.drawn(seed, stream) for family in FAMILIES for seed in range(200)]
        return {(field, number) for numbers in drawn for field, number in numbers.items()}

    public, held_out = all_of(PUBLIC), all_of(HELD_OUT)
    assert len(public) == len(held_out) > 200 * sum(len(family.ranges) for family in FAMILIES) - 5
    assert not public & held_out
    found = {name for seed in range(60) for name in differing(find_plant(f"held-out:{seed}"))}
    assert found == {each.name for each in PUBLIC_FAMILIES}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (7, "a machine is named by a text, but not by 7: name 'meter:7'"),
        (
            "metre:7",
            r"no machine 'metre:7' \(did you mean meter\?\): name 'meter:7', .* the families are foreign, bursts",
        ),
        ("meter", "no machine 'meter'"),
        ("", "no machine ''"),
        ("meter:-1", "no machine 'meter:-1'"),
        ("meter:x", "no machine 'meter:x'"),
        ("meter:1+", r"no machine 'meter:1\+'"),
        ("meter:4294967296", "the seed in 'meter:4294967296' is too large: give one from 0 to 4294967295"),
        (f"meter:{'9' * 5000}", r"the seed in 'meter:9+\.\.\. .* is too large"),
        ("meter:1+meter:2", "has one machine of a family, but two of 'meter'"),
        ("bursts:1+foreign:2", "foreign and bursts each say what grinds, and a mix has one of these"),
        ("held-out:1+meter:2", "mixes a machine that is held out, which is a mix already: name it alone"),
        ("public:1+meter:2", "mixes a machine that is public, which is a mix already: name it alone"),
        ("os:system", "'os:system' would run the code of a module, which a name in a file must not"),
        ("meter:1+os:system:2", "would run the code of a module"),
    ],
)
def test_invalid_machine_names_are_rejected(text: str, said: str) -> None:
    with pytest.raises(PlantError, match=said) as caught:
        find_plant(text)
    assert len(str(caught.value)) < 400


def test_a_user_module_provides_machines_and_families(module: str) -> None:
    mine = find_plant(f"{module}:MINE", modules=True)
    assert (mine.name, mine.own, mine.of_process) == (f"{module}:MINE", (*PROCESS.own(), 0.25), (*PROCESS.own(), 0.25))
    member = find_plant(f"meter:7+{module}:STICKY:3", modules=True)
    assert member.name == f"meter:7+{module}:STICKY:3"
    numbers = dict(zip(member.remembers._fields, member.own, strict=True))
    assert 1.0 < numbers["sticky_by"] < 2.0
    assert numbers["meter_gain"] == find_plant("meter:7").own[len(PROCESS.own._fields)]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("STICKY", "is a family of machines: give a seed, as 'my_machines:STICKY:1'"),
        ("MINE:3", "'my_machines:MINE:3' is no member of a family: a Plant has no seed, and stands in no mix"),
        ("NUMBER", "is of type int: name a Plant or a Family of grind_env.plants"),
        ("THEIRS", "names no machine .*THEIRS"),
        ("WRONG:1", "wrong.*sticky_by.*; let what a family draws be fields of what it remembers"),
    ],
)
def test_unusable_names_of_a_user_module_are_rejected(module: str, name: str, said: str) -> None:
    with pytest.raises(PlantError, match=said.replace("wrong", f"{module}:WRONG:1")):
        find_plant(f"{module}:{name}", modules=True)


@pytest.mark.parametrize("text", ["meter", "held-out", "foreign+meter:7", "meter:7", "my_machines:STICKY"])
def test_a_name_without_a_seed_stands_for_one_machine_per_seed(module: str, text: str) -> None:
    plants = find_plants(text, modules=True)
    one = plants.seeded(5)
    assert one.first == find_plant(text, seed=5, modules=True) and one.text == one.first.name and one.one
    assert one.first == find_plant(one.text, modules=True)
    assert plants.one == (text == "meter:7") and (plants.seeded(6) == one) == plants.one
    assert (one.first.process, one.first.gauge) == (plants.first.process, plants.first.gauge)
    assert one.text == {"foreign+meter:7": "foreign:5+meter:7", "meter:7": "meter:7"}.get(text, f"{text}:5")


def test_a_user_defined_plant_has_no_seed(module: str) -> None:
    plants = find_plants(f"{module}:MINE", modules=True)
    assert plants.one and plants.seeded(3) is plants and plants.text == f"{module}:MINE"


def test_an_import_failure_of_a_user_module_is_reported(module: str) -> None:
    for name, said in (("my_mistake", "division by zero"), ("nowhere", "No module named"), ("my_end", "good bye")):
        with pytest.raises(PlantError, match=said):
            find_plant(f"{name}:MINE", modules=True)


def test_a_plant_needs_one_number_per_remembered_field() -> None:
    assert Plant(name="ours").own == tuple(PROCESS.own())
    with pytest.raises(
        PlantError, match=r"own has 2 numbers, but .* remember 4: give one for each of dT_1, dT_2, dT_3"
    ):
        Plant(name="ours", own=(0.0, 1.0))


def test_remembered_fields_begin_with_the_name_of_their_family() -> None:
    for family in FAMILIES:
        fields = mixed(family.name, (family,), {}).remembers._fields
        assert all(name.startswith(f"{family.name}_") for name in fields if name not in PROCESS.own._fields)
        assert family.what and {each.field for each in family.ranges} < {*fields}
