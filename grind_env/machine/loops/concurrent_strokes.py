"""Strokes beside motions of the program: under G81, and after any cycle has finished.

The table reciprocates on its own while the program moves the wheel. A stroke counts at the position that the wheel has
when the table passes the middle of the stroke. A leg is the motions of the program between two rests of the table; it
ends with dresses at a reversal point, or with the table's last stroke.
"""

import math
from typing import Any, NamedTuple

from grind_env.control.cycle_formulas import INSTANT
from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.loops.compiled_cycles import CycleKernel
from grind_env.machine.loops.compiled_motion import travelled
from grind_env.machine.loops.cycle import Stroking

#: codes of what follows a motion: the next motion of its leg, a dress and the next leg, or the end
GOES_ON, DRESSES, ENDS = 0.0, 1.0, 2.0

FULL = 0.9  #: least ratio of a full plunge to the deepest plunge beside motions; in the other cycles picks decide


class Feeding(NamedTuple):
    """Strokes beside motions: their times, and the state from which they continue."""

    pre_dress: float  #: 1 for a dress before the first stroke, else 0
    first_travel: float  #: time of the first stroke of the cycle without the dwell at its end, s
    travel: float  #: time of every other stroke without the dwell at its end, s
    dwell: float  #: dwell at a reversal point, s
    acceleration: float  #: acceleration of the motions, mm/s2
    made: float  #: number of strokes that the cycle has made before
    #: 1 if the table does not start at its secondary point, and so makes at least one stroke; else 0
    starts_elsewhere: float
    #: 1 if the table goes on to its secondary point, where the next cycle takes over (PD-23), else 0
    to_secondary: float
    motion: float  #: row of the first motion
    gauged_at: float  #: time in its leg at which the operator gauges the part, s; infinite without gauging


class FeedMotion(NamedTuple):
    """A motion of the program, or a dwell. Times are s since the leg began."""

    begin: float
    end: float
    depth: float  #: depth of the wheel at its begin, mm, from the zero of the program
    way: float  #: gain in depth from begin to end, mm
    cross: float  #: cross coordinate of the wheel's edge on the minus side at its begin, mm
    cross_way: float  #: change of `cross` from begin to end, mm
    path: float  #: length of the path, mm; 0 for a dwell
    rate: float  #: speed along the path, mm/s
    last_begin: float  #: time in its leg from which on no stroke begins
    leg_seconds: float  #: duration of its leg without the dresses after the leg
    after: float  #: `GOES_ON`, `DRESSES` or `ENDS`


class FeedProgress(NamedTuple):
    """Progress of the strokes."""

    reversal: float  #: number of strokes that the cycle has made
    dresses: float
    begins: float  #: time in the leg at which the coming stroke begins, s
    middle: float  #: time in the leg at which the table passes the middle of the coming stroke, s
    ends: float  #: time in the leg at which the coming stroke ends, s
    row: float  #: index of the motion under way at `middle`
    over: float  #: 1 when all strokes are made, else 0
    begin: float  #: begin of that motion, s; this field and the next eight are copies of its fields
    end: float
    depth: float
    way: float
    cross: float
    cross_way: float
    path: float
    rate: float
    last_begin: float
    acceleration: float
    gauged_at: float  #: time in the leg at which the operator gauges the part, s; infinite when it is past
    gauged: float  #: 1 if the operator gauges the part before the coming stroke ends, else 0


read_motion, write_motion = column_reader(FeedMotion), column_writer(FeedMotion)
after_stroke = replacer(FeedProgress, "reversal", "dresses", "begins", "middle", "ends", "gauged")
at_stroke = replacer(FeedProgress, "dresses", "begins", "middle", "ends", "row", "over", "gauged_at", "gauged")
setting_out = replacer(FeedProgress, "reversal", "dresses", "row", "last_begin", "acceleration", "gauged_at")
in_motion = replacer(FeedProgress, *(name for name in FeedMotion._fields if name in FeedProgress._fields))
AT_REST = FeedProgress(*[0.0] * len(FeedProgress._fields))


@inlined
def begin(cycle: Feeding) -> FeedProgress:
    """Return the progress before the first stroke, which has still to be found."""
    first = cycle.made, cycle.pre_dress, cycle.motion, -INSTANT, cycle.acceleration, cycle.gauged_at
    return setting_out(AT_REST, first)


@inlined
def after_reversal(cycle: Feeding, progress: FeedProgress) -> FeedProgress:
    """Return the progress after the next stroke."""
    begins = progress.ends
    ends = begins + (cycle.travel + cycle.dwell)
    return after_stroke(progress, (progress.reversal + 1.0, 0.0, begins, begins + 0.5 * cycle.travel, ends, 0.0))


@inlined
def finished(cycle: Feeding, progress: FeedProgress) -> bool:
    """Return whether the table has come to its last reversal point."""
    return progress.over > 0.0


@inlined
def lost(progress: FeedProgress) -> bool:
    """Return whether the coming stroke lies in another motion than the one before."""
    found = (progress.middle <= progress.end) & (progress.begins < progress.last_begin)
    return (not found) | (progress.ends > progress.gauged_at)


@inlined
def find(cycle: Feeding, progress: FeedProgress, motions: Any) -> tuple[FeedProgress, float]:
    """Return the progress with the motion under way in the coming stroke and the dresses due, and their wait, s."""
    begins, dresses, waited, over = progress.begins, progress.dresses, 0.0, 0.0
    row = int(progress.row)
    travel = cycle.travel if progress.reversal > 0.0 else cycle.first_travel
    wait = 0.5 * travel
    motion = read_motion(motions, row)
    while True:
        if begins >= motion.last_begin:
            while motion.after == GOES_ON:
                row += 1
                motion = read_motion(motions, row)
            if motion.after == ENDS:
                under_way = progress.reversal == 0.0 and cycle.starts_elsewhere > 0.0
                at_primary = 0.5 * progress.reversal > float(int(0.5 * progress.reversal))
                over = 0.0 if under_way or (cycle.to_secondary > 0.0 and at_primary) else 1.0
                break
            dresses += 1.0
            waited += max(motion.leg_seconds - begins, 0.0)
            begins = 0.0
        elif begins + wait <= motion.end or motion.after != GOES_ON:
            break
        row += 1
        motion = read_motion(motions, row)
    # a gauging of the standing table, or before the next reversal point, takes effect there
    ends = begins + (travel + cycle.dwell)
    gauged = 1.0 if over > 0.0 or ends > progress.gauged_at else 0.0
    gauged = gauged if progress.gauged_at < math.inf else 0.0
    gauged_at = math.inf if gauged > 0.0 else progress.gauged_at
    found = at_stroke(progress, (dresses, begins, begins + wait, ends, float(row), over, gauged_at, gauged))
    path = motion.begin, motion.end, motion.depth, motion.way, motion.cross, motion.cross_way, motion.path, motion.rate
    found = in_motion(found, (*path, motion.last_begin))
    return found, waited


@inlined
def gauged(progress: FeedProgress) -> bool:
    """Return whether the operator gauges the part before the coming stroke ends."""
    return progress.gauged > 0.0


@inlined
def share(progress: FeedProgress) -> float:
    """Return the share of the motion that is covered when the table passes the middle of the coming stroke."""
    path = progress.path if progress.path > 0.0 else 1.0
    done = travelled(progress.middle - progress.begin, path, progress.rate, progress.acceleration)
    return done / path if progress.path > 0.0 else 1.0


@inlined
def depth(stroking: Stroking, cycle: Feeding, progress: FeedProgress) -> float:
    """Return the depth of the coming stroke, mm."""
    return (progress.depth + share(progress) * progress.way) + stroking.surface


@inlined
def edge(stroking: Stroking, progress: FeedProgress) -> float:
    """Return the cross coordinate of the wheel's edge in the coming stroke, mm."""
    return progress.cross + share(progress) * progress.cross_way


FEED = CycleKernel(
    cycle=Feeding,
    progress=FeedProgress,
    begin=begin,
    after_reversal=after_reversal,
    finished=finished,
    depth=depth,
    edge=edge,
    lost=lost,
    find=find,
    gauged=gauged,
)


@inlined
def deepest_pick(stroking: Stroking, cycle: Feeding, reached: float, motions: Any) -> tuple[float, float]:
    """Return the largest step in depth from stroke to stroke and the depth reached, mm; nothing is ground.

    Args:
        stroking: numbers of the strokes.
        cycle: times of the strokes.
        reached: depth of the deepest stroke before, mm.
        motions: table of the motions beside them.
    """
    most = 0.0
    progress, _ = find(cycle, begin(cycle), motions)
    while not finished(cycle, progress):
        Z = depth(stroking, cycle, progress)
        most, reached = max(most, Z - reached), max(reached, Z)
        progress, _ = find(cycle, after_reversal(cycle, progress), motions)
    return most, reached
