"""Surfaces in zones: compiled lanes, strips of the interpreter and strokes of the control agree."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.array_types import Array
from grind_env.control import Stroke, execute, read
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.machine.job import Job, WheelStart
from grind_env.machine.loops.cycle import PartState, Stroking, Zone
from grind_env.machine.loops.machine_lanes import NO_MOTIONS
from grind_env.machine.loops.part_surfaces import MOST_ZONES
from grind_env.machine.loops.strip_stroke import add_to_cut, add_zone, contact_at, cut_surface, is_cut
from grind_env.machine.loops.zone_layout import strip_centres, strip_zones, traverse_edges, zones_of
from grind_env.machine.part.gauging import gauge, gauge_zones
from grind_env.process.entries import Machine
from grind_env.process.stroke_types import WheelState
from tests.batches import PARAMETERS, TALLY, TRAVERSES, WHEEL, as_table, cold
from tests.examples import examples
from tests.machine.harness import CATALOGUE, DRESS, job, run, start_wheel, stroking

S, RS, REACHED, CENTRE, STRIPS, *_ = range(len(Zone._fields))
WHEEL_WIDTH = 25.0


@dataclasses.dataclass(frozen=True)
class Case:
    """G83 block and its job; depths and picks in um, ways across in quarters of a mm, exact in doubles."""

    wear_flats: float
    volume: float
    stiffness: float
    power_limit: float
    width: int
    start: int
    end: int
    above: int
    depth: int
    J: int
    Q: int
    K: int
    R: int
    L: int
    E: int
    D: int
    pre_dress: bool

    @property
    def text(self) -> str:
        code = "G83.1" if self.pre_dress else "G83"
        return (
            "G71 G94 G90 G19\n"
            f"G00 X-30. Y{self.above / 1000:.3f} Z{self.start / 4:.2f}\n"
            f"{code} X230. I-30. Y-{self.depth / 1000:.3f} J-{self.J / 1000:.3f} Q-{self.Q / 1000:.3f} "
            f"Z{self.end / 4:.2f} K{self.sign * self.K / 4:.2f} R{self.sign * self.R / 4:.2f} L{self.L} "
            f"F6000. E{self.E}. P9100 D{self.D}\nM30\n"
        )

    @property
    def sign(self) -> float:
        return 1.0 if self.end >= self.start else -1.0

    @property
    def machine(self) -> Machine:
        default = CATALOGUE.machine("default")
        return dataclasses.replace(default, stiffness=self.stiffness, power_limit=self.power_limit)

    @property
    def job(self) -> Job:
        return job(
            width=self.width / 2.0,
            setup={"machine": self.machine},
            wheel_start=WheelStart(wear_flat_area=self.wear_flats, volume_since_dress=self.volume),
        )

    @property
    def wheel(self) -> WheelState:
        return start_wheel(self.job.parameters)._replace(A=self.wear_flats, V=self.volume)

    def stroking(self, dress_seconds: float = 30.0) -> Stroking:
        return stroking(
            self.E / 60.0,
            self.depth / 1000.0,
            start=-self.above / 1000.0,
            full_plunge=max(self.J, self.Q) / 1000.0 - 1e-9,
            width=self.width / 2.0,
            dress_seconds=dress_seconds,
            cross_start=self.start / 4.0,
            cross_end=self.end / 4.0,
        )

    @property
    def rules(self) -> TraverseCycle:
        return TraverseCycle(
            depth=self.depth / 1000.0 + self.above / 1000.0,
            primary_pick=self.J / 1000.0,
            secondary_pick=self.Q / 1000.0,
            width=abs(self.end - self.start) / 4.0,
            primary_cross_pick=self.K / 4.0,
            secondary_cross_pick=self.R / 4.0,
            at_depth=1.0 + self.L,
            executions=float(self.D),
            pre_dress=float(self.pre_dress),
        )

    @property
    def centres(self) -> Any:
        return strip_centres(0.0, self.width / 2.0)

    @property
    def joined(self) -> Array:
        """Surface of the part in as few zones as the traverses allow."""
        return zones_of(self.centres, traverse_edges(self.rules, self.start / 4.0, self.end / 4.0), WHEEL_WIDTH)


def cases(**fixed: Any) -> st.SearchStrategy[Case]:
    """Draw plates with crossovers that begin or end on them or beside them, or lead back."""
    drawn = {
        "wear_flats": st.floats(0.005, 0.06),
        "volume": st.floats(0.0, 600.0),
        "stiffness": st.sampled_from([10_000.0, 20_000.0, 500_000.0]),
        "power_limit": st.sampled_from([7500.0, 7500.0, 1000.0, 300.0]),
        "width": st.integers(30, 180),
        "start": st.integers(-140, 240),
        "end": st.integers(-140, 240),
        "above": st.integers(0, 5),
        "depth": st.integers(0, 40),
        "J": st.integers(3, 20),
        "Q": st.integers(0, 20),
        "K": st.integers(24, 100),
        "R": st.integers(0, 100),
        "L": st.integers(0, 2),
        "E": st.integers(6000, 30_000),
        "D": st.integers(0, 3),
        "pre_dress": st.booleans(),
    }
    return st.builds(Case, **{**drawn, **{name: st.just(value) for name, value in fixed.items()}})


def padded(tables: list[Array]) -> Array:
    """Return the surfaces of several parts in one table; missing zones have no strips."""
    most = max(len(table) for table in tables)
    none = Zone(S=0.0, Rs=1.0, reached=0.0, centre=np.inf, strips=0.0)
    return np.array([[*table, *[none] * (most - len(table))] for table in tables])


def machines(cases: list[Case], dress_seconds: float = 30.0) -> tuple[Array, Array, Array]:
    return (
        np.array([(*case.stroking(dress_seconds), *case.rules) for case in cases]),
        as_table(np.array([case.job.parameters for case in cases], PARAMETERS)),
        as_table(np.array([cold(case.wheel) for case in cases], WHEEL)),
    )


@dataclasses.dataclass(frozen=True)
class Ground:
    wheels: Array
    surfaces: Array
    tallies: Array

    def machine(self, i: int) -> bytes:
        return self.wheels[i].tobytes() + self.surfaces[i].tobytes() + self.tallies[i].tobytes()


def in_lanes(cases: list[Case], surfaces: Array, dress_seconds: float = 30.0) -> Ground:
    cycles, parameters, wheels = machines(cases, dress_seconds)
    surfaces, tallies = surfaces.copy(), np.zeros((len(cases), len(TALLY)))
    order = np.arange(len(cases))
    TRAVERSES.lanes(cycles, parameters, wheels, surfaces, tallies, NO_MOTIONS, order, 0, 1)
    return Ground(wheels, surfaces, tallies)


@pytest.mark.bits
@examples(25)
@given(many=st.lists(cases(), min_size=1, max_size=20), joined=st.booleans())
def test_machines_of_a_batch_have_the_bits_of_each_alone(many: list[Case], joined: bool) -> None:
    tables = [case.joined if joined else strip_zones(case.centres) for case in many]
    surfaces = padded(tables)
    together = in_lanes(many, surfaces)
    for i, case in enumerate(many):
        alone = in_lanes([case], surfaces[i : i + 1])
        assert together.machine(i) == alone.machine(0), case
        # the number of zones of the others does not matter
        assert in_lanes([case], tables[i][None]).surfaces[0].tobytes() == alone.surfaces[0, : len(tables[i])].tobytes()


def assert_close(found: Any, expected: Any, name: str) -> None:
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12, err_msg=name)


@examples(40)
@given(case=cases())
def test_joined_strips_are_ground_as_single_strips(case: Case) -> None:
    zones = case.joined
    assert zones[:, STRIPS].sum() == case.centres.size
    joined, apart = in_lanes([case], zones[None]), in_lanes([case], strip_zones(case.centres)[None])
    for name in TALLY.names or ():
        assert_close(joined.tallies.view(TALLY)[name], apart.tallies.view(TALLY)[name], name)
    for column in (S, RS, REACHED):
        each = np.repeat(joined.surfaces[0, :, column], zones[:, STRIPS].astype(int))
        assert_close(each, apart.surfaces[0, :, column], Zone._fields[column])


@examples(40)
@given(case=cases())
def test_zones_lose_the_stock_that_strokes_remove(case: Case) -> None:
    zones, record = case.joined, run(case.text, case.job)
    found = in_lanes([case], zones[None], float(record.dresses["seconds"][0]) if record.dresses.size else 0.0)
    removed = (found.surfaces[0, :, S] * zones[:, STRIPS]).sum() / case.centres.size * case.width / 2.0
    assert removed == pytest.approx((record.strokes["ae"] * record.strokes["b"]).sum(), rel=1e-9, abs=1e-12)


def test_a_wheel_beside_the_part_changes_nothing_but_the_time() -> None:
    case = Case(0.02, 100.0, 20_000.0, 7500.0, 60, 0, 80, 0, 20, 10, 10, 40, 40, 1, 12_000, 0, False)
    beside = dataclasses.replace(case, start=160, end=240)
    found = in_lanes([beside], strip_zones(beside.centres)[None])
    assert tuple(found.wheels[0]) == cold(beside.wheel)
    assert found.surfaces[0].tobytes() == strip_zones(beside.centres).tobytes()
    tally = found.tallies.view(TALLY)[0, 0]
    assert tally["seconds"] == in_lanes([case], case.joined[None]).tallies.view(TALLY)[0, 0]["seconds"] > 0.0
    assert tally["peak_load"] == tally["worn"] == tally["plunge_rise"] == 0.0


def test_more_zones_than_the_lanes_hold_are_refused() -> None:
    case = Case(0.02, 100.0, 20_000.0, 7500.0, 60, 0, 80, 0, 20, 10, 10, 40, 40, 1, 12_000, 0, False)
    with pytest.raises(ValueError, match=rf"^a surface has more than {MOST_ZONES} zones"):
        in_lanes([case], np.repeat(case.joined[None, :1], MOST_ZONES + 1, axis=1))


def test_edges_of_the_wheel_divide_the_part_into_zones() -> None:
    # there by 12 mm and back by 12 mm, in 35 mm: the wheel of 25 mm begins at 0, 12, 24, 35, 23 and 11 mm
    case = Case(0.02, 0.0, 20_000.0, 7500.0, 120, 0, 140, 0, 20, 10, 10, 48, 48, 0, 12_000, 0, False)
    edges = {0, 11, 12, 23, 24, 35}
    bounds = sorted({*edges, *(edge + 25 for edge in edges)} - {0, 60})
    zones = case.joined
    assert np.diff([0, *bounds, 60]).tolist() == zones[:, STRIPS].tolist()
    assert zones[:, CENTRE].tolist() == [edge + 0.5 for edge in [0, *bounds]]
    assert len(zones) < MOST_ZONES


@examples(60)
@given(case=cases(depth=40, J=3, Q=3, L=2))
def test_traverse_edges_are_the_places_of_its_strokes(case: Case) -> None:
    control = dataclasses.replace(case.job.control, whole_cycles=False)
    strokes = (event for event in execute(read(case.text + DRESS), control) if isinstance(event, Stroke))
    cycle = TraverseCycle(1.0, 1.0, 1.0, abs(case.end - case.start) / 4.0, case.K / 4.0, case.R / 4.0, 1.0, 0.0, 0.0)
    edges = traverse_edges(cycle, case.start / 4.0, case.end / 4.0)
    assert sorted({event.start[2] for event in strokes}) == pytest.approx(edges)


@given(st.lists(st.tuples(st.integers(1, 9), *[st.floats(0.0, 0.01), st.floats(0.1, 2.0)] * 2), min_size=1, max_size=4))
def test_the_surface_in_the_cut_is_the_mean_of_all_strips(zones: list[tuple[int, float, float, float, float]]) -> None:
    made = [Zone(S, Rs, S, 0.0, float(strips), *steps) for strips, S, Rs, *steps in zones]
    contact = contact_at(1.0)
    for zone in made:
        contact = add_zone(contact, zone, True)
    for zone in made:
        contact = add_to_cut(contact, zone, is_cut(contact, zone, True))
    strips = [zone for zone in made for _ in range(int(zone.strips))]
    width, part = cut_surface(contact, 60.0, 1.0)
    assert width == 60.0
    means = [np.mean([getattr(each, name) for each in strips]) for name in PartState._fields[1:]]
    assert part[1:] == pytest.approx(means, rel=1e-12)


def test_gauging_zones_equals_gauging_strips() -> None:
    for depths in ((0.05, 0.052, 0.056), (0.056, 0.05, 0.052), (0.04, 0.052, 0.049)):
        zones = np.array([Zone(S, 0.4, S, 0.0, 2.0) for S in depths])
        strips = gauge(np.repeat(depths, 2), np.full(6, 0.4), 0.05)
        assert gauge_zones(zones, 0.05) == pytest.approx(strips)
        assert abs(strips.worst_error) == pytest.approx(1000.0 * max(abs(S - 0.05) for S in depths))
