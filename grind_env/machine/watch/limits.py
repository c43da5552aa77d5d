"""What a program asks of the machine beyond what that makes: speeds and feeds. The run goes on as it asks."""

import math

from grind_env.control import CyclePlan, Line
from grind_env.control.numbers import MILLIMETRES_PER_INCH
from grind_env.machine.axes import AXES, cross_axis, plunge_axis
from grind_env.process.entries import Machine

SLACK = 1.0 + 1e-9
"""By which a speed that a limit allows may exceed it: inches and shares of a path are rounded."""


def beyond_table(
    feed: float, length: float, acceleration: float, machine: Machine, inch: bool, word: str
) -> str | None:
    """What to say of a stroke of some mm at `feed`, mm/min, that the table does not make; None if it does.

    Under G70 (`inch`) a number that is right in mm/min is taken to be meant so.
    """
    most, written = machine.maximum_table_speed, feed / float(MILLIMETRES_PER_INCH)
    if feed > most * SLACK:
        meant = written / float(MILLIMETRES_PER_INCH)
        unit = (
            f", or write {word}{meant:.1f} if {word}{written:g} is meant in mm/min" if inch and written <= most else ""
        )
        return f"{word}{feed:g} is more than the table of {machine} makes, {most:g} mm/min; lower {word}{unit}"
    reached = 60.0 * math.sqrt(acceleration * length)
    if feed > reached * SLACK:
        return (
            f"the table never comes to {word}{feed:g}: on {length:g} mm it gets no faster than {reached:.0f} mm/min at "
            f"{acceleration:g} mm/s2; set the reversal points farther apart, or lower {word}"
        )
    return None


def beyond_picks(plan: CyclePlan, machine: Machine) -> str | None:
    """What to say of a cycle whose picks are faster than the machine's; None if they are not."""
    if plan.plunge_axis is None:
        return None
    if max(plan.primary_pick, plan.secondary_pick) > 0.0 and plan.pick_feed > machine.maximum_plunge_feed * SLACK:
        return _faster(plan.pick_feed, plan.plunge_axis, machine, machine.maximum_plunge_feed)
    if plan.cross_axis is not None and plan.pick_feed > machine.maximum_cross_feed * SLACK:
        return _faster(plan.pick_feed, plan.cross_axis, machine, machine.maximum_cross_feed)
    return None


def beyond_feeds(move: Line, axis: int, machine: Machine) -> str | None:
    """What to say of a feed move that takes an axis along faster than the machine's; None if it does not."""
    length = math.dist(move.start, move.end)
    limits = {
        axis: machine.maximum_table_speed,
        plunge_axis(axis): machine.maximum_plunge_feed,
        cross_axis(axis): machine.maximum_cross_feed,
    }
    for along, most in limits.items():
        feed = move.feed * abs(move.end[along] - move.start[along]) / length if length > 0.0 else 0.0
        if feed > most * SLACK:
            return _faster(feed, along, machine, most)
    return None


def _faster(feed: float, axis: int, machine: Machine, most: float) -> str:
    return f"a feed of {feed:g} mm/min along {AXES[axis]} is more than {machine} makes, {most:g} mm/min; lower F"
