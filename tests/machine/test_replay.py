"""A script replayed in compiled code against the control that executes the same program event by event."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from grind_env.array_types import Array
from grind_env.control import read
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.repeated_program import with_words_chosen
from grind_env.envs.program_episode import Words
from grind_env.machine.job import Job, Stage, WheelStart
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.record import GrindingRecord
from grind_env.process.stroke_types import WheelState
from tests.machine.harness import DRESS, job, machine_after

START = WheelStart(wear_flat_area=0.02, volume_since_dress=50.0)


def shop(**changes: Any) -> Job:
    return job(wheel_start=START, stock=0.1, **changes)


def executed(simulation: JobSimulation, words: Sequence[Words], dresses: str = "") -> GrindingRun:
    """Return the machine after the program with these words, executed stroke by stroke.

    `dresses` is the text of dress programs that the words name and the file lacks.
    """
    chosen = zip((block.block for block in simulation.blocks), words, strict=True)
    programs = read(with_words_chosen(simulation.programs, list(chosen)) + dresses)
    assert not simulation.job.control.whole_cycles
    return machine_after(programs, simulation.job)


def assert_replayed(
    simulation: JobSimulation, choices: Sequence[tuple[float, int]], run: GrindingRun | None = None
) -> GrindingRecord:
    """Replay a program with these E and D beside two other machines and compare it with the control."""
    episodes = simulation.start([np.random.default_rng(k) for k in range(3)])
    sums, good = np.zeros(len(Tally._fields)), 0.0
    for E, D in choices:
        outcomes, tallies = simulation.step(episodes, np.array([E, 9000.0, E]), np.array([D, 1.0, D], float))
        assert tallies[0].tobytes() == tallies[2].tobytes()
        sums += tallies[0]
        good += outcomes[0, Outcome._fields.index("good")]
    run = run or executed(simulation, [simulation.words(number, *choice) for number, choice in enumerate(choices)])
    return assert_same(simulation, episodes, sums, good, run)


def assert_same(
    simulation: JobSimulation, episodes: Episodes, sums: Array, good: float, run: GrindingRun
) -> GrindingRecord:
    """Assert that the first episode, with summed tallies `sums` and survivals `good`, equals its run."""
    total, record = Tally(*sums.tolist()), run.record()
    assert (total.strokes, total.dresses) == (len(record.strokes), len(record.dresses))
    assert total.seconds == pytest.approx(record.seconds, rel=1e-9)
    assert total.worn == pytest.approx(record.parts["worn"].sum(), rel=1e-9, abs=1e-12)
    assert total.dressed_off == pytest.approx(record.parts["dressed_off"].sum(), rel=1e-9)
    wheel = WheelState(*episodes.wheels[0, :OWN_FROM].tolist())
    assert run.wheel is not None
    for name in set(WheelState._fields) - {"W"}:  # the wear is known from the last stop on
        expected = getattr(run.wheel, name)
        assert getattr(wheel, name) == pytest.approx(expected, rel=1e-9, abs=1e-13), name
    assert episodes.wheels[0, OWN_FROM:] == pytest.approx(run.mount.own[0], rel=1e-9, abs=1e-13)
    last = record.parts[-1]
    stock = simulation.job.part.stock
    assert 1000.0 * (stock - episodes.parts[0, 1]) == pytest.approx(last["worst_error"], rel=1e-9, abs=1e-9)
    assert episodes.parts[0, 2] == pytest.approx(last["Ra"], rel=1e-9)
    assert good == pytest.approx(record.parts["survival"].sum(), rel=1e-9, abs=1e-12)
    return record


def test_a_stop_after_the_unloading_ends_no_stage() -> None:
    part = "G00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\nG82 X230. I-30. Y-.03 J-.01 F100. E9000.\nG80\nG00 Y20.\n"
    text = f"G71 G94 G90 G19\n{part}M00\nM01\n{part}M30{DRESS}"
    stage = Stage(stock=0.03, tolerance=30.0)
    simulation = JobSimulation(read(text), shop(stages=(stage,), tolerance=60.0), 0.0)
    assert simulation.why is None
    record = assert_replayed(simulation, [(9000, 0)] * 2)
    assert (record.parts["earlier"] == 1.0).all() and (record.parts["survival"] < 0.1).all()


def test_the_limits_of_a_stage_decide_which_heat_of_its_blocks_counts() -> None:
    rough, fine = "G82 X230. I-30. Y-.04 J-.04 F100. E20000.", "G82 X230. I-30. Y-.1 J-.001 F100. E20000."
    last = "G00 Y0\nG00 X-30.\nG01 Y-.1 F100.\nG82 X230. I-30. Y-.12 J-.001 F100. E20000."
    begins = "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500."
    text = f"{begins}\n{rough}\n{fine}\nG80\nM01\n{last}\nG80\nG00 Y20.\nM30{DRESS}"
    for stage, good in ((Stage(stock=0.1), True), (Stage(stock=0.1, rise_allowance=1.0), False)):
        staged = job(wheel_start=START, stock=0.12, stages=(stage,), rise_allowance=1.0)
        simulation = JobSimulation(read(text), staged, 0.0)
        assert simulation.why is None
        record = assert_replayed(simulation, [(20000, 0)] * 3)
        assert (record.parts["survival"] > 0.5).all() == good


@pytest.mark.parametrize("code", ["G83", "G83.1"])
def test_a_crossover_of_a_covered_part_makes_its_cross_picks(code: str) -> None:
    words = f"{code} X230. I-30. Y-.02 J-.01 Z0 K1. L1 F1500. E12000. P9100 D1"
    text = f"G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n{words}\nG80\nG00 Y20.\nM30{DRESS}"
    simulation = JobSimulation(read(text), shop(width=20.0), 0.0)
    assert simulation.why is None and len(simulation.tables.zones) == 1
    record = assert_replayed(simulation, [(9000, 2)])
    assert len(record.strokes) == 1 + 3 * 4


def written_by_hand(*lines: str, z: str = "-2.5") -> str:
    return "\n".join(["G71 G94 G90 G19", "G00 Y20.", f"G00 X-30. Z{z}", "G01 Y0 F500.", *lines, DRESS])


PLUNGE = "G82 X230. I-30. Y-.03 J-.01 L1 F100. E12000. P9100"
TRAVERSE = "G83 X230. I-30. Y-.02 J-.02 L0 F1500. E12000. P9100 Z15. K15. R15."
RETURN = ("G01 Y-.016 Z-18. F300.", "G00 Y.984", "G04 X.5", "G01 Y-.016 F3.")
END = ("G80", "G00 Y20.", "M30")
UNTOUCHED = ("G80", "G00 Y20.", "M00", "G00 X-30.", "G01 Y0 F500.", "G81 X230. I-30. E12000.")
ODD: dict[str, tuple[str, dict[str, float]]] = {
    "a traverse that is taken over ends where its last stroke was": (
        written_by_hand(TRAVERSE, PLUNGE.replace(" P9100", ""), *END, z="0"),
        {"width": 40.0},
    ),
    "a stroke back at the old depth is no plunge": (
        written_by_hand("G82 X230. I-30. Y-.016 J-.004 L2 F100. E30000. P9100", *RETURN, *END),
        {"rise_allowance": 0.1},
    ),
    "a part that no stroke reaches is scrap": (written_by_hand(PLUNGE, *UNTOUCHED, *END), {}),
}


@pytest.mark.parametrize(("text", "changes"), ODD.values(), ids=list(ODD))
def test_odd_programs_are_replayed_as_they_are_executed(text: str, changes: dict[str, float]) -> None:
    simulation = JobSimulation(read(text), job(stock=0.03, **changes), 0.0)
    assert simulation.why is None
    assert_replayed(simulation, [(9000, 0)] * len(simulation.blocks))


def test_a_table_that_rests_at_an_end_of_the_last_cycle_has_no_script() -> None:
    text = written_by_hand(PLUNGE, "G81 X230. I-5. E12000.", "G80", "G00 X-30.", "G00 Y20.", "M30")
    assert "where the cycle before has left it" in str(JobSimulation(read(text), job(stock=0.03), 0.0).why)
