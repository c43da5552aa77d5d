"""The first words of a program by rules of thumb, from which a search for better ones begins, and how far it may go.

The rules are recalled, and were not looked up, from Malkin & Guo, Grinding Technology (2008) [M]; Marinescu, Rowe,
Dimitrov & Ohmori, Tribology of Abrasive Machining Processes (2012) [T]; Rowe, Principles of Modern Grinding Technology
(2014) [R]. Seen: wheel speeds of 25 to 45 m/s and depths of cut of 5 to 50 um (unseel.com/engineering/surface-grinding)
and that a higher overlap ratio of the dress leaves a smoother part and higher forces (hon1.ru/?p=205). [C] is chosen
here.
"""

import math
from dataclasses import dataclass
from decimal import Decimal

from grind_env.machine.job import Job
from grind_env.process.entries import ALUMINA
from grind_env.process.equations import dress_width

WHEEL_SPEED = 30.0
"""m/s: 20 to 35 of vitrified wheels [M]; as of the examples. CBN is faster where wheel and guard allow it."""
SPEED_RATIO, FINISH_RATIO = 120.0, 200.0
"""Wheel speed over table speed of roughing: 60 to 120 where the table reciprocates [T], of which the slow end; and of
finishing, for a slower table leaves a smoother face [R]."""
GRAIN_SHARE = 0.04
"""Pick of roughing over the grain size: 10 um of grit 60. 10 to 30 um are usual, half of it in finishing [M]."""
LEAST_PICK = 0.002
"""mm; finer ones plough more than they cut [M]."""
CROSS_SHARE = 0.5
"""Pick across over the width of the wheel, where the part is wider: each place is then passed over twice."""
SPARK_OUTS, MOST_SPARK_OUTS = 6, 10
"""Passes: the machine springs back by less from each to the next, and after 3 or 4 by nothing that counts [M]. Fewer
than 6 are not searched, for one that gives more than the model needs them [C]."""
FINISH_STOCK, FINISH_SHARE = 0.03, 1.0 / 3.0
"""mm, and share of the stock at most, that finishing takes off: more than roughing leaves too high or too rough [C]."""
OVERLAPS = ((0.8, 3.0), (0.4, 4.0), (0.0, 6.0))
"""Overlap ratio of the dress from a limit of Ra on, um: 2 to 3 for roughing, 3 to 4, 6 to 8 for a fine face [R]."""
LEAST_OVERLAP, MOST_OVERLAP = 2.0, 8.0
"""Below, the diamond cuts a thread; beyond, the wheel begins to glaze (`process.equations.dressing`)."""
DRESS_DEPTH, DRESS_DEPTH_CBN = 0.020, 0.003
"""mm a pass, and of CBN a touch: it wears little and costs much [R]. From half to twice of it is searched [C]."""
PASSES = 2
MOST_DRESSES = 2
OVERTRAVEL = 30.0
"""mm at each end, on which the table comes to its speed before the wheel meets the part."""
LEAST_STOCK = 0.005
"""mm; less leaves nothing to be parted into roughing and finishing."""

MICRON, FEED_STEP = 3, 200.0
"""Decimals of lengths, and of what E is a multiple, mm/min."""
LEAD_STEP = 0.005
"""mm a revolution, between leads that are tried."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Words:
    """What a program for a part says.

    Attributes:
        rough_feed: E of roughing, mm/min.
        rough_pick: J of roughing, mm.
        finish_feed: E of finishing, mm/min.
        finish_pick: J of finishing, mm.
        spark_outs: strokes without infeed, or traverses.
        dresses: executions of the dress program in roughing.
        dress_feed: of the diamond across the wheel, mm/min.
        dress_depth: of a pass of it, mm.
    """

    rough_feed: float
    rough_pick: float
    finish_feed: float
    finish_pick: float
    spark_outs: float
    dresses: float
    dress_feed: float
    dress_depth: float


def first_words(job: Job) -> Words:
    """The words by the rules, for the wheel, the machine and the limit of Ra of a job."""
    asked = job.part.roughness_limit
    pick = _pick(job)
    overlap = next(overlap for least, overlap in OVERLAPS if asked >= least)
    return Words(
        rough_feed=_feed(job, SPEED_RATIO),
        rough_pick=pick,
        finish_feed=_feed(job, FINISH_RATIO),
        finish_pick=max(round(0.5 * pick, MICRON), LEAST_PICK),
        spark_outs=spark_outs(job, SPARK_OUTS),
        dresses=1,
        dress_feed=round(spindle_speed(job) * lead_of(job, overlap)),
        dress_depth=dress_depth(job),
    )


def bounds_of(job: Job) -> dict[str, tuple[Decimal, Decimal]]:
    """How far the search may go from there, by word: as of `Wishes`; of those left out as far as it goes by itself."""
    depth, pick = dress_depth(job), _pick(job)
    found: dict[str, tuple[float, float]] = {
        "E": (min(3000.0, fastest(job)), fastest(job)),
        "D": (1, MOST_DRESSES),
        "J": (LEAST_PICK, 2.0 * pick),
        "L": (spark_outs(job, SPARK_OUTS), spark_outs(job, MOST_SPARK_OUTS)),
        "lead": (lead_of(job, MOST_OVERLAP), lead_of(job, LEAST_OVERLAP)),
        "depth": (0.5 * depth, 2.0 * depth),
    }
    return {name: (Decimal(f"{low:.6g}"), Decimal(f"{high:.6g}")) for name, (low, high) in found.items()}


def fastest(job: Job) -> float:
    """E up to which the table has its speed where the wheel meets the part, mm/min, if the machine makes as much."""
    machine = job.setup.machine
    reached = 60.0 * math.sqrt(2.0 * machine.acceleration * OVERTRAVEL)
    return max(_rounded(min(reached, machine.maximum_table_speed)), FEED_STEP)


def lead_of(job: Job, overlap: float) -> float:
    """Lead of a dress with an overlap ratio, mm a revolution, with a new diamond at the depth of the rule."""
    return float(dress_width(dress_depth(job), job.setup.dresser.tip_radius, 0.0)) / overlap


def dress_depth(job: Job) -> float:
    """Depth of a pass of the diamond by the rule, mm."""
    return DRESS_DEPTH if job.setup.wheel.abrasive == ALUMINA else DRESS_DEPTH_CBN


def finish_stock(job: Job) -> float:
    """What finishing takes off, mm."""
    return round(min(FINISH_STOCK, FINISH_SHARE * job.part.stock), MICRON)


def traverses(job: Job) -> bool:
    """Whether the part is wider than the wheel, which then has to go across."""
    return job.part.width > job.setup.wheel.width


def spark_outs(job: Job, passes: int) -> float:
    """L for so many passes over each place of the part: strokes, or traverses."""
    return math.ceil(CROSS_SHARE * passes) if traverses(job) else passes


def spindle_speed(job: Job) -> int:
    """Revolutions of the new wheel a minute at its speed."""
    return round(60_000.0 * job.setup.wheel_speed / (math.pi * job.setup.wheel.diameter))


def _pick(job: Job) -> float:
    return max(round(GRAIN_SHARE * job.setup.wheel.grit_size, MICRON), LEAST_PICK)


def _feed(job: Job, ratio: float) -> float:
    return max(min(_rounded(60_000.0 * job.setup.wheel_speed / ratio), fastest(job)), FEED_STEP)


def _rounded(feed: float) -> float:
    return math.floor(feed / FEED_STEP) * FEED_STEP
