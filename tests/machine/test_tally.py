"""Tallies agree with lists of all strokes and dresses."""

import itertools
import math
from statistics import fmean
from typing import Any, NamedTuple

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grind_env.machine.loops import stroke_totals
from grind_env.process.stroke_types import StrokeResult

EMPTY = StrokeResult(*[0.0] * len(StrokeResult._fields))


class Counted(NamedTuple):
    """Stroke or dress as a tally counts it."""

    power: float
    T: float
    burn_ratio: float
    worn: float
    deeper: float
    plunge: bool
    full: bool
    finishing: bool
    dress: bool


positive = st.floats(0.0, 1e5)
counted = st.builds(
    Counted,
    positive,
    positive,
    positive,
    positive,
    st.floats(-1.0, 1.0),
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.just(False),
)
dressing = counted.map(lambda each: each._replace(dress=True))


def window(tally: Any) -> list[float]:
    """Return the powers of the latest full plunges, newest first."""
    return [float(tally[stroke_totals.Tally._fields.index(f"power_{number}")]) for number in range(1, 7)]


@example(events=[Counted(float(power), 1.0, 1.0, 1.0, 1.0, True, True, True, False) for power in range(9)])
@given(events=st.lists(st.one_of(counted, counted, counted, dressing), max_size=40))
def test_a_tally_agrees_with_lists_of_its_events(events: list[Counted]) -> None:
    tally = stroke_totals.NOTHING
    for each in events:
        if each.dress:
            tally = stroke_totals.count_dress(tally, each.power, each.worn)
        else:
            stroke = EMPTY._replace(
                load=each.power, mean_load=each.power, T=each.T, burn_ratio=each.burn_ratio, worn=each.worn
            )
            tally = stroke_totals.count_stroke(
                tally, stroke, 2.0, each.deeper, each.plunge, each.full, each.finishing, 600.0
            )
    strokes, dresses = [e for e in events if not e.dress], [e for e in events if e.dress]
    since = list(itertools.takewhile(lambda each: not each.dress, events[::-1]))[::-1]
    first, last = [e.power for e in strokes if e.full][:6], [e.power for e in since if e.full][-6:]
    plunges = [e for e in strokes if e.plunge]
    assert (tally.strokes, tally.dresses) == (len(strokes), len(dresses))
    assert (tally.first_count, tally.last_count) == (len(first), len(last))
    assert window(tally) == (last[::-1] + [0.0] * 6)[:6]
    assert stroke_totals.last_power(tally) == pytest.approx(math.fsum(last))
    assert stroke_totals.mean_last_power(tally) == pytest.approx(fmean(last) if last else 0.0)
    assert stroke_totals.mean_first_power(tally) == pytest.approx(fmean(first) if first else 0.0)
    assert tally.deepened == pytest.approx(math.fsum(max(e.deeper, 0.0) for e in since))
    assert tally.peak_load == max((e.power for e in strokes), default=0.0)
    assert tally.plunge_rise == max((e.T for e in plunges), default=0.0)
    assert tally.finish_rise == max((e.T for e in plunges if e.finishing), default=0.0)
    assert tally.burn_ratio == max((e.burn_ratio for e in plunges), default=0.0)
    assert tally.worn == pytest.approx(math.fsum(e.worn for e in strokes))
    assert tally.dressed_off == pytest.approx(math.fsum(e.worn for e in dresses))
    assert tally.seconds == pytest.approx(2.0 * len(strokes) + math.fsum(e.power for e in dresses))
