"""A G82 block gives equal results in the interpreter (`machine.grind`) and in the batched kernel."""

import dataclasses
import importlib.util
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from grind_env.array_types import Array
from grind_env.control import Control
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE, motion_time
from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.machine.job import Job, WheelStart
from grind_env.machine.loops import stroke_loops
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.machine_lanes import NO_MOTIONS
from grind_env.machine.loops.table_speed import pace_of
from grind_env.machine.part.stroke_record import WheelSeen
from grind_env.machine.record import GrindingRecord
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.stroke_types import StrokeParameters, WheelState
from tests import batches
from tests.batches import CYCLE, PARAMETERS, PART, WHEEL, cold, grind_cycles
from tests.examples import examples
from tests.machine.harness import CATALOGUE, job, run, start_wheel, stroking

MICRONS = 1000.0  # per mm; the quotient is exactly the number in a word such as Y.009


@dataclasses.dataclass(frozen=True)
class Case:
    """G82 block and its job; depths and picks in whole um, as the control reads them."""

    material: str
    wheel: str
    stiffness: float
    power_limit: float
    constant_surface_speed: bool
    wear_flats: float
    volume: float
    diamond_flat: float
    width: float
    length: float
    overrun: tuple[int, int]
    start: int
    above: int
    depth: int
    J: int
    Q: int | None
    L: int
    E: int
    D: int
    pre_dress: bool
    coverage: bool

    @property
    def primary(self) -> float:
        return self.length + self.overrun[0]

    @property
    def secondary(self) -> float:
        return float(-self.overrun[1])

    @property
    def text(self) -> str:
        q = "" if self.Q is None else f" Q-{self.Q / 1000:.3f}"
        code = "G82.1" if self.pre_dress else "G82"
        return (
            "G71 G94 G90 G19\n"
            f"G00 X{self.secondary - self.start:.3f} Y{self.above / 1000:.3f} Z0\n"
            f"{code} X{self.primary:.3f} I{self.secondary:.3f} Y-{self.depth / 1000:.3f} "
            f"J-{self.J / 1000:.3f}{q} L{self.L} F600. E{self.E}. P9100 D{self.D}\nM30\n"
        )

    @property
    def job(self) -> Job:
        machine = dataclasses.replace(
            CATALOGUE.machine("default"), stiffness=self.stiffness, power_limit=self.power_limit
        )
        return job(
            material=self.material,
            wheel=self.wheel,
            length=self.length,
            width=self.width,
            setup={"machine": machine, "constant_surface_speed": self.constant_surface_speed},
            wheel_start=WheelStart(
                wear_flat_area=self.wear_flats, volume_since_dress=self.volume, diamond_flat=self.diamond_flat
            ),
        )

    @property
    def control(self) -> Control:
        return dataclasses.replace(self.job.control, coverage_pass=self.coverage)


def cases() -> st.SearchStrategy[Case]:
    return st.builds(
        Case,
        material=st.sampled_from(["aisi_52100", "aisi_1020", "inconel_718"]),
        wheel=st.sampled_from(["a60j", "b126"]),
        stiffness=st.sampled_from([10_000.0, 20_000.0, 50_000.0]),
        power_limit=st.sampled_from([7500.0, 7500.0, 1000.0, 300.0]),
        constant_surface_speed=st.booleans(),
        wear_flats=st.floats(0.005, 0.06),
        volume=st.floats(0.0, 600.0),
        diamond_flat=st.floats(0.0, 0.1),
        width=st.sampled_from([3.0, 10.0, 20.0, 24.5]),
        length=st.sampled_from([50.0, 200.0, 333.25]),
        overrun=st.tuples(st.integers(1, 60), st.integers(1, 60)),
        start=st.integers(-1, 40),
        above=st.integers(0, 15),
        depth=st.integers(0, 150),
        J=st.integers(3, 25),
        Q=st.none() | st.integers(0, 25),
        L=st.integers(0, 5),
        E=st.integers(3000, 30_000),
        D=st.integers(0, 3) | st.sampled_from([0, 7, 40, 999]),
        pre_dress=st.booleans(),
        coverage=st.booleans(),
    )


class Batched(NamedTuple):
    result: Any
    wheel: Any
    part: Any


def records(kind: type[Any], dtype: np.dtype[np.void], rows: list[Any]) -> Any:
    assert all(isinstance(row, kind) for row in rows)
    return np.array([tuple(row) for row in rows], dtype)


def tables(cases: list[Case], dress_seconds: float = 30.0) -> tuple[Any, Any, Any, Any]:
    """Return the arguments of `grind_cycles`, computed from the cases without the interpreter."""
    cycles: list[tuple[float, ...]] = []
    parameters: list[StrokeParameters] = []
    wheels: list[WheelState] = []
    for case in cases:
        p, v = case.job.parameters, case.E / 60.0
        wheels.append(start_wheel(p, case.diamond_flat)._replace(A=case.wear_flats, V=case.volume))
        parameters.append(p)
        start = round(case.secondary - case.start, 3)
        off = 0.5 * abs(case.overrun[0] - case.overrun[1])
        picks = [pick / MICRONS for pick in (case.J, case.J if case.Q is None else case.Q)]
        strokes = stroking(
            v,
            case.depth / MICRONS,
            first_seconds=motion_time(case.primary - start, v, 1000.0) + 0.15,
            stroke_seconds=motion_time(case.primary - case.secondary, v, 1000.0) + 0.15,
            set_out=motion_time(case.primary - start, v, 1000.0) + 0.15,
            start=-case.above / MICRONS,
            full_plunge=max(picks) - DEPTH_TOLERANCE,
            width=case.width,
            length=case.length,
            dress_seconds=dress_seconds,
        )._replace(**pace_of(v, case.primary - case.secondary, case.length, off, 1000.0)._asdict())
        rules = PlungeCycle(
            depth=case.depth / MICRONS + case.above / MICRONS,
            primary_pick=picks[0],
            secondary_pick=picks[1],
            at_depth=float(case.coverage + case.L),
            executions=float(case.D),
            pre_dress=float(case.pre_dress),
        )
        cycles.append((*strokes, *rules))
    parts = [PartState(0.0, 0.0, INITIAL_ROUGHNESS)] * len(cases)
    return (
        np.array(cycles, CYCLE),
        records(StrokeParameters, PARAMETERS, parameters),
        np.array([cold(wheel) for wheel in wheels], WHEEL),
        records(PartState, PART, parts),
    )


def batched(case: Case, dress_seconds: float) -> Batched:
    cycles, parameters, wheels, parts = tables([case], dress_seconds)
    results = grind_cycles(cycles, parameters, wheels, parts)
    return Batched(results[0], wheels[0], parts[0])


def strokes_and_dresses(case: Case) -> tuple[Array, list[int]]:
    """Return the depth of every stroke, um, and the strokes made before each dress (PD-10), in whole numbers."""
    H, h, heights, places = case.depth + case.above, 0, list[int](), [0] * case.pre_dress
    done = 0
    while h < H:
        heights.append(h)
        h = min(H, h + (case.J if len(heights) % 2 or case.Q is None else case.Q))
        due = min(case.D, h * (case.D + 1) // H)
        places += [len(heights)] * (due - done)
        done = due
    return np.array([*heights, *[H] * (case.coverage + case.L)]) - case.above, places


#: ten full plunges, each followed by a smaller one
EVERY_SECOND = Case(
    material="aisi_52100",
    wheel="a60j",
    stiffness=20_000.0,
    power_limit=7500.0,
    constant_surface_speed=False,
    wear_flats=0.01,
    volume=0.0,
    diamond_flat=0.0,
    width=20.0,
    length=200.0,
    overrun=(30, 30),
    start=0,
    above=0,
    depth=120,
    J=10,
    Q=2,
    L=1,
    E=12_000,
    D=0,
    pre_dress=False,
    coverage=True,
)


@examples(200)
@example(case=EVERY_SECOND)
@example(case=dataclasses.replace(EVERY_SECOND, J=2, Q=10))
@example(case=dataclasses.replace(EVERY_SECOND, D=1))
@given(case=cases())
def test_a_program_and_the_batched_cycle_agree(case: Case) -> None:
    assume(case.depth + case.above + case.L + case.coverage > 0)  # else the control makes no stroke
    record = run(case.text, case.job, control=case.control)
    dress_seconds = float(record.dresses["seconds"][0]) if record.dresses.size else 0.0
    batch = batched(case, dress_seconds)
    n, (depths, places) = len(record.strokes), strokes_and_dresses(case)

    assert n == batch.result["strokes"] == len(depths)
    assert len(record.dresses) == batch.result["dresses"]
    assert list(record.dresses["after"]) == places
    assert_same_times(case, record)
    assert_same_plunges(case, record, batch.result)
    if n not in places:  # otherwise a dress follows the last stroke
        for name in WheelSeen._fields:
            assert_close(record.strokes[name][-1], batch.wheel[name], name)

    part = record.parts[0]
    assert_close(part["S"], batch.part["S"], "S")
    assert_close(part["Ra"], batch.part["Rs"], "Ra")
    assert_close(part["peak_power"], np.minimum(batch.result["peak_load"], case.power_limit), "peak_power")
    assert_close(part["rise"], batch.result["finish_rise"], "rise")
    assert_close(part["burn_ratio"], batch.result["burn_ratio"], "burn_ratio")
    assert_close(part["worn"], batch.result["worn"], "worn")
    assert_close(part["dressed_off"], batch.result["dressed_off"], "dressed_off")
    seconds = record.strokes["seconds"].sum() + record.dresses["seconds"].sum()
    if part["peak_torque"] >= 1.0:
        seconds += case.job.setup.machine.stall_time
    assert batch.result["seconds"] == pytest.approx(seconds, rel=1e-12)


def assert_same_times(case: Case, record: GrindingRecord) -> None:
    cycle = tables([case])[0][0]
    seconds = list(record.strokes["seconds"])
    assert seconds[0] == cycle["first_seconds"]
    assert set(seconds[1:]) <= {cycle["stroke_seconds"]}


def assert_same_plunges(case: Case, record: GrindingRecord, tally: Any) -> None:
    """Assert the powers of full plunges and the heat of all, as the depths of the strokes imply."""
    strokes, (depths, places) = record.strokes, strokes_and_dresses(case)
    gain, stalled = np.diff(np.maximum.accumulate([0, *depths])), strokes["torque"] >= 1.0
    # up to a stall, after which the wheel passes above the part
    full = (gain >= max(case.J, case.Q or 0)) & (np.cumsum(stalled) == stalled)
    since = np.arange(len(depths)) >= (places[-1] if places else 0)
    first, last = strokes["mean_load"][full][:6], strokes["mean_load"][full & since][-6:]
    assert (tally["first_count"], tally["last_count"]) == (len(first), len(last))
    assert_close(tally["first_power"], first.sum(), "first_power")
    assert_close(window(tally), [*last[::-1], *[0.0] * (6 - len(last))], "window")
    assert_close(tally["plunge_rise"], strokes["T"][gain > 0].max(initial=0.0), "plunge_rise")


def window(tally: Any) -> list[float]:
    """Return the powers of the latest full plunges, newest first."""
    return [float(tally[f"power_{number}"]) for number in range(1, 7)]


def assert_close(found: Any, expected: Any, name: str) -> None:
    # atol is for cuts of a few pm, which show the rounding of coordinates
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-13, err_msg=name)


def test_a_tally_continues_from_cycle_to_cycle() -> None:
    short = dataclasses.replace(EVERY_SECOND, depth=30, L=0, coverage=False)
    cycles, parameters, wheels, parts = tables([EVERY_SECOND])
    before = grind_cycles(cycles, parameters, wheels, parts)
    found = []
    for tallies in (np.zeros_like(before), before.copy()):
        cycles, *_, parts = tables([short])
        numbers = [batches.as_table(each) for each in (cycles, parameters, wheels.copy(), parts, tallies)]
        batches.PLUNGES.lanes(*numbers, NO_MOTIONS, np.arange(1), 0, 1)
        found.append(tallies[0])
    first, (alone, after) = before[0], found
    assert (alone["first_count"], alone["last_count"], after["last_count"]) == (2.0, 2.0, 6.0)
    assert window(after) == [*window(alone)[:2], *window(first)[:4]]
    assert after["first_power"] == first["first_power"]
    for name in ("seconds", "strokes", "worn"):
        assert after[name] == pytest.approx(first[name] + alone[name], rel=1e-12), name
    for name in ("peak_load", "plunge_rise", "finish_rise", "burn_ratio"):
        assert after[name] == max(first[name], alone[name]), name


MANY = [
    dataclasses.replace(
        EVERY_SECOND,
        material=["aisi_52100", "aisi_1020", "inconel_718"][k % 3],
        wheel=["a60j", "b126"][k // 3 % 2],
        stiffness=[10_000.0, 20_000.0, 50_000.0][k % 3],
        power_limit=[7500.0, 1500.0][k % 2],
        constant_surface_speed=k % 4 == 0,
        wear_flats=0.006 + 0.001 * k,
        volume=20.0 * k,
        diamond_flat=0.002 * k,
        width=[10.0, 20.0][k % 2],
        above=k % 5,
        depth=(7 * k) % 120,
        J=3 + (5 * k) % 20,
        Q=None if k % 3 else (2 * k) % 20,
        L=k % 6,
        E=3000 + 700 * k,
        D=k % 4,
        pre_dress=k % 5 == 0,
    )
    for k in range(37)
]


def outcome(cases: list[Case], grind: Callable[..., Array]) -> tuple[bytes, ...]:
    """Return results, wheels and parts of each case as bytes."""
    cycles, parameters, wheels, parts = tables(cases)
    results = grind(cycles, parameters, wheels, parts)
    return tuple(results[i].tobytes() + wheels[i].tobytes() + parts[i].tobytes() for i in range(len(cases)))


@pytest.fixture(scope="module")
def alone() -> tuple[bytes, ...]:
    """Return the outcome of each case without another machine beside it."""
    found = tuple(outcome([case], grind_cycles)[0] for case in MANY)
    assert len(set(found)) == len(MANY)
    return found


@pytest.mark.bits
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_machines_of_a_batch_have_the_bits_of_each_alone(alone: tuple[bytes, ...], threads: int) -> None:
    assert outcome(MANY, partial(grind_cycles, threads=threads)) == alone


@pytest.mark.bits
@pytest.mark.parametrize(
    "chosen", [*map(range, (1, 2, 7, 8, 9, 20)), np.random.default_rng(1).permutation(len(MANY))], ids=len
)
def test_the_number_and_the_order_of_machines_change_no_bit(alone: tuple[bytes, ...], chosen: Sequence[int]) -> None:
    assert outcome([MANY[k] for k in chosen], grind_cycles) == tuple(alone[k] for k in chosen)


@pytest.mark.bits
@pytest.mark.parametrize("count", [4, 16])
def test_the_number_of_lanes_changes_no_bit(
    alone: tuple[bytes, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, count: int
) -> None:
    source = Path(stroke_loops.__file__).read_text(encoding="utf-8")
    assert "\nLANES = 8  #" in source
    path = tmp_path / f"loops_{count}.py"
    path.write_text(source.replace("\nLANES = 8  #", f"\nLANES = {count}  #"), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
        monkeypatch.setattr(batches, "PLUNGES", module.loops_of(CYCLE_KERNELS["G82"]))
        assert outcome(MANY, grind_cycles) == alone
    finally:
        del sys.modules[path.stem]
