"""The text of a program for a part: roughing and finishing, a gauging stop between them, and the dress."""

import re
import textwrap
from collections.abc import Mapping, Sequence
from math import ceil

from grind_env.machine.job import Job
from grind_env.shop.start.rules import CROSS_SHARE, OVERTRAVEL, PASSES, Words, finish_stock, spindle_speed, traverses

ROUGH, FINISH, DRESS = "N50", "N70", "O9100"
"""Where words stand, and before which remarks do."""
CROSS_FEED = 1500
"""mm/min, of picks across the part, as of the example `rail_g83`."""
WIDEST = 96
"""Characters of a comment."""

TEXT = """\
%
O2001 ({what})
(X RECIPROCATES, Y PLUNGES TOWARDS MINUS, Z CROSSES)
(Y0 IS THE TOUCHED-OFF SURFACE, X0 AND Z0 THE NEAR CORNER)
(PROPOSED BY GRIND INIT: WATCH THE FIRST PART)
N10 G71 G94 G90 G19 S{rpm} M03
N20 G00 Y2. M08
N30 G00 X-{overtravel} Z{begin}
N40 G01 Y0 F500.
(ROUGH: {rough_picks} PICKS)
{N50}N50 {cycle} X{far} I-{overtravel} Y-{rough} J-{rough_pick} {across}E{rough_feed:.0f}. P9100 D{dresses:.0f}
N52 G80
N54 G00 Y2.
N56 G00 X-{overtravel} Z{begin}
N60 M01                     (GAUGE: WHEEL WEAR IS COMPENSATED)
N62 G01 Y-{rough} F500.
(FINISH: {finish_picks} PICKS, {without})
{N70}N70 {cycle} X{far} I-{overtravel} Y-{stock} J-{finish_pick} L{spark_outs:.0f} {across}E{finish_feed:.0f}.
N80 G80
N90 G00 Y20. M09 M05
N100 M30

O9100 (DRESS: {passes} PASSES AT {rpm} RPM)
{O9100}N1 G71 G90 G94
N2 G00 Y20.                 (OFF THE PART)
N3 G00 X-120. Z-{beside}         (BESIDE THE DIAMOND, WHICH STANDS ON THE TABLE)
N4 G00 Y10.                 (WHEEL FACE AT THE DIAMOND POINT)
N5 G91 G01 Y-{dress_depth} F60.
N6 Z{over} F{dress_feed:.0f}.
N7 Y-{dress_depth} F60.
N8 Z-{over} F{dress_feed:.0f}.
N9 G90 G00 Y20.
N10 M99
%
"""
"""For the diamond of the example's job: X-120, Y10, Z-10."""


def program_text(job: Job, words: Words, remarks: Mapping[str, Sequence[str]] = {}) -> str:
    """The text of a program.

    Args:
        job: what is ground on which machine.
        words: what it says.
        remarks: what comments say, by the block or program before which they stand.
    """
    part, wheel = job.part, job.setup.wheel
    finish, wide, across = finish_stock(job), traverses(job), part.width - wheel.width
    what = f"{part.length:g} x {part.width:g} mm, {part.material.name}, wheel {wheel.name}, stock {part.stock:g} mm"
    cross = f"Z{_number(across)} K{_number(CROSS_SHARE * wheel.width)} F{CROSS_FEED}. "
    return TEXT.format(
        what=_comment(what),
        rpm=spindle_speed(job),
        begin="0" if wide else _number(0.5 * across),
        overtravel=_number(OVERTRAVEL),
        cycle="G83" if wide else "G82",
        far=_number(part.length + OVERTRAVEL),
        across=cross if wide else "F60. ",
        rough=_number(part.stock - finish),
        stock=_number(part.stock),
        rough_pick=_number(words.rough_pick),
        finish_pick=_number(words.finish_pick),
        rough_picks=ceil(round((part.stock - finish) / words.rough_pick, 6)),
        finish_picks=ceil(round(finish / words.finish_pick, 6)),
        rough_feed=words.rough_feed,
        finish_feed=words.finish_feed,
        spark_outs=words.spark_outs,
        without="THEN TRAVERSES" if wide else "THEN SPARK-OUT",
        dresses=words.dresses,
        passes=PASSES,
        dress_depth=_number(words.dress_depth),
        dress_feed=words.dress_feed,
        beside=_number(wheel.width + 15.0),
        over=_number(wheel.width + 10.0),
        **{place: "".join(map(_lines, remarks.get(place, ()))) for place in (ROUGH, FINISH, DRESS)},
    )


def _lines(remark: str) -> str:
    return "".join(f"({line})\n" for line in textwrap.wrap(_comment(remark), WIDEST))


def _comment(text: str) -> str:
    """A text as a comment of a program may hold it."""
    said = text.upper().replace("%", "PCT").replace("$", "USD").replace("_", " ")
    return re.sub(r"[^A-Z0-9 ,.:=+*/-]", " ", said)


def _number(value: float) -> str:
    """A length as the program writes it, mm to the micron."""
    text = f"{value:.3f}".rstrip("0")
    return "0" if float(text) == 0.0 else text.replace("0.", ".", 1) if abs(value) < 1.0 else text
