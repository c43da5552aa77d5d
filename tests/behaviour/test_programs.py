"""Programs behave as recorded, and the records contain every word, dress, stage, stop and interrupt."""

import functools
import re
from typing import Any

import numpy as np
import pytest

from grind_env.control import CycleStrokes, Instant, Motion, Source
from grind_env.control.modes import ACTIONS, CYCLES, SWITCHES
from tests.behaviour.programs import TOLERANCES, programs, recorded
from tests.behaviour.tables import additions, changes, load

pytestmark = pytest.mark.bits

#: codes with a meaning to the control
M_CODES = {"M00", "M01", "M02", "M30", "M98", "M99", "M800", "M801", "M900", "M901", "M902", "M903", "M904"}


record_of = functools.cache(load)


@pytest.mark.parametrize("name", programs())
def test_a_program_behaves_as_recorded(name: str) -> None:
    was, now = record_of(name), recorded(name)
    moved = changes(was, now, TOLERANCES.get(name, 0.0))
    if name in ("plunge", "grooving_wheel"):  # new columns have to be recorded, too
        moved += additions(was, now)
    assert not moved, "\n".join([f"{name} does not do what was recorded (python -m tests.behaviour.record):", *moved])


def tables_of(part: str) -> list[Any]:
    return [rows for name in programs() for title, rows in record_of(name).items() if title.endswith(part)]


def seen(event: str, column: str) -> set[Any]:
    """Return the values of a column in all events with that name."""
    found: set[Any] = set()
    for events in tables_of("events"):
        if column in (events.dtype.names or ()):
            found |= set(events[column][events["event"] == event].tolist())
    return found


def test_every_code_occurs_in_a_program() -> None:
    text = "\n".join(re.sub(r"\(.*?\)", "", path.read_text(encoding="utf-8")) for path in programs().values())
    assert set(re.findall(r"[G][0-9.]+(?![0-9.])", text)) >= {*ACTIONS, *SWITCHES}
    assert set(re.findall(r"M[0-9]+", text)) >= M_CODES


def test_the_records_contain_every_cycle() -> None:
    found = set()
    for events in tables_of("events"):
        starts = events[events["event"] == "CycleStart"]
        if starts.size:
            found |= {f"{row['plan.code']}{'.1' * bool(row['plan.pre_dress'])}" for row in starts}
    assert found == set(CYCLES)
    assert seen("Infeed", "axis") == {0.0, 2.0}  # G77 and G76


def test_the_records_contain_every_kind_of_dress_interrupt_hold_and_stop() -> None:
    assert seen("DressStart", "cause") == {"pre", "auto", "operator"}
    assert seen("InterruptStart", "kind") == {"1", "2"}
    assert seen("Hold", "cause") == {"feedhold", "override", "single block"}
    assert seen("ProgramStop", "code") == {"M00", "M01"}
    assert seen("ProgramEnd", "cause") == {"M02", "M30", "text end"}


def test_the_records_contain_every_kind_of_event_and_every_source_of_a_motion() -> None:
    kinds = {kind.__name__ for kind in (CycleStrokes, *Instant.__subclasses__(), *Motion.__subclasses__())}
    assert set().union(*(events["event"].tolist() for events in tables_of("events"))) == kinds
    sources = set().union(*(events["source"].tolist() for events in tables_of("events"))) - {""}
    assert sources == {source.value for source in Source}


def test_the_records_contain_stages_several_parts_new_wheels_and_grooves() -> None:
    results, strokes = tables_of("result"), tables_of("strokes")
    assert {float(rows["exit status"][0]) for rows in results if "exit status" in rows.dtype.names} == {0.0, 1.0}
    stages = {row for rows in results for row in rows[0].tolist() if isinstance(row, str) and "in stage" in row}
    assert {text.rpartition(" ")[2] for text in stages} == {"1", "2"}
    assert max(rows["part"].max() for rows in strokes) == 3.0
    assert any((np.diff(rows["ds"]) > 0.0).any() for rows in strokes)
    assert any((rows["groove"] > 0.0).any() and (rows["ae"] > 0.0).any() for rows in strokes)
