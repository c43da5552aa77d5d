"""A script replayed in compiled code against the control that executes the same program event by event."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.job.outline import JobProgramError
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.program_episode import ProgramEpisode
from grind_env.machine.job import Job, Stage, WheelStart
from grind_env.machine.record import GrindingRecord
from grind_env.machine.tally import Tally
from grind_env.process.state import WheelState
from tests.machine.harness import DRESS, job


@dataclasses.dataclass(frozen=True)
class Written:
    """A program of one or more parts, and what is chosen for its blocks."""

    text: str
    choices: tuple[tuple[int, int], ...]


@st.composite
def cycles(draw: st.DrawFn, deepest: int) -> tuple[str, int, int]:
    """A cycle with the motions beside and after it: its text, how many um deep it leads, how many blocks it has."""
    code = draw(st.sampled_from(["G81", "G82", "G82", "G82.1", "G81.1"]))
    depth = deepest + draw(st.integers(0, 60))
    words = f"{code} X{draw(st.sampled_from(['205.', '230.']))} I-{draw(st.sampled_from(['5.', '30.']))}"
    words += f" E{draw(st.integers(3000, 30_000))}. P9100"
    lines = []
    if code.startswith("G82"):
        J, Q = draw(st.integers(4, 20)), draw(st.integers(0, 20))
        words += f" Y-{depth / 1000:.3f} J-{J / 1000:.3f} Q-{Q / 1000:.3f} L{draw(st.integers(0, 3))} F100."
        words += f" D{draw(st.integers(0, 2))}"
        lines.append(words)
    else:
        lines.append(words)
        for _ in range(draw(st.integers(0, 3))):
            depth += draw(st.integers(0, 20))
            lines.append(f"G01 Y-{depth / 1000:.3f} F{draw(st.sampled_from(['.2', '.6', '3.']))}")
            if draw(st.booleans()):
                lines.append(f"G04 X{draw(st.floats(0.01, 4.0)):.2f}")
    if draw(st.integers(0, 3)) == 0:
        lines.append(f"G01 Y-{depth / 1000:.3f} F100.")
        lines.append(f"G04 X{draw(st.floats(0.01, 3.0)):.2f}")
    ending = draw(st.sampled_from(["G80", "G80\nG00 Y20.\nG00 X-30.", "M01", "G80\nM01", ""]))
    return "\n".join([*lines, ending]), depth, 1


@st.composite
def programs(draw: st.DrawFn) -> Written:
    """Parts one after the other, each with cycles that go deeper and deeper."""
    texts, blocks = ["G71 G94 G90 G19"], 0
    parts = draw(st.integers(1, 3))
    for part in range(parts):
        x = draw(st.sampled_from(["-30.", "-5.", "230."])) if part == 0 else draw(st.sampled_from(["-30.", "-5."]))
        texts.append(f"G00 Y20.\nG00 X{x} Z-2.5\nG01 Y{draw(st.sampled_from(['0', '.01']))} F500.")
        depth = 0
        for _ in range(draw(st.integers(1, 3))):
            text, depth, count = draw(cycles(depth))
            texts.append(text)
            blocks += count
        texts.append("G80\nG00 Y20.\n" + ("M30" if part == parts - 1 else "M00"))
    choices = [(draw(st.integers(3000, 30_000)), draw(st.integers(0, 3))) for _ in range(blocks)]
    return Written("\n".join([*texts, DRESS]), tuple(choices))


def shop(**changes: Any) -> Job:
    start = WheelStart(wear_flat_area=0.02, volume_since_dress=50.0)
    return job(wheel_start=start, stock=0.1, **changes)


def executed(simulation: JobSimulation, choices: Sequence[tuple[int, int]]) -> ProgramEpisode:
    episode = ProgramEpisode(simulation.programs, simulation.job)
    for number, choice in enumerate(choices):
        episode.step(simulation.words(number, *choice))
    return episode


def assert_replayed(simulation: JobSimulation, choices: Sequence[tuple[int, int]]) -> GrindingRecord:
    """Replay a program with those words, beside two other machines, and compare with the control's execution."""
    episodes = simulation.start([np.random.default_rng(k) for k in range(3)])
    sums, seconds = np.zeros(len(Tally._fields)), 0.0
    for E, D in choices:
        _, tallies = simulation.step(episodes, np.array([E, 9000.0, E]), np.array([D, 1.0, D], float))
        assert tallies[0].tobytes() == tallies[2].tobytes()
        sums += tallies[0]
        seconds += tallies[0, Tally._fields.index("seconds")]
    total = Tally(*sums.tolist())
    episode = executed(simulation, choices)
    record = episode.run.record()
    assert (total.strokes, total.dresses) == (len(record.strokes), len(record.dresses))
    assert total.seconds == pytest.approx(record.seconds, rel=1e-9)
    assert total.worn == pytest.approx(record.parts["worn"].sum(), rel=1e-9, abs=1e-12)
    assert total.dressed_off == pytest.approx(record.parts["dressed_off"].sum(), rel=1e-9)
    wheel = WheelState(*episodes.wheels[0].tolist())
    assert episode.run.wheel is not None
    for name in WheelState._fields:
        expected = getattr(episode.run.wheel, name)
        assert getattr(wheel, name) == pytest.approx(expected, rel=1e-9, abs=1e-13), name
    last = record.parts[-1]
    assert episodes.parts[0, 1] == pytest.approx(last["S"], rel=1e-9, abs=1e-13)
    assert episodes.parts[0, 2] == pytest.approx(last["Ra"], rel=1e-9)
    return record


@settings(max_examples=60, deadline=None)
@given(written=programs(), staged=st.booleans(), coverage=st.booleans())
def test_a_replay_is_what_the_control_and_the_machine_make_of_the_program(
    written: Written, staged: bool, coverage: bool
) -> None:
    stages = (Stage(stock=0.03, rise_allowance=100.0, tolerance=30.0),) if staged else ()
    try:
        simulation = JobSimulation(read(written.text), shop(stages=stages, tolerance=10.0), 0.0)
    except JobProgramError as error:
        assert "makes no stroke" in str(error)
        return
    if simulation.why is not None:
        assert "turns over the part" in str(simulation.why) or "where the table came to rest" in str(simulation.why)
        return
    assert_replayed(simulation, written.choices)
