"""A tally holds what lists of all strokes and dresses would tell."""

import itertools
import math
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.machine.loops.batch import NO_MOTIONS
from grind_env.machine.loops.cycle import PartState, Stroking
from grind_env.machine.loops.tally import (
    NOTHING,
    Tally,
    count_dress,
    count_stroke,
    last_power,
    mean_first_power,
    mean_last_power,
)
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import StrokeResult
from tests.batches import CYCLE, PARAMETERS, PART, PLUNGES, WHEEL, as_table, cold, grind_cycles
from tests.examples import examples
from tests.machine.harness import DRESS_NUMBERS, HEAD, STROKE, job, run, start_wheel

MICRON = 0.001
NEAR = 1e-9
"""How near a run of the program has to come to its cycle."""
P = job().parameters
WHEEL_AT_START = start_wheel(P)
EMPTY = StrokeResult(*[0.0] * len(StrokeResult._fields))


class Counted(NamedTuple):
    """A stroke, or a dress, as a tally is told of it."""

    power: float
    T: float
    Br: float
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
    """Powers of the latest full plunges, newest first."""
    return [float(tally[Tally._fields.index(f"power_{number}")]) for number in range(1, 7)]


def newest_first(powers: list[float]) -> list[float]:
    """What that has to be."""
    return (powers[::-1] + [0.0] * 6)[:6]


@given(events=st.lists(st.one_of(counted, counted, counted, dressing), max_size=40))
def test_a_tally_is_what_lists_of_its_events_tell(events: list[Counted]) -> None:
    tally = NOTHING
    for each in events:
        if each.dress:
            tally = count_dress(tally, each.power, each.worn)
        else:
            stroke = EMPTY._replace(load=each.power, T=each.T, Br=each.Br, worn=each.worn)
            tally = count_stroke(tally, stroke, 2.0, each.deeper, each.plunge, each.full, each.finishing, 600.0)
    strokes, dresses = [e for e in events if not e.dress], [e for e in events if e.dress]
    since = list(itertools.takewhile(lambda each: not each.dress, events[::-1]))[::-1]
    first, last = [e.power for e in strokes if e.full][:6], [e.power for e in since if e.full][-6:]
    plunges = [e for e in strokes if e.plunge]
    assert (tally.strokes, tally.dresses) == (len(strokes), len(dresses))
    assert (tally.first_count, tally.last_count) == (len(first), len(last))
    assert window(tally) == newest_first(last)
    assert last_power(tally) == pytest.approx(math.fsum(last))
    assert mean_last_power(tally) == pytest.approx(fmean(last) if last else 0.0)
    assert mean_first_power(tally) == pytest.approx(fmean(first) if first else 0.0)
    assert tally.deepened == pytest.approx(math.fsum(max(e.deeper, 0.0) for e in since))
    assert tally.peak_load == max((e.power for e in strokes), default=0.0)
    assert tally.plunge_rise == max((e.T for e in plunges), default=0.0)
    assert tally.finish_rise == max((e.T for e in plunges if e.finishing), default=0.0)
    assert tally.burn_ratio == max((e.Br for e in plunges), default=0.0)
    assert tally.worn == pytest.approx(math.fsum(e.worn for e in strokes))
    assert tally.dressed_off == pytest.approx(math.fsum(e.worn for e in dresses))
    assert tally.seconds == pytest.approx(2.0 * len(strokes) + math.fsum(e.power for e in dresses))


class Plunge(NamedTuple):
    """A G82 block; lengths in whole um."""

    depth: int
    J: int
    Q: int
    at_depth: int
    D: int
    pre_dress: bool

    @property
    def text(self) -> str:
        code, picks = "G82.1" if self.pre_dress else "G82", f"J-{self.J / 1000:.3f} Q-{self.Q / 1000:.3f}"
        last = f"L{self.at_depth - 1} F600. E12000. P9100 D{self.D}"
        return f"{HEAD}{code} X230. I-30. Y-{self.depth / 1000:.3f} {picks} {last}\nM30\n"

    def cycle(self, dress_seconds: float) -> tuple[float, ...]:
        stroking = Stroking(
            speed=200.0,
            first_seconds=STROKE,
            stroke_seconds=STROKE,
            set_out=STROKE,
            start=0.0,
            surface=0.0,
            bottom=self.depth * MICRON,
            full_plunge=max(self.J, self.Q) * MICRON - DEPTH_TOLERANCE,
            finish=self.depth * MICRON,
            width=20.0,
            length=200.0,
            dress_seconds=dress_seconds,
            cross_start=0.0,
            cross_end=0.0,
            **DRESS_NUMBERS,
        )
        rules = PlungeCycle(
            depth=self.depth * MICRON,
            primary_pick=self.J * MICRON,
            secondary_pick=self.Q * MICRON,
            at_depth=float(self.at_depth),
            executions=float(self.D),
            pre_dress=float(self.pre_dress),
        )
        return *stroking, *rules

    def strokes_and_dresses(self) -> tuple[np.ndarray, list[int]]:
        """The depth of every stroke, and the strokes made before each dress."""
        h, depths, dresses = 0, [], [0] * self.pre_dress
        due = 0
        while h < self.depth:
            depths.append(h)
            h = min(self.depth, h + (self.J if len(depths) % 2 else self.Q))
            now = min(self.D, h * (self.D + 1) // self.depth)
            dresses += [len(depths)] * (now - due)
            due = now
        return np.array([*depths, *[self.depth] * self.at_depth]), dresses


def tables(plunge: Plunge, dress_seconds: float = 30.0) -> tuple[Any, ...]:
    """The arguments of `grind_cycles`."""
    return (
        np.array([plunge.cycle(dress_seconds)], CYCLE),
        np.array([tuple(P)], PARAMETERS),
        np.array([cold(WHEEL_AT_START)], WHEEL),
        np.array([tuple(PartState(0.0, 0.0, INITIAL_ROUGHNESS))], PART),
    )


PLUNGE_CASES = st.builds(
    Plunge,
    depth=st.integers(0, 150),
    J=st.integers(2, 25),
    Q=st.integers(0, 25),
    at_depth=st.integers(1, 5),
    D=st.integers(0, 3),
    pre_dress=st.booleans(),
)
EVERY_SECOND = Plunge(depth=120, J=10, Q=2, at_depth=2, D=0, pre_dress=False)
"""Ten full plunges, each followed by one that is not."""


@examples(100)
@example(plunge=EVERY_SECOND)
@example(plunge=EVERY_SECOND._replace(J=2, Q=10))
@example(plunge=EVERY_SECOND._replace(D=1))
@given(plunge=PLUNGE_CASES)
def test_the_tally_of_a_cycle_is_what_the_strokes_of_its_program_tell(plunge: Plunge) -> None:
    depths, dresses = plunge.strokes_and_dresses()
    record = run(plunge.text, job())
    log, dress_seconds = record.strokes, float(record.dresses["seconds"][0]) if dresses else 0.0
    (tally,) = grind_cycles(*tables(plunge, dress_seconds))
    gain = np.diff(np.maximum.accumulate([0, *depths]))
    deeper, full = gain > 0, gain >= max(plunge.J, plunge.Q)
    finishing = deeper & (plunge.depth - np.array(depths) <= 50)
    since = np.arange(len(depths)) >= (dresses[-1] if dresses else 0)
    assert (tally["strokes"], tally["dresses"]) == (len(depths), len(dresses)) == (log.size, record.dresses.size)
    assert window(tally) == pytest.approx(newest_first(log["load"][full & since].tolist()), rel=NEAR)
    assert tally["last_count"] == min((full & since).sum(), 6)
    first = log["load"][full][:6]
    assert tally["first_count"] == len(first)
    assert tally["first_power"] == pytest.approx(math.fsum(first), rel=NEAR)
    assert tally["peak_load"] == pytest.approx(log["load"].max(), rel=NEAR)
    assert tally["plunge_rise"] == pytest.approx(log["T"][deeper].max(initial=0.0), rel=NEAR)
    assert tally["finish_rise"] == pytest.approx(log["T"][finishing].max(initial=0.0), rel=NEAR)
    assert tally["burn_ratio"] == pytest.approx(log["Br"][deeper].max(initial=0.0), rel=NEAR)
    assert tally["worn"] == pytest.approx(math.fsum(log["worn"]), rel=NEAR)
    taken = DRESS_NUMBERS["dress_passes"] * DRESS_NUMBERS["dress_depth"]
    before = [300.0 - 2.0 * (math.fsum(log["dw"][:n]) + k * taken) for k, n in enumerate(dresses)]
    assert tally["dressed_off"] == pytest.approx(math.fsum(math.pi * ds * taken * P.bs for ds in before), rel=NEAR)
    assert tally["seconds"] == pytest.approx(len(depths) * STROKE + len(dresses) * dress_seconds, rel=NEAR)


def test_a_tally_goes_on_from_cycle_to_cycle() -> None:
    long, short = EVERY_SECOND, EVERY_SECOND._replace(depth=30, at_depth=0)
    cycles, parameters, wheels, parts = tables(long)
    before = grind_cycles(cycles, parameters, wheels, parts)
    found = []
    for tallies in (np.zeros_like(before), before.copy()):
        cycles, *_, parts = tables(short)
        numbers = [as_table(each) for each in (cycles, parameters, wheels.copy(), parts, tallies)]
        PLUNGES.lanes(*numbers, NO_MOTIONS, np.arange(1), 0, 1)
        found.append(tallies[0])
    first, (alone, after) = before[0], found
    assert (alone["first_count"], alone["last_count"], after["last_count"]) == (2.0, 2.0, 6.0)
    assert window(after) == [*window(alone)[:2], *window(first)[:4]]
    assert after["first_power"] == first["first_power"]
    for name in ("seconds", "strokes", "worn"):
        assert after[name] == pytest.approx(first[name] + alone[name], rel=1e-12), name
    for name in ("peak_load", "plunge_rise", "finish_rise", "burn_ratio"):
        assert after[name] == max(first[name], alone[name]), name
