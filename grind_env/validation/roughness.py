"""Group 6: roughness of plunge and spark-out, and its scatter."""

from typing import Any

from grind_env.validation.check import Band, Basis, Check, Evidence, around, at_least, at_most
from grind_env.validation.rig import NO_GROWTH, USUAL, Rig, roughness_scatter
from grind_env.validation.slopes import exponent, largest_step

FULL = 40
"""Spark-out passes after which nothing more happens."""
FEEDS = ((0.001, 60.0), (0.002, 100.0), (0.005, 150.0), (0.010, 200.0), (0.020, 333.0))
"""Downfeed, mm, and table speed, mm/s, from the finest to the heaviest."""
SPEEDS = (20.0, 25.0, 30.0, 35.0, 40.0)
"""Wheel speeds, m/s."""


def sparked_out(rig: Rig, **setup: Any) -> float:
    """Ra of a part after 10 strokes and full spark-out with a sharp wheel, um."""
    grinder = rig.sharp(**setup)
    grinder.grind(10)
    return grinder.grind(FULL, 0.0).Ra


def stiffness_ratio(rig: Rig) -> float:
    """Ra on a stiff machine over that on a soft one."""
    stiff, soft = (
        sparked_out(rig, changes={**NO_GROWTH, "machine": {"stiffness": ke}}) for ke in (200_000.0, 10_000.0)
    )
    return stiff / soft


def spark_out_ratio(rig: Rig, downfeed: float, table_speed: float) -> float:
    """Ra after full spark-out over that of the plunge; the wheel was made sharp by the usual strokes."""
    grinder = rig.set_up_anew(rig.sharp(), downfeed=downfeed, table_speed=table_speed)
    plunged = grinder.grind(40).Ra
    return grinder.grind(FULL, 0.0).Ra / plunged


def settled(rig: Rig, material: str, wheel: str) -> float:
    """Ra of a wheel that has ground for a while in a material, um."""
    grinder = rig.fresh(material=material, wheel=wheel)
    return grinder.grind_volume(100.0).Rg


def touched(rig: Rig) -> float:
    """What a touch of 1 nm takes off the roughness of an unground face, %."""
    grinder = rig.fresh()
    return 100.0 * (1.0 - grinder.trial(1e-6).Ra / grinder.Rs)


def on_wheel_speed(rig: Rig) -> float:
    """Exponent of Ra on the wheel speed, with one and the same wheel."""
    wheel = rig.sharp()
    return exponent(SPEEDS, [rig.set_up_anew(wheel, wheel_speed=speed).grind(5).Rg for speed in SPEEDS])


CHECKS = (
    Check(
        name="roughness in nickel, alumina",
        group=6,
        what="Ra in inc751 over that in aisi_52100, alumina: the wheel that wears faster is the rougher",
        at=f"{USUAL}; a60j; 100 mm3/mm after the dress",
        band=Band(1.2, 2.4),
        measure=lambda rig: settled(rig, "inc751", "a60j") / settled(rig, "aisi_52100", "a60j"),
        basis=Basis(Evidence.DRAWN, "(wear over volume)^.3 of valve_alloys.csv (Nametala, CIRP JMST 2020)"),
    ),
    Check(
        name="roughness in nickel, cBN",
        group=6,
        what="that ratio of alumina over that of cBN, which breaks away less",
        at=f"{USUAL}; a60j and b126; 100 mm3/mm after the dress",
        band=at_least(1.05),
        measure=lambda rig: (
            settled(rig, "inc751", "a60j")
            / settled(rig, "aisi_52100", "a60j")
            * settled(rig, "aisi_52100", "b126")
            / settled(rig, "inc751", "b126")
        ),
        basis=Basis(Evidence.DRAWN, "valve_alloys.csv (Nametala, CIRP JMST 2020)"),
    ),
    Check(
        name="first touch",
        group=6,
        what="what a touch of 1 nm takes off the Ra of an unground face",
        at=USUAL,
        unit="%",
        band=at_most(0.1),
        measure=touched,
    ),
    Check(
        name="spark-out roughness on stiffness",
        group=6,
        what="Ra after full spark-out, stiffness 200,000 over 10,000 N/mm",
        at=f"{USUAL}; sharp; 10 strokes, 40 spark-out; a part that does not grow",
        band=around(1.0, 0.1),
        measure=stiffness_ratio,
    ),
    Check(
        name="spark-out roughness on width",
        group=6,
        what="Ra after full spark-out, 60 over 5 mm wide",
        at=f"{USUAL}; sharp; 10 strokes, 40 spark-out; a part that does not grow",
        band=around(1.0, 0.1),
        measure=lambda rig: (
            sparked_out(rig, width=60.0, changes=NO_GROWTH) / sparked_out(rig, width=5.0, changes=NO_GROWTH)
        ),
    ),
    Check(
        name="spark-out gain, finest feed",
        group=6,
        what="Ra after full spark-out over that of the plunge",
        at=f"{USUAL}; sharp; 1 um, 60 mm/s; 40 strokes, 40 spark-out",
        band=around(0.87, 0.07),
        measure=lambda rig: spark_out_ratio(rig, *FEEDS[0]),
    ),
    Check(
        name="spark-out gain, heavy feed",
        group=6,
        what="Ra after full spark-out over that of the plunge",
        at=f"{USUAL}; sharp; 20 um, 333 mm/s; 40 strokes, 40 spark-out",
        band=around(0.40, 0.07),
        measure=lambda rig: spark_out_ratio(rig, *FEEDS[-1]),
    ),
    Check(
        name="spark-out gain with feed",
        group=6,
        what="the same with heavier and heavier feeds, largest step",
        at=f"{USUAL}; sharp; 1 um at 60 mm/s, 2 at 100, 5 at 150, 10 at 200, 20 at 333",
        band=Band(0.0, 0.98),
        measure=lambda rig: largest_step([spark_out_ratio(rig, *feed) for feed in FEEDS]),
    ),
    Check(
        name="roughness on wheel speed",
        group=6,
        what="exponent of Ra on the wheel speed",
        at=f"{USUAL}; sharp; 20 to 40 m/s; stroke 5",
        band=Band(-0.7, -0.3),
        measure=on_wheel_speed,
        basis=Basis(
            Evidence.OWN, "it excludes the -.08 of flat_grinding_L8_dressing.csv, which is of deep and slow passes"
        ),
    ),
    Check(
        name="roughness scatter",
        group=6,
        what="coefficient of variation of Ra from part to part within one setting, beside the gauge's noise",
        at="a batch of a job with nothing said",
        band=Band(0.10, 0.25),
        measure=lambda rig: roughness_scatter(),
        basis=Basis(Evidence.OWN, "320 parts of 52100 ground with cBN scatter by 4 to 12 %, 1200 piston rings by more"),
    ),
)
