"""Conditions outside the limits of the catalogue are found from the set-ups that a row makes."""

import math

import pytest

from grind_env.process.catalogue import load_catalogue
from grind_env.validation import CHECKS, Rig, Row, row_of, validate
from grind_env.validation.check import Band, Check


def taken(measure) -> Row:
    check = Check(name="made up", group=1, what="a number", at="anywhere", band=Band(0.0, 1.0), measure=measure)
    return row_of(check, Rig(load_catalogue()))


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
        # a wheel that is worn keeps its revolutions, or its surface speed
        ({"wheel_speed": 40.0, "diameter": 250.0}, []),
        (
            {"wheel_speed": 36.0, "diameter": 250.0, "constant_surface_speed": True},
            ["wheel speed 36 m/s (a60j: at most 35)"],
        ),
    ],
)
def test_what_lies_beyond(setup, found):
    assert [str(each) for each in taken(lambda rig: rig.fresh(**setup).wheel.A).outside] == found


@pytest.mark.nightly
def test_the_speed_of_a_spindle_follows_from_the_wheel():
    (row,) = (row for row in validate() if row.check.name == "valve cBN 80 Ra on removal rate")
    (only,) = row.outside
    assert only.what == "spindle speed"
    assert only.value == pytest.approx(80.0 * 60.0 / (math.pi * 0.3))


def test_the_farthest_of_several_set_ups_is_kept_and_none_of_another_row():
    rig = Rig(load_catalogue())

    def measure(own: Rig) -> float:
        wheel = own.fresh(wheel_speed=40.0)
        own.set_up_anew(wheel, wheel_speed=45.0)
        return own.set_up_anew(wheel, wheel_speed=36.0).wheel.A

    check = Check(name="made up", group=1, what="a number", at="anywhere", band=Band(0.0, 1.0), measure=measure)
    assert [each.value for each in row_of(check, rig).outside] == [45.0]
    assert rig.outside == {}


def test_the_rows_that_a_wheel_of_35_m_per_s_is_asked_for_45_and_80_are_marked():
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
