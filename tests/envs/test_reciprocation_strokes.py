import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Line, Source, execute, read
from grind_env.envs.programmed_infeed import Infeed, Segment, segments, write_motions
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.loops.concurrent_strokes import FeedMotion
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.record import GrindingRecord
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.process_interface import PROCESS
from tests.batches import FEEDS, PART, TALLY, WHEEL, as_table, feeding_row
from tests.machine.harness import DRESS, DRESS_NUMBERS, job, start_wheel

ACCELERATION, DWELL = 1000.0, 0.15


@dataclasses.dataclass(frozen=True)
class Case:
    """A G81 block with an infeed: depths in um, E and F in mm/min."""

    depth: int
    infeed: float
    E: int
    D: int
    sparkout: int

    @property
    def infeed_block(self) -> Infeed:
        speed = self.E / 60.0
        return Infeed(
            travel=260.0 / speed + speed / ACCELERATION,
            dwell=DWELL,
            rate=self.infeed / 60.0,
            acceleration=ACCELERATION,
            target=self.depth / 1000.0,
            requests=float(self.D),
            sparkout=float(self.sparkout),
        )

    @property
    def segments(self) -> list[Segment]:
        return segments(self.infeed_block)

    @property
    def text(self) -> str:
        lines = ["G71 G94 G90 G19", "G00 X-30. Y0 Z0", f"G81 X230. I-30. E{self.E}. P9100"]
        for part in self.segments:
            lines += [f"G01 Y-{part.end:.3f} F{self.infeed}", f"G04 X{part.dwell:.3f}"]
        return "\n".join([*lines, "G80", "M30", DRESS])


def program_run(case: Case, job: Job) -> GrindingRecord:
    """Run the program; the operator asks for a dress at the end of every infeed but the last."""
    control, times = job.control, []
    for event in execute(read(case.text), control):
        if isinstance(event, Line) and event.source is Source.PROGRAM and len(times) < case.D:
            control.request_dress()
            times.append(event.finish + 1e-6)
    return grind(read(case.text), job, control=dataclasses.replace(job.control, operator_dress_at=tuple(times)))


def compiled_tally(case: Case, job: Job, seconds: float) -> Any:
    """Return the tally of the compiled loop in which a dress takes `seconds`."""
    p, tallies = job.parameters, np.zeros(1, TALLY)
    motions = np.full((2 * (case.D + 1), len(FeedMotion._fields)), np.nan)
    write_motions(motions, 0, case.infeed_block)
    wheels = np.array([(*start_wheel(p), *PROCESS.own())], WHEEL)
    parts = np.array([tuple(PartState(0.0, 0.0, INITIAL_ROUGHNESS))], PART)
    tables = map(as_table, (wheels, parts, tallies))
    numbers = {"width": 20.0, "length": 200.0, "dress_seconds": seconds, **DRESS_NUMBERS}
    row = feeding_row(case.infeed_block, float(case.E), 0, 0.0, numbers)
    FEEDS.lanes(np.array([row]), np.array([p]), *tables, motions, np.arange(1), 0, 1)
    return tallies[0]


CASES = st.builds(
    Case,
    depth=st.integers(40, 400),
    infeed=st.sampled_from([0.2, 0.6, 1.5]),
    E=st.integers(3000, 30_000),
    D=st.integers(0, 4),
    sparkout=st.integers(1, 4),
)


def test_the_pick_of_a_stroke_is_infeed_rate_times_stroke_time() -> None:
    case = Case(depth=300, infeed=0.6, E=12_000, D=0, sparkout=2)
    record = program_run(case, job(stock=0.3))
    depth = record.strokes["Z"]
    # 0.01 mm/s times 260/200 + 200/1000 + 0.15 s
    assert np.diff(depth)[:-4] == pytest.approx(0.0165, abs=1e-9)
    assert depth[-3:] == pytest.approx(0.3)
    assert depth[-4] < 0.3 - 1e-4
    faster = program_run(dataclasses.replace(case, E=24_000), job(stock=0.3)).strokes["Z"]
    assert np.diff(faster)[0] == pytest.approx(0.01 * (260.0 / 400.0 + 400.0 / 1000.0 + 0.15), abs=1e-9)


@given(case=CASES)
def test_dress_requests_stand_at_equal_fractions_of_the_depth(case: Case) -> None:
    ends = [part.end for part in case.segments]
    assert ends[-1] == case.depth / 1000.0
    assert ends == pytest.approx([case.depth * (k + 1) / (case.D + 1) / 1000.0 for k in range(case.D + 1)], abs=5.01e-4)
    assert [part.start for part in case.segments] == [0.0, *ends[:-1]]
    stroke = case.infeed_block.travel + case.infeed_block.dwell
    for part in case.segments[:-1]:
        # the table comes to its next reversal in the dwell, and waits there for no more than 2 ms
        assert part.seconds < part.strokes * stroke + 1e-8
        assert part.strokes * stroke < part.seconds + part.dwell <= part.strokes * stroke + 0.0021


def test_power_is_averaged_over_full_plunges_since_the_last_dress() -> None:
    case = Case(depth=300, infeed=0.6, E=12_000, D=1, sparkout=2)
    shop = job(stock=0.3)
    record = program_run(case, shop)
    strokes, (dress,) = record.strokes, record.dresses
    tally = compiled_tally(case, shop, dress["seconds"])
    deeper = np.diff(strokes["Z"], prepend=0.0)
    full = np.flatnonzero(deeper >= 0.9 * 0.0165)
    after = int(case.segments[0].strokes)
    assert tally["first_power"] / tally["first_count"] == pytest.approx(strokes["power"][full[:6]].mean(), rel=1e-9)
    last = full[full >= after][-6:]
    assert len(last) == tally["last_count"] == 6.0
    latest = [tally[f"power_{number}"] for number in range(1, 7)]
    assert latest == pytest.approx(strokes["power"][last[::-1]], rel=1e-9)
    assert tally["plunge_rise"] == pytest.approx(strokes["T"][deeper > 0.0].max(), rel=1e-9)
