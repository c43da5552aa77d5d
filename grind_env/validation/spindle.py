"""Group 9: a spindle that is asked for more than it has slows down, and stalls."""

from typing import Any

from grind_env.validation.check import Band, Check, at_least, at_most
from grind_env.validation.rig import USUAL, Rig, grind_plate, stalled

AMPLE = 500_000.0
"""W; more than any stroke asks for."""
SHARE, STALLING = 1.0 / 1.2, 1.0 / 3.0
"""Power limits over what the stroke asks for."""


def strokes(rig: Rig, share: float) -> tuple[Any, Any, float]:
    """The stroke of an ample spindle, that of one with a share of its power, and the power that this one has, W."""
    wheel = rig.sharp(changes={"machine": {"power_limit": AMPLE, "idle_power": 0.0}})
    ample = rig.set_up_anew(wheel).grind(5)
    limit = share * ample.power
    weak = rig.set_up_anew(wheel, changes={"machine": {"power_limit": limit, "idle_power": 0.0}})
    return ample, weak.grind(5), limit


def ratio(rig: Rig, name: str, share: float = SHARE) -> float:
    """A field of the stroke of the weak spindle over that of the ample one."""
    ample, weak, _ = strokes(rig, share)
    return float(getattr(weak, name) / getattr(ample, name))


def power_used(rig: Rig) -> float:
    """Power of the weak spindle over what it has."""
    _, weak, limit = strokes(rig, SHARE)
    return float(weak.power) / limit


def stall(rig: Rig, share: float) -> float:
    """1 if the spindle with a share of the power stalls."""
    return stalled(strokes(rig, share)[1])


def stall_told(rig: Rig) -> float:
    """How many warnings of a run on a spindle of 300 W tell of a stall and name block and stroke."""
    return float(sum("stall" in line and "stroke" in line for line in grind_plate(rig, 300.0).warnings))


AT = f"{USUAL}; sharp; the spindle has 1/1.2 of the power that the stroke asks for"

CHECKS = (
    Check(
        name="power within the limit",
        group=9,
        what="power over what the spindle has",
        at=AT,
        band=Band(0.9, 1.0),
        measure=power_used,
    ),
    Check(
        name="wheel slows",
        group=9,
        what="wheel speed over that of an ample spindle",
        at=AT,
        band=Band(0.45, 0.95),
        measure=lambda rig: ratio(rig, "vs"),
    ),
    Check(
        name="chips thicken",
        group=9,
        what="equivalent chip thickness over that of an ample spindle",
        at=AT,
        band=at_least(1.05),
        measure=lambda rig: ratio(rig, "heq"),
    ),
    Check(
        name="grain force of a slow wheel",
        group=9,
        what="force per grain over that of an ample spindle",
        at=AT,
        band=at_least(1.02),
        measure=lambda rig: ratio(rig, "fg"),
    ),
    Check(
        name="roughness of a slow wheel",
        group=9,
        what="Ra over that of an ample spindle",
        at=AT,
        band=at_least(1.02),
        measure=lambda rig: ratio(rig, "Rg"),
    ),
    Check(
        name="no stall",
        group=9,
        what="stall, 0 or 1",
        at=AT,
        band=Band(0.0, 0.0),
        measure=lambda rig: stall(rig, SHARE),
    ),
    Check(
        name="stall",
        group=9,
        what="stall, 0 or 1",
        at=f"{USUAL}; sharp; the spindle has a third of the power that the stroke asks for",
        band=Band(1.0, 1.0),
        measure=lambda rig: stall(rig, STALLING),
    ),
    Check(
        name="stall is scrap",
        group=9,
        what="probability that the part is good",
        at="example plate_g82 by machine.grind, spindle of 300 W",
        band=at_most(0.01),
        measure=lambda rig: float(grind_plate(rig, 300.0).parts["survival"][0]),
    ),
    Check(
        name="stall costs minutes",
        group=9,
        what="time of the run beyond that on an ample spindle",
        at="example plate_g82 by machine.grind, spindle of 300 W",
        unit="s",
        band=at_least(60.0),
        measure=lambda rig: grind_plate(rig, 300.0).seconds - grind_plate(rig, AMPLE).seconds,
    ),
    Check(
        name="stall is told",
        group=9,
        what="warnings of the stall that name block and stroke",
        at="example plate_g82 by machine.grind, spindle of 300 W",
        band=at_least(1.0),
        measure=stall_told,
    ),
)
