"""A cycle that is ground at once comes to what it does stroke by stroke."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.arrays import Array
from grind_env.control import CycleStrokes, read
from grind_env.errors import GrindError
from grind_env.machine.grind import GrindingError, grind
from grind_env.machine.job import Job, PartConditions, Stage, Times, WheelStart
from grind_env.machine.part.part import PartRun
from grind_env.machine.record import GrindingRecord
from grind_env.machine.watch import RunWatch
from grind_env.process.equations import LEAST_DIAMETER
from tests.examples import examples
from tests.machine.harness import CATALOGUE, CYCLE, DRESS, HEAD, LONG_AFTER, job, run, told_stepped

DRESSES = (0, 1, 1, 3)
"""D of the cycles. Those that are not executed take the seconds of their plan at once, and not those of their motions
one by one: times differ in their last bits, and with them the depth of a stroke beside a slow infeed."""


@st.composite
def cycles(draw: Any, dresses: tuple[int, ...]) -> list[str]:
    """The blocks of a part: cycles one after the other, with and without the table running on between them."""

    def one_of(*values: Any) -> Any:
        return draw(st.sampled_from(values))

    depth = one_of(0.0, 0.0, 0.02, -0.01)
    lines = [f"G00 X{one_of(-30.0, -30.0, -41.3, 40.0, 240.0)} Z{one_of(-2.5, 0.0, 4.25, -24.5, 30.0)}"]
    lines.append(f"G00 Y{-depth}")
    for _ in range(draw(st.integers(1, 3))):
        code = one_of("G82", "G83", "G82.1", "G83.1", "G81")
        table = f"X{one_of(230.0, 230.0, 150.5)} I{one_of(-30.0, -30.0, 12.25)} E{one_of(3e3, 12e3, 47e3, 2e3)} P9100"
        if code == "G81":
            depth += 0.012
            lines += [f"G81 {table}", f"G01 Y{-depth:.4f} F{one_of(6.0, 60.0)}", f"G04 X{one_of(1.0, 4.0)}"]
        else:
            depth += one_of(0.0, 0.004, 0.0311, 0.06)
            words = f"Y{-depth:.4f} J{one_of(-0.01, -0.0173, -0.2, -0.003)} F{one_of(60.0, 600.0, 6.0)}"
            words += f" L{one_of(0, 1, 2)} D{one_of(*dresses)}{one_of('', ' Q0', ' Q-.005')}"
            if code.startswith("G83"):
                lines.append(f"G01 Z{one_of(0.0, -3.0, 0.0)} F3000.")
                words += f" Z{one_of(5.0, 20.0, 0.0)} K{one_of(3.0, 7.0)}{one_of('', ' R0', ' R2.')}"
            lines.append(f"{code} {table} {words}")
        lines.append(one_of("", "", "G04 X.5", "M01", "G80", "G80\nM01", f"G01 Z{one_of(-1.0, 2.0)} F600."))
    return [*lines, "G80", "G00 Y20."]


@st.composite
def jobs(draw: Any) -> Job:
    """Parts narrower and wider than the wheel, beside it and not at zero, with wheels that wear out on the way."""

    def one_of(*values: Any) -> Any:
        return draw(st.sampled_from(values))

    surface = one_of(0.0, 0.0, 0.0005, -0.0071)
    made = job(
        material=one_of("aisi_52100", "inconel_718"),
        length=200.0,
        width=one_of(20.0, 3.3, 41.5),
        stock=one_of(0.1, 0.03),
        surface=surface,
        tolerance=9.0,
        stages=one_of((), (Stage(stock=0.02, roughness_limit=0.9),)),
        wheel_start=WheelStart(diameter=one_of(None, 250.05, 250.0)),
    )
    wheel = made.setup.wheel
    start = replace(made.wheel, diameter=None if made.wheel.diameter is None else wheel.minimum_diameter + 0.05)
    return replace(made, wheel=start, times=Times(load=20.0, wheel_change=one_of(None, 300.0)))


@st.composite
def programs(draw: Any, dresses: tuple[int, ...]) -> tuple[str, tuple[PartConditions, ...]]:
    """A text, and the conditions of its parts or none."""
    parts = draw(st.integers(1, 3))
    again = draw(st.booleans())
    first = "\n".join(draw(cycles(dresses)))
    bodies = [first if again or not k else "\n".join(draw(cycles(dresses))) for k in range(parts)]
    conditions = draw(
        st.just(())
        | st.tuples(
            *[
                st.builds(
                    PartConditions,
                    stock=st.none() | st.just(0.05),
                    factors=st.sampled_from([{}, {"kA": 1.7}, {"kA": 3e4}]),
                    new_wheel_factors=st.none() | st.just({"kA": 0.6}),
                )
            ]
            * parts
        )
    )
    return "G71 G94 G90 G19\n" + "\nM00\n".join(bodies) + "\nM30\n", conditions


def outcome(text: str, job: Job, conditions: tuple[PartConditions, ...], **settings: Any) -> GrindingRecord | str:
    control = replace(job.control, **settings)
    try:
        return run(text, job, control=control, conditions=conditions)
    except GrindError as error:
        return str(error)


def require_equal(found: Array, stepped: Array, tolerance: float) -> None:
    """Every column is the same: whole numbers and texts exactly, the others within a relative tolerance."""
    assert found.shape == stepped.shape
    for name in found.dtype.names or ():
        if found.dtype[name] == np.float64:
            np.testing.assert_allclose(found[name], stepped[name], tolerance, 1e-3 * tolerance, err_msg=name)
        else:
            np.testing.assert_array_equal(found[name], stepped[name], err_msg=name)


def require_same_ground(
    program: tuple[str, tuple[PartConditions, ...]], job: Job, coverage: bool, tolerance: float
) -> None:
    """A program does the same with whole cycles and stroke by stroke."""
    text, conditions = program
    found = outcome(text, job, conditions, coverage_pass=coverage)
    stepped = outcome(text, job, conditions, coverage_pass=coverage, operator_dress_at=LONG_AFTER)
    if isinstance(found, str) or isinstance(stepped, str):
        assert found == stepped
        return
    assert found.warnings == told_stepped(stepped)
    assert found.stages == stepped.stages and found.unjudged == stepped.unjudged
    require_equal(found.strokes, stepped.strokes, tolerance)
    require_equal(found.dresses, stepped.dresses, tolerance)
    require_equal(found.parts, stepped.parts, tolerance)


@examples(60)
@given(program=programs((0,)), job=jobs(), coverage=st.booleans())
def test_whole_cycles_grind_what_their_strokes_do_to_the_bit(program: Any, job: Job, coverage: bool) -> None:
    require_same_ground(program, job, coverage, 0.0)


@examples(60)
@given(program=programs(DRESSES), job=jobs(), coverage=st.booleans())
def test_whole_cycles_with_dresses_grind_what_their_strokes_do(program: Any, job: Job, coverage: bool) -> None:
    require_same_ground(program, job, coverage, 1e-9)


PLATES = HEAD + (CYCLE.replace("P9100", "P9100 D1") + "G80\nG00 Y20.\nM00\nG00 X-30. Y0\n") * 2 + "M30\n"


def test_a_wheel_worn_down_to_its_hub_is_dressed_with_the_lead_of_its_diameter() -> None:
    """None is left below that: what it was before a dress does not follow from what it is after it."""
    eaten = job(setup={"constant_surface_speed": True})
    conditions = (PartConditions(factors={"Gref": 1e-6}),) * 2
    found = outcome(PLATES, eaten, conditions)
    stepped = outcome(PLATES, eaten, conditions, operator_dress_at=LONG_AFTER)
    assert isinstance(found, GrindingRecord) and isinstance(stepped, GrindingRecord)
    assert found.dresses["ds"][1] == LEAST_DIAMETER
    require_equal(found.dresses, stepped.dresses, 1e-9)


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Of each event of strokes that a run takes the number of the part, and how many strokes it is."""
    found: list[tuple[int, int]] = []

    def noting(watch: RunWatch, part: PartRun, event: CycleStrokes, *arguments: Any) -> None:
        found.append((part.number, len(event.begins)))
        strokes(watch, part, event, *arguments)

    strokes = RunWatch.strokes
    monkeypatch.setattr(RunWatch, "strokes", noting)
    return found


def test_a_cycle_is_ground_at_once_when_its_dress_program_is_known(told: list[tuple[int, int]]) -> None:
    record = run(PLATES, job())
    assert record.parts["strokes"].tolist() == [8, 8]
    assert told == [(1, 1)] * 8 + [(2, 8)]
    assert record.dresses["after"].tolist() == [3, 11]


def test_an_operator_at_the_panel_has_strokes_stepped(told: list[tuple[int, int]]) -> None:
    slow, found = job().control, []
    for percent in (100.0, 50.0):
        slow.override(percent)
        found.append(run(HEAD + CYCLE + "M30\n", job(), control=slow).strokes)
    assert told == [(1, found[0].size)] + [(1, 1)] * found[1].size
    np.testing.assert_array_equal(found[1]["E"], 0.5 * found[0]["E"])


def test_a_whole_cycle_beyond_numbers_is_refused_in_its_line() -> None:
    beyond = PartConditions(factors={"u_ch": 1e308, "kp": 1e308})
    with pytest.raises(GrindingError, match=r"test\.nc:3: forces, heat or wear of a cut are no finite numbers"):
        run(HEAD + CYCLE + "M30\n", job(), conditions=(beyond,))


@pytest.mark.parametrize(("power", "said"), [(1400.0, "the spindle slows to"), (900.0, "the spindle stalls")])
@pytest.mark.parametrize("dress_requests", [(), LONG_AFTER])
def test_the_worst_stroke_of_a_cycle_for_the_spindle_is_told_of_once(
    power: float, said: str, dress_requests: tuple[float, ...]
) -> None:
    shop = job(setup={"machine": replace(CATALOGUE.machine("default"), power_limit=power)})
    control = replace(shop.control, operator_dress_at=dress_requests)
    record = grind(read(HEAD + CYCLE + "M30\n" + DRESS, "test.nc"), shop, control=control)
    torque = record.strokes["torque"]
    assert (torque > 1.01 * shop.parameters.rs).sum() > (torque >= 1.0).sum()
    worst = record.strokes["number"][int(torque.argmax())]
    (told,) = (each for each in record.warnings if "the spindle s" in each)
    assert told.startswith(f"test.nc:3: in stroke {worst} {said}")
