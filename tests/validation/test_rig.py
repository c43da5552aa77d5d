"""The rig makes the strokes that the process makes, and finds what it searches."""

import pytest

from grind_env.process.catalogue import load_catalogue
from grind_env.validation.rig import NO_GROWTH, Grinder, Rig, RigError


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig(load_catalogue())


def states(grinder: Grinder) -> tuple[float, ...]:
    return (*grinder.wheel, grinder.S, grinder.Rs, grinder.Z)


def test_strokes_in_one_call_are_those_made_one_by_one(rig):
    one, many = rig.fresh(), rig.fresh()
    for _ in range(7):
        one.grind()
    many.grind(7)
    assert states(one) == states(many)
    assert one.worn == pytest.approx(many.worn, rel=1e-12)


def test_stock_is_what_the_wheel_went_down_less_wear_and_what_is_left(rig):
    grinder = rig.fresh(changes=NO_GROWTH)
    grinder.grind(10)
    before, wear = grinder.S, grinder.wheel.W
    done = grinder.trial(grinder.Z - wear - before)
    again = grinder.grind(1, 0.0)
    assert again.ae == pytest.approx(done.ae, rel=1e-9)
    assert pytest.approx(before + again.ae, rel=1e-12) == grinder.S


@pytest.mark.parametrize("depth", [1e-4, 0.010, 0.080])
def test_the_stroke_of_a_depth_is_found(rig, depth):
    assert rig.sharp(width=5.0).cut(depth).ae == pytest.approx(depth, rel=1e-6)


def test_a_trial_changes_nothing(rig):
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
