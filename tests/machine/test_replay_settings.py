"""A script replayed with other E, D, J, L and dresses, against the control on the rewritten program."""

import dataclasses
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.program_episode import Words
from grind_env.errors import GrindError
from grind_env.machine.dress.dress_run import run_dress
from grind_env.machine.dress.mounted_wheel import first_wheel, new_wheel
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import BlockSettings, Ranges
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from grind_env.machine.script.script_tables import tables_of
from grind_env.machine.script.settings_completion import SettingsError
from grind_env.process.stroke_types import WheelState
from tests.examples import examples
from tests.machine.harness import DRESS, job
from tests.machine.test_dress_times import back_and_forth
from tests.machine.test_replay import assert_same, executed, shop

PICKS, SPARK_OUTS = (0.002, 0.026), (0, 4)
GOOD = Outcome._fields.index("good")


@dataclasses.dataclass(frozen=True)
class Chosen:
    """Settings of a block: E in mm/min or 0.1 inch/min, J in um or 0.0001 inch, and a dress (passes, F, um)."""

    E: int
    D: int
    J: int
    L: int
    dress: tuple[int, int, int]

    def words(self, number: int, inch: bool) -> Words:
        """Return the words of the program, with a dress program of their own."""
        E, J = (f"{self.E / 10}", f"-{self.J / 10_000:.4f}") if inch else (f"{self.E}.", f"-{self.J / 1000:.3f}")
        return {"E": E, "D": f"{self.D}", "J": J, "L": f"{self.L}", "P": f"{9200 + number}"}

    def settings(self, words: Words, inch: bool) -> list[float]:
        """Return the settings in the units of `BlockSettings`."""
        E, J = (float(abs(Decimal(words[letter])) * (Decimal("25.4") if inch else 1)) for letter in "EJ")
        passes, feed, depth = self.dress
        return [E, self.D, J, self.L, passes, feed / 60.0, depth / 1000.0, np.nan]


@dataclasses.dataclass(frozen=True)
class Case:
    """Program, and the settings of its blocks on two machines."""

    text: str
    inch: bool
    choices: tuple[tuple[Chosen, ...], tuple[Chosen, ...]]


def choices(inch: bool) -> st.SearchStrategy[Chosen]:
    speeds = st.integers(1500, 11_000) if inch else st.integers(4000, 30_000)
    picks = st.integers(1, 10) if inch else st.integers(2, 26)
    dress = st.tuples(st.integers(1, 4), st.integers(60, 600), st.integers(3, 40))
    return st.builds(Chosen, E=speeds, D=st.integers(0, 3), J=picks, L=st.integers(*SPARK_OUTS), dress=dress)


@st.composite
def cases(draw: st.DrawFn, wide: bool) -> Case:
    """Draw parts with one or two cycles each, the second one deeper, with or without Q."""
    inch = draw(st.booleans())

    def mm(value: float) -> str:
        return f"{value / 25.4:.4f}" if inch else f"{value:.3f}"

    lines, parts = [f"{'G70' if inch else 'G71'} G94 G90 G19"], draw(st.integers(1, 2))
    dresses: list[str] = []  # one per block, because a dress program is measured at its first call
    counts = [draw(st.integers(1, 2)) for _ in range(parts)]
    for part, count in enumerate(counts):
        depth = 0.0
        lines.append(f"G00 Y{mm(20)}\nG00 X{mm(-30)} Z{mm(0 if wide else -2.5)}\nG01 Y{mm(0.01)} F{mm(500)}")
        for number in range(count):
            depth += draw(st.integers(5, 50)) / 1000
            code = draw(st.sampled_from(["G83", "G83.1"] if wide else ["G82", "G82.1"]))
            words = f"{code} X{mm(230)} I{mm(-30)} Y{mm(-depth)} J{mm(-0.01)} L1 E{mm(12_000)} F{mm(1500)}"
            words += f" P{9100 + len(dresses)}"
            dresses.append(f"O{9100 + len(dresses)}\n{back_and_forth(2, 191, 20)}\nM99\n")
            if draw(st.booleans()):
                words += f" Q{mm(-draw(st.integers(0, 15)) / 1000)}"
            if wide:
                words += f" Z{mm(15)} K{mm(draw(st.sampled_from([6.0, 9.2, 15.0])))}"
            lines.append(words)
            if number + 1 < count:
                lines.append(f"G80\n{draw(st.sampled_from(['', 'M01']))}\nG00 X{mm(-30)}{f' Z{mm(0)}' if wide else ''}")
        lines.append(f"G80\nG00 Y{mm(20)}\n{'M30' if part + 1 == parts else 'M00'}")
    chosen = [tuple(draw(choices(inch)) for _ in range(sum(counts))) for _ in range(2)]
    return Case("\n".join([*lines, *dresses]), inch, (chosen[0], chosen[1]))


def check(case: Case, **changes: Any) -> None:
    """Replay three machines, the first and the last with the same choices, and compare with the control."""
    first, other = case.choices
    simulation = JobSimulation(read(case.text), shop(**changes), 0.0, picks=PICKS, spark_outs=SPARK_OUTS)
    assert simulation.why is None
    words = [choice.words(number, case.inch) for number, choice in enumerate(first)]
    bodies = [f"O{9200 + number}\n{back_and_forth(*choice.dress)}\nM99\n" for number, choice in enumerate(first)]
    run = executed(simulation, words, "".join(bodies))
    episodes = simulation.start([np.random.default_rng(k) for k in range(3)])
    # the rewritten program begins with a wheel dressed by its first dress program
    dress = run.dressing.plans[9200]
    episodes.wheels[[0, 2], :OWN_FROM] = first_wheel(simulation.job, dress, simulation.job.parameters)
    sums, good = np.zeros(len(Tally._fields)), 0.0
    for number, (mine, beside) in enumerate(zip(first, other, strict=True)):
        rows = [choice.settings(choice.words(number, case.inch), case.inch) for choice in (mine, beside, mine)]
        table = np.array(rows, np.float64)
        outcomes, tallies = simulation.step(episodes, table[:, 0], table[:, 1], settings=table)
        assert tallies[0].tobytes() == tallies[2].tobytes() and outcomes[0].tobytes() == outcomes[2].tobytes()
        sums, good = sums + tallies[0], good + outcomes[0, GOOD]
    assert_same(simulation, episodes, sums, good, run)


@examples(25)
@given(case=cases(wide=False))
def test_plunges_replayed_with_other_settings_equal_the_rewritten_program(case: Case) -> None:
    check(case, tolerance=10.0)


@examples(20)
@given(case=cases(wide=True))
def test_traverses_replayed_with_other_settings_equal_the_rewritten_program(case: Case) -> None:
    check(case, width=40.0, tolerance=10.0)


PLUNGE = "G82 X230. I-30. Y-.03 J-.01 L1 F1500. E12000. P9100\n"
TRAVERSE = "G83 X230. I-30. Y-.02 J-.02 F1500. E12000. P9100 Z15. K15.\n"
BACK = "G80\nG00 X-30.\n"
G81 = "G81 X230. I-30. E12000.\nG04 X2.\n"


def written(cycles: str) -> str:
    return f"G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z0\nG01 Y0 F500.\n{cycles}G80\nG00 Y20.\nM30\n{DRESS}"


def simulated(cycles: str, **ranges: Any) -> JobSimulation:
    return JobSimulation(read(written(cycles)), shop(), 0.0, **ranges)


@pytest.mark.parametrize(
    ("cycles", "line", "why"),
    [
        (
            PLUNGE.replace("F1500.", "F1.5").replace(" P9100", ""),
            5,
            "in the middle of the stroke after it, one of 0.1 mm",
        ),
        (PLUNGE.replace("F1500.", "F10."), 5, "a dress waits for a pick to end, one of 0.1 mm"),
        (TRAVERSE + BACK + TRAVERSE, 8, "its place depends on where the crossover before came to its end"),
        (TRAVERSE + "G04 X2.\n", 5, "the table strokes on where its crossover came to its end"),
    ],
)
def test_a_script_is_refused_for_pick_ranges_it_cannot_replay(cycles: str, line: int, why: str) -> None:
    programs, wide = read(written(cycles)), job(stock=0.1, width=40.0)
    assert script_of(programs, wide, Ranges(E=(9000.0, 12_000.0))).blocks
    with pytest.raises(ScriptError) as caught:
        script_of(programs, wide, Ranges(E=(9000.0, 12_000.0), J=(0.01, 0.1), L=(0, 3)))
    assert str(caught.value).startswith(f"program:{line}: there is no script of this program: ")
    assert why in str(caught.value)


def test_a_script_has_the_programmed_settings_of_each_block() -> None:
    cycles = PLUNGE + BACK + G81
    script = script_of(read(written(cycles)), job(stock=0.1))
    first, second = (BlockSettings(*row) for row in tables_of(script).own_settings.tolist())
    plan = run_dress(script.programs, 9100, script.job, script.job.control, script.blocks[0].start, 0).plan
    assert first[:4] == (12_000.0, 0.0, 0.01, 1.0) and first[4:] == (2.0, plan.feed, plan.depth, plan.seconds)
    assert second.J == second.L == second.D == 0.0


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"J": 0.03}, "a J of 0.03 mm was chosen, but 0.002 to 0.026 are legal here"),
        ({"J": float("nan")}, "a J of nan mm was chosen"),
        ({"L": 2.5}, "a L of 2.5 was chosen, but whole numbers 0 to 4 are legal here"),
        ({"dress_passes": 0.0}, "a dress of 0 passes was chosen"),
        ({"dress_feed": 0.0}, "a dress feed of 0 mm/s was chosen"),
        ({"dress_depth": 0.2}, "a dress infeed of 0.2 mm was chosen"),
    ],
)
def test_illegal_settings_are_rejected_before_grinding(changes: dict[str, float], why: str) -> None:
    simulation = simulated(PLUNGE, picks=PICKS, spark_outs=SPARK_OUTS)
    episodes = simulation.start([np.random.default_rng(0)] * 2)
    chosen = simulation.own_settings(episodes)
    chosen[1] = BlockSettings(*chosen[1].tolist())._replace(**changes)
    with pytest.raises(SettingsError, match="program:5: ") as caught:
        simulation.step(episodes, chosen[:, 0], chosen[:, 1], settings=chosen)
    assert why in str(caught.value) and (episodes.block == 0).all()


def test_a_word_without_a_range_cannot_be_changed() -> None:
    simulation = simulated(PLUNGE)
    episodes = simulation.start([np.random.default_rng(0)])
    chosen = simulation.own_settings(episodes)
    chosen[0] = BlockSettings(*chosen[0].tolist())._replace(J=0.005)
    with pytest.raises(SettingsError, match=r"a J of 0\.005 mm was chosen, but only that of the block is legal here"):
        simulation.step(episodes, chosen[:, 0], chosen[:, 1], settings=chosen)


def test_a_g81_block_ignores_plunge_and_dress_settings() -> None:
    simulation = simulated(G81, picks=PICKS, spark_outs=SPARK_OUTS)
    both = simulation.start([np.random.default_rng(k) for k in range(2)])
    chosen = simulation.own_settings(both)
    chosen[1] = BlockSettings(12_000.0, 2.0, 0.02, 3.0, 4.0, 2.0, 0.01, 5.0)
    outcomes, tallies = simulation.step(both, chosen[:, 0], chosen[:, 1], settings=chosen)
    assert outcomes[0].tobytes() == outcomes[1].tobytes() and tallies[0].tobytes() == tallies[1].tobytes()


def test_a_program_without_a_script_takes_settings_of_E_and_D_only() -> None:
    simulation = simulated(PLUNGE.replace("F1500.", "F3."), picks=(0.01, 0.1))
    assert simulation.why is not None
    episodes = simulation.start([np.random.default_rng(0)])
    chosen = simulation.own_settings(episodes)
    with pytest.raises(
        GrindError, match="J, L and dress settings can be chosen in programs with a script only: program:5: "
    ):
        simulation.step(episodes, chosen[:, 0], chosen[:, 1], settings=chosen)


def test_programmed_settings_give_the_same_bits_as_no_settings() -> None:
    simulation = simulated(PLUNGE + BACK + PLUNGE.replace(".03", ".05"), picks=PICKS, spark_outs=SPARK_OUTS)
    plain, chosen = (simulation.start([np.random.default_rng(k) for k in range(5)]) for _ in range(2))
    for _ in simulation.blocks:
        own = simulation.own_settings(chosen)
        found = simulation.step(chosen, own[:, 0], np.full(5, 2.0), settings=own)
        for mine, expected in zip(found, simulation.step(plain, own[:, 0], np.full(5, 2.0)), strict=True):
            assert mine.tobytes() == expected.tobytes()
    assert chosen.wheels.tobytes() == plain.wheels.tobytes()


def test_handover_is_priced_with_the_programmed_dress() -> None:
    simulation = simulated(PLUNGE, picks=PICKS, spark_outs=SPARK_OUTS)
    episodes = simulation.start([np.random.default_rng(0)] * 2)
    chosen = simulation.own_settings(episodes)
    chosen[1] = BlockSettings(*chosen[1].tolist())._replace(dress_passes=1.0, dress_depth=0.001, dress_feed=9.0)
    outcomes, _ = simulation.step(episodes, chosen[:, 0], np.zeros(2), settings=chosen)
    prices = outcomes[:, Outcome._fields.index("handover_cost")]
    assert prices[0] == prices[1] > 0.0


def test_a_new_wheel_has_the_dress_settings_of_the_block_that_changed_it() -> None:
    worn = job(stock=0.1, setup={"wheel": dataclasses.replace(job().setup.wheel, minimum_diameter=299.999)})
    worn = dataclasses.replace(worn, times=dataclasses.replace(worn.times, wheel_change=600.0))
    simulation = JobSimulation(read(written(PLUNGE)), worn, 0.0)
    episodes = simulation.start([np.random.default_rng(0)] * 2)
    chosen = simulation.own_settings(episodes)
    chosen[1] = BlockSettings(*chosen[1].tolist())._replace(dress_depth=0.04)
    simulation.step(episodes, chosen[:, 0], np.ones(2), settings=chosen)
    programs = read(f"M30\nO9100\n{back_and_forth(2, 191, 40)}\nM99\n")
    dress = run_dress(programs, 9100, worn, worn.control, (0.0, 0.0, 0.0), 0).plan
    wheels = [WheelState(*row) for row in episodes.wheels[:, :OWN_FROM].tolist()]
    assert all(wheel.ds == worn.setup.wheel.diameter for wheel in wheels)
    expected = new_wheel(worn, wheels[1], dress, worn.parameters)
    assert wheels[1].Rd == pytest.approx(expected.Rd, rel=1e-12) and wheels[0].Rd != wheels[1].Rd
