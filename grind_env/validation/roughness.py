"""Group 6: roughness of plunge and spark-out, and its scatter."""

from functools import partial

from grind_env.validation.check import Band, Question, around, at_least, at_most, drawn, own
from grind_env.validation.measures import Measurement, exponent_on, over, quotient, sharp_then, stroke, value
from grind_env.validation.rig import NO_GROWTH, Grinder, Rig, roughness_scatter
from grind_env.validation.slopes import largest_step

FULL = 40
"""Spark-out passes after which nothing more happens."""
FEEDS = [
    {"downfeed": downfeed, "table_speed": speed}
    for downfeed, speed in ((0.001, 60.0), (0.002, 100.0), (0.005, 150.0), (0.010, 200.0), (0.020, 333.0))
]
"""Downfeed, mm, and table speed, mm/s, from the finest to the heaviest."""
STIFF_AND_SOFT = [{**NO_GROWTH, "machine": {"stiffness": stiffness}} for stiffness in (200_000.0, 10_000.0)]
VALVES = "valve_alloys.csv (Nametala, CIRP JMST 2020)"

ask = partial(Question, 6)


def sparked_out(grinder: Grinder) -> float:
    """Return Ra of a part after 10 strokes and full spark-out, um."""
    grinder.grind(10)
    return grinder.grind(FULL, 0.0).Ra


def spark_out_gain(grinder: Grinder) -> float:
    """Return Ra after full spark-out over that of the plunge."""
    plunged = grinder.grind(40).Ra
    return grinder.grind(FULL, 0.0).Ra / plunged


def in_nickel(wheel: str) -> Measurement:
    """Measure the settled Ra in a nickel alloy over that in steel."""
    alloys = over("material", ("inc751", "aisi_52100"), wheel=wheel)
    return Measurement(lambda grinder: grinder.grind_volume(100.0).Rg, alloys, quotient)


AFTER = "usual; sharp; 10 strokes, 40 spark-out; a part that does not grow"
GAIN = "Ra after full spark-out over that of the plunge"

CHECKS = (
    ask(
        "roughness in nickel, alumina",
        "Ra in inc751 over that in aisi_52100, alumina: the wheel that wears faster is the rougher",
        "usual; a60j; 100 mm3/mm after the dress",
    ).within(Band(1.2, 2.4), in_nickel("a60j"), drawn(f"(wear over volume)^.3 of {VALVES}")),
    ask(
        "roughness in nickel, cBN",
        "that ratio of alumina over that of cBN, which breaks away less",
        "usual; a60j and b126; 100 mm3/mm after the dress",
    ).within(at_least(1.05), lambda rig: in_nickel("a60j")(rig) / in_nickel("b126")(rig), drawn(VALVES)),
    ask("first touch", "what a touch of 1 nm takes off the Ra of an unground face").within(
        at_most(0.1), value(lambda grinder: 100.0 * (1.0 - grinder.trial(1e-6).Ra / grinder.Rs), Rig.fresh), unit="%"
    ),
    ask(
        "spark-out roughness on stiffness", "Ra after full spark-out, stiffness 200,000 over 10,000 N/mm", AFTER
    ).within(around(1.0, 0.1), Measurement(sparked_out, over("changes", STIFF_AND_SOFT), quotient, Rig.sharp)),
    ask("spark-out roughness on width", "Ra after full spark-out, 60 over 5 mm wide", AFTER).within(
        around(1.0, 0.1), Measurement(sparked_out, over("width", (60.0, 5.0), changes=NO_GROWTH), quotient, Rig.sharp)
    ),
    ask("spark-out gain, finest feed", GAIN, "usual; sharp; 1 um, 60 mm/s; 40 strokes, 40 spark-out").within(
        around(0.87, 0.07), value(spark_out_gain, sharp_then, **FEEDS[0])
    ),
    ask("spark-out gain, heavy feed", GAIN, "usual; sharp; 20 um, 333 mm/s; 40 strokes, 40 spark-out").within(
        around(0.40, 0.07), value(spark_out_gain, sharp_then, **FEEDS[-1])
    ),
    ask(
        "spark-out gain with feed",
        "the same with heavier and heavier feeds, largest step",
        "usual; sharp; 1 um at 60 mm/s, 2 at 100, 5 at 150, 10 at 200, 20 at 333",
    ).within(Band(0.0, 0.98), Measurement(spark_out_gain, FEEDS, largest_step, sharp_then)),
    ask("roughness on wheel speed", "exponent of Ra on the wheel speed", "usual; sharp; 20 to 40 m/s; stroke 5").within(
        Band(-0.7, -0.3),
        exponent_on("wheel_speed", (20.0, 25.0, 30.0, 35.0, 40.0), stroke("Rg"), sharp_then),
        own("it excludes the -.08 of flat_grinding_L8_dressing.csv, which is of deep and slow passes"),
    ),
    ask(
        "roughness scatter",
        "coefficient of variation of Ra from part to part within one setting, beside the gauge's noise",
        "a batch of a job with nothing said",
    ).within(
        Band(0.10, 0.25),
        lambda rig: roughness_scatter(),
        own("320 parts of 52100 ground with cBN scatter by 4 to 12 %, 1200 piston rings by more"),
    ),
)
