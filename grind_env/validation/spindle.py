"""Group 9: a spindle that is asked for more than it has slows down, and stalls."""

from collections.abc import Callable
from functools import partial

from grind_env.process.state import StrokeResult
from grind_env.validation.check import Band, Question, at_least, at_most
from grind_env.validation.measures import quotient
from grind_env.validation.rig import Rig, grind_plate, stalled

AMPLE = 500_000.0
"""W; more than any stroke asks for."""
SHARE, STALLING = 1.0 / 1.2, 1.0 / 3.0
"""Power limits over what the stroke asks for."""

ask = partial(Question, 9)


def strokes(rig: Rig, share: float = SHARE) -> tuple[StrokeResult, StrokeResult]:
    """Return the stroke of an ample spindle, and that of one with a share of the power that it asks for."""
    wheel = rig.sharp(changes={"machine": {"power_limit": AMPLE, "idle_power": 0.0}})
    ample = rig.set_up_anew(wheel).grind(5)
    weak = rig.set_up_anew(wheel, changes={"machine": {"power_limit": share * ample.power, "idle_power": 0.0}})
    return ample, weak.grind(5)


def slowed(name: str) -> Callable[[Rig], float]:
    """Measure a field of the stroke of the weak spindle over that of the ample one."""
    return lambda rig: quotient([getattr(each, name) for each in reversed(strokes(rig))])


def power_used(rig: Rig) -> float:
    """Return the power of the weak spindle over what it has."""
    ample, weak = strokes(rig)
    return weak.power / (SHARE * ample.power)


SLOW = "usual; sharp; the spindle has 1/1.2 of the power that the stroke asks for"
THIRD = "usual; sharp; the spindle has a third of the power that the stroke asks for"
PLATE = "example plate_g82 by machine.grind, spindle of 300 W"

CHECKS = (
    ask("power within the limit", "power over what the spindle has", SLOW).within(Band(0.9, 1.0), power_used),
    ask("wheel slows", "wheel speed over that of an ample spindle", SLOW).within(Band(0.45, 0.95), slowed("vs")),
    ask("chips thicken", "equivalent chip thickness over that of an ample spindle", SLOW).within(
        at_least(1.05), slowed("heq")
    ),
    ask("grain force of a slow wheel", "force per grain over that of an ample spindle", SLOW).within(
        at_least(1.02), slowed("fg")
    ),
    ask("roughness of a slow wheel", "Ra over that of an ample spindle", SLOW).within(at_least(1.02), slowed("Rg")),
    ask("no stall", "stall, 0 or 1", SLOW).within(Band(0.0, 0.0), lambda rig: stalled(strokes(rig)[1])),
    ask("stall", "stall, 0 or 1", THIRD).within(Band(1.0, 1.0), lambda rig: stalled(strokes(rig, STALLING)[1])),
    ask("stall is scrap", "probability that the part is good", PLATE).within(
        at_most(0.01), lambda rig: float(grind_plate(rig, 300.0).parts["survival"][0])
    ),
    ask("stall costs minutes", "time of the run beyond that on an ample spindle", PLATE).within(
        at_least(60.0), lambda rig: grind_plate(rig, 300.0).seconds - grind_plate(rig, AMPLE).seconds, unit="s"
    ),
    ask("stall is told", "warnings of the stall that name block and stroke", PLATE).within(
        at_least(1.0),
        lambda rig: sum("stall" in line and "stroke" in line for line in grind_plate(rig, 300.0).warnings),
    ),
)
