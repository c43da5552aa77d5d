"""Cycles ground at once equal cycles ground stroke by stroke."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grind_env.control import CycleStrokes, read
from grind_env.machine.grind import grind
from grind_env.machine.job import PartConditions
from grind_env.machine.part.part import PartRun
from grind_env.machine.warnings import RunWatch
from grind_env.process.equations import LEAST_DIAMETER
from tests.machine.harness import CATALOGUE, CYCLE, DRESS, HEAD, LONG_AFTER, job, run

PLATES = HEAD + (CYCLE.replace("P9100", "P9100 D1") + "G80\nG00 Y20.\nM00\nG00 X-30. Y0\n") * 2 + "M30\n"


def test_a_wheel_worn_down_to_its_hub_is_dressed_with_the_lead_of_its_diameter() -> None:
    eaten = job(setup={"constant_surface_speed": True})
    conditions = (PartConditions(factors={"Gref": 1e-6}),) * 2
    found, stepped = (
        run(PLATES, eaten, control=replace(eaten.control, operator_dress_at=asked), parts=conditions).dresses
        for asked in ((), LONG_AFTER)
    )
    assert found["ds"][1] == LEAST_DIAMETER
    for name in (name for name in found.dtype.names if found.dtype[name] == np.float64):
        np.testing.assert_allclose(found[name], stepped[name], 1e-9, 1e-12, err_msg=name)


@pytest.fixture
def stroke_events(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Record the part number and the number of strokes of each stroke event of a run."""
    found: list[tuple[int, int]] = []

    def noting(watch: RunWatch, part: PartRun, event: CycleStrokes, *arguments: Any) -> None:
        found.append((part.number, len(event.begins)))
        strokes(watch, part, event, *arguments)

    strokes = RunWatch.strokes
    monkeypatch.setattr(RunWatch, "strokes", noting)
    return found


def test_a_cycle_is_ground_at_once_when_its_dress_program_is_known(stroke_events: list[tuple[int, int]]) -> None:
    record = run(PLATES, job())
    assert record.parts["strokes"].tolist() == [8, 8]
    assert stroke_events == [(1, 1)] * 8 + [(2, 8)]
    assert record.dresses["after"].tolist() == [3, 11]


def test_a_feed_override_makes_the_machine_step_single_strokes(stroke_events: list[tuple[int, int]]) -> None:
    slow, found = job().control, []
    for percent in (100.0, 50.0):
        slow.override(percent)
        found.append(run(HEAD + CYCLE + "M30\n", job(), control=slow).strokes)
    assert stroke_events == [(1, found[0].size)] + [(1, 1)] * found[1].size
    np.testing.assert_array_equal(found[1]["E"], 0.5 * found[0]["E"])


@pytest.mark.parametrize(("power", "said"), [(1400.0, "the spindle slows to"), (900.0, "the spindle stalls")])
@pytest.mark.parametrize("dress_requests", [(), LONG_AFTER])
def test_the_worst_spindle_load_of_a_cycle_warns_once(
    power: float, said: str, dress_requests: tuple[float, ...]
) -> None:
    shop = job(setup={"machine": replace(CATALOGUE.machine("default"), power_limit=power)})
    control = replace(shop.control, operator_dress_at=dress_requests)
    record = grind(read(HEAD + CYCLE + "M30\n" + DRESS, "test.nc"), shop, control=control)
    torque = record.strokes["torque"]
    assert (torque > 1.01 * shop.parameters.rs).sum() > (torque >= 1.0).sum()
    worst = record.strokes["number"][int(torque.argmax())]
    (warning,) = (each for each in record.warnings if "the spindle s" in each)
    assert warning.startswith(f"test.nc:3: in stroke {worst} {said}")
