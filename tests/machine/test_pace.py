"""Strokes of a table that accelerates over the part, against the part in 200 cells of its length."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control.cycle_formulas import motion_time
from grind_env.machine.job import Job, WheelStart
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.table_speed import Pace, pace_of, paced_of, steady
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.process_interface import PROCESS, PartHeat
from grind_env.process.stroke_and_dress import grind_stroke, stroke_constants
from tests.examples import examples
from tests.machine.harness import job, run, start_wheel

CELLS = 200
SPARK_OUT = 3


class Case(NamedTuple):
    """Eight plunges and a spark-out; lengths and overtravels in mm, E in mm/min, acceleration in mm/s2, pick in um."""

    length: int
    near: int
    far: int
    E: int
    acceleration: int
    pick: int
    material: str
    wear_flats: float

    @property
    def job(self) -> Job:
        start = WheelStart(wear_flat_area=self.wear_flats)
        found = job(length=float(self.length), stock=0.008 * self.pick, material=self.material, wheel_start=start)
        # a spindle far from its limit, on a part whose growth is left out
        machine = {"acceleration": float(self.acceleration), "power_limit": 1e5}
        return with_entries(found, {"machine": machine, "material": {"thermal_expansion": 0.0}})

    @property
    def text(self) -> str:
        head = f"G71 G94 G90 G19\nG00 X-{self.near}. Y0 Z0\n"
        picks = f"Y-{0.008 * self.pick:.3f} J-{0.001 * self.pick:.3f} L{SPARK_OUT} F600."
        turns = f"X{self.length + self.far}. I-{self.near}."
        return f"{head}G82 {turns} {picks} E{self.E}. P9100\nM30\n"

    @property
    def travel(self) -> float:
        return float(self.near + self.length + self.far)

    @property
    def pace(self) -> Pace:
        off = 0.5 * abs(self.near - self.far)
        return pace_of(self.E / 60.0, self.travel, float(self.length), off, float(self.acceleration))

    @property
    def accelerates(self) -> bool:
        return 2.0 * self.acceleration * min(self.near, self.far) < (self.E / 60.0) ** 2

    @property
    def speeds(self) -> Any:
        """Table speed over the middle of each cell, mm/s."""
        ways = self.near + self.length * (np.arange(CELLS) + 0.5) / CELLS
        ways = np.minimum(ways, self.travel - ways)
        return np.minimum(self.E / 60.0, np.sqrt(2.0 * self.acceleration * ways))


def by_cells(case: Case) -> dict[str, Any]:
    """Grind the part in cells, each with its own speed and surface, and return one number per stroke."""
    p, width = case.job.parameters, case.job.part.width
    constants = [stroke_constants(p, v, case.length) for v in case.speeds]
    wheel = start_wheel(p)._replace(A=case.wear_flats)
    S, Rs, found = np.zeros(CELLS), np.full(CELLS, INITIAL_ROUGHNESS), []
    for number in range(9 + SPARK_OUT):
        Z = 0.001 * case.pick * min(number, 8)
        ends = [grind_stroke(wheel, S[i], Rs[i], Z, width, k) for i, k in enumerate(constants)]
        wheel = type(wheel)(*np.mean([after for after, _ in ends], axis=0))
        strokes = [stroke for _, stroke in ends]
        seen = {
            name: np.array([getattr(each, name) for each in strokes]) for name in ("ae", "Ra", "power", "torque", "T")
        }
        S, Rs, per = S + seen["ae"], seen["Ra"], 1.0 / case.speeds
        mean_power = float((seen["power"] * per).sum() / per.sum())
        found.append((S.mean(), Rs.mean(), mean_power, seen["torque"].max(), seen["T"].max()))
    return dict(zip(("S", "Ra", "power", "torque", "T"), np.transpose(found), strict=True))


CASES = st.builds(
    Case,
    length=st.integers(50, 600),
    near=st.integers(20, 60),
    far=st.integers(20, 60),
    E=st.integers(10_000, 40_000),
    acceleration=st.integers(1000, 3000),
    pick=st.integers(3, 20),
    material=st.sampled_from(["aisi_52100", "m2", "aisi_1045"]),
    wear_flats=st.sampled_from([0.008, 0.02, 0.05]),
)


@examples(25)
@given(case=CASES.filter(lambda case: case.accelerates))
def test_strokes_of_an_accelerating_table_match_the_part_in_cells(case: Case) -> None:
    found, expected = run(case.text, case.job).strokes, by_cells(case)
    first, plunged = 1, 8
    removed = np.cumsum(found["ae"])
    assert removed[first] == pytest.approx(expected["S"][first], abs=0.01 * 0.001 * case.pick)
    assert removed[[plunged, -1]] == pytest.approx(expected["S"][[plunged, -1]], rel=0.01)
    for name in ("power", "torque", "Ra"):
        assert found[name][[first, plunged]] == pytest.approx(expected[name][[first, plunged]], rel=0.01), name
    assert found["Ra"][-1] == pytest.approx(expected["Ra"][-1], rel=0.01)


@given(case=CASES, near=st.integers(0, 600))
def test_the_two_speeds_of_a_pace_give_the_time_over_the_part(case: Case, near: int) -> None:
    case = case._replace(near=near)
    pace, a, v = case.pace, float(case.acceleration), case.E / 60.0
    assert 0.0 <= pace.slow_share < 1.0 and pace.slow <= pace.speed <= v
    per_mm = pace.slow_share / pace.slow + (1.0 - pace.slow_share) / pace.speed
    ramp = min(v * v / (2.0 * a), 0.5 * case.travel)

    def passed(way: float) -> float:
        """Return the time at which the table has gone so far, s."""
        if way > case.travel - ramp:
            return motion_time(case.travel, v, a) - math.sqrt(2.0 * (case.travel - way) / a)
        return math.sqrt(2.0 * min(way, ramp) / a) + max(way - ramp, 0.0) / v

    assert case.length * per_mm == pytest.approx(passed(near + case.length) - passed(near), rel=1e-9)
    assert pace.slow_time * per_mm == pytest.approx(pace.slow_share / pace.slow, rel=1e-9)


@given(case=CASES.filter(lambda case: not case.accelerates), step=st.floats(0.0, 0.002))
def test_a_table_at_constant_speed_over_the_part_grinds_as_one_stroke(case: Case, step: float) -> None:
    pace = case.pace
    assert pace == steady(case.E / 60.0)
    p = case.job.parameters
    held, wheel, own = stroke_constants(p, pace.speed, case.length), start_wheel(p), PartHeat(3.0)
    part = PartState(Z=0.01, S=0.01, Rs=0.7, S_step=step, Rs_step=50.0 * step)
    after, left, stroke, _, fast = paced_of(PROCESS)(wheel, own, part, 0.02, 20.0, pace, held, held, 1.5)
    assert (after, left, fast) == PROCESS.stroke(wheel, own, 0.01, 0.7, 0.02, 20.0, held, 1.5)
    # peaks also cover the stock that earlier blocks left near the ends
    peaks = ("load", "torque", "T", "burn_ratio") if step > 0.0 else ()
    assert stroke._replace(**{name: getattr(fast, name) for name in peaks}) == fast
