"""Programs with counters in common variables, which carry over from run to run, and with jumps."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, CycleStart, execute, read
from grind_env.envs.arguments import TaskError
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobProgramError
from grind_env.envs.job.repeated_program import repeated
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.uncertainty import CERTAIN
from grind_env.machine.script.block_settings import D
from grind_env.shop.optimise.search_problem import variation_of
from grind_env.shop.optimise.word_editing import text_of
from grind_env.shop.python_api import optimise
from grind_env.shop.search_options import options_of
from grind_env.shop.sweep.study import SweepRanges, sweep
from grind_env.shop.trials import LotUse, lots_of, trials_of
from tests.examples import examples
from tests.shop.programs import DRESS, EXAMPLES, JOB, PLATE
from tests.shop.test_optimise import status

pytestmark = pytest.mark.usefixtures("few_lots")

HEAD = "O7\nN10 G71 G94 G90 G19 S1910 M03\nN20 G00 Y2. Z-2.5 M08\nN30 G00 X-30.\nN40 G01 Y0 F500.\n"
TAIL = "N80 G80\nN90 G00 Y20. M09 M05\nN100 M30\n"
ROUGH = "N50 G82 X230. I-30. Y-.17 J-.01 L0 F60. E15000. P9100 {}\n"
FINISH = "N70 G82 Y-.2 J-.005 L4 F60. E9000.\n"
#: program that dresses on every third part by its counter
COUNTING = (
    HEAD
    + "#500=#500+1\n#110=0\nIF [#500 LT 3] GOTO 50\n#500=0\n#110=1\n"
    + ROUGH.format("D#110")
    + FINISH
    + TAIL
    + DRESS
)
EVERY = 3
STEPS = (
    HEAD
    + "#101=0\nN45 #101=#101+1\nN50 G82 X230. I-30. Y[-.05*#101] J-.01 L0 F60. E15000. P9100 D1\n"
    + "IF [#101 LT 3] GOTO 45\nIF [#101 EQ 7] GOTO 80\n"
    + FINISH
    + TAIL
    + DRESS
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("variables")
    for name, text in {"counting": COUNTING, "plate": PLATE}.items():
        (path / f"{name}.nc").write_text(text, encoding="utf-8")
        (path / f"{name}.toml").write_text(JOB, encoding="utf-8")
    return path


def job(variables: Mapping[int, float] = {}) -> Job:
    return replace(load_job(EXAMPLES / "plate_g82.toml"), variables=variables)


def by_hand(text: str, parts: int, variables: Mapping[int, float]) -> Iterator[tuple[float, float, float]]:
    """Yield E, D and depth of each cycle of single runs, each with the common variables of the run before."""
    for _ in range(parts):
        execution = execute(read(text), Control(variables=variables))
        execution.set_wheel_radius(150.0)
        for event in execution:
            if isinstance(event, CycleStart):
                yield event.plan.feed, event.plan.dresses, event.plan.depth_target
        left = execution._interpreter.variables.values
        variables = {number: value for number, value in left.items() if number > 33}


def in_a_batch(text: str, parts: int, variables: Mapping[int, float]) -> list[tuple[float, float, float]]:
    simulation = JobSimulation(repeated(read(text), parts, variables), job(variables), 0.0)
    return [(each.plan.feed, each.plan.dresses, each.plan.depth_target) for each in simulation.blocks]


def test_local_variables_start_every_run_with_the_same_values() -> None:
    text = HEAD + "IF [#1 EQ #0] THEN #1=5\n#1=#1+1\n" + ROUGH.format("D[#1-5]") + TAIL + DRESS
    for held in ({}, {1: 6.0}):
        assert in_a_batch(text, 3, held) == list(by_hand(text, 1, held)) * 3


@st.composite
def jumping(draw: st.DrawFn) -> str:
    """Draw a program that loops by GOTO, skips blocks and may end early, depending on its counters."""
    steps, each = draw(st.integers(1, 3)), draw(st.integers(2, 4))
    early = draw(st.booleans())
    label = draw(st.sampled_from([45, 1, 9000, 99_999]))
    skip = draw(st.sampled_from(["GOTO 70 (GOTO 5)", "goto [70]", "GOTO 0070"]))
    return (
        HEAD
        + f"#500=#500+1\n#101=0\nN{label} #101=#101+1\n"
        + "N50 G82 X230. I-30. Y[-.05*#101] J-.01 L0 F60. E[9000+#500*100] P9100 D1\n"
        + f"IF [#101 LT {steps}] GOTO {label}\nIF [[#500 MOD {each}] NE 0] {skip}\n"
        + ("N60 G80 (M30)\nN61 G00 Y20. M09 M05 M30\n" if early else "N60 G82 Y[-.05*#101-.01] E7000. L2\n")
        + "N70 G82 Y[-.05*#101-.02] E8000. L1\n"
        + TAIL
        + DRESS
    )


@examples(20)
@given(text=jumping(), parts=st.integers(1, 5), start=st.integers(0, 3))
def test_common_variables_carry_over_and_jumps_stay_in_their_run(text: str, parts: int, start: int) -> None:
    held = {500: float(start)}
    events = execute(repeated(read(text), parts, held), Control(variables=held))
    events.set_wheel_radius(150.0)
    plans = [event.plan for event in events if isinstance(event, CycleStart)]
    assert [(plan.feed, plan.dresses, plan.depth_target) for plan in plans] == list(by_hand(text, parts, held))


@examples(8)
@given(text=jumping(), parts=st.integers(1, 5), start=st.integers(0, 3), data=st.data())
def test_varied_words_apply_to_every_run(text: str, parts: int, start: int, data: st.DataObject) -> None:
    shop, lots = replace(job({500: float(start)}), uncertainty=CERTAIN), lots_of(1, LotUse.SEARCH, 2)
    asked = variation_of(
        read(text, "part.nc"), text_of(text.encode()), shop, options_of((*"EDL", "interval"), untried=True), parts, 1
    )
    point = tuple(data.draw(st.integers(0, count - 1)) for count in asked.counts)
    trials = trials_of(read(asked.with_words(point).text, "part.nc"), shop, parts, lots)
    other = asked.settings(asked.base.own, np.array([point]))
    assert trials.own[:, :4] == pytest.approx(other[0, :, :4], rel=1e-9)
    mine, theirs = asked.measure(asked.base.with_lots(lots), [point]), trials.measure(trials.own[None])
    assert theirs.cost == pytest.approx(mine.cost, rel=1e-9)


def test_a_counting_program_costs_the_same_as_written_out() -> None:
    parts, shop = 6, job()
    straight = HEAD + ROUGH.format("D0") + FINISH + TAIL + DRESS
    lines = "\n".join(source.text for source in repeated(read(straight), parts).main.blocks).split("D0")
    written = lines[0] + "".join(f"D{int((k + 1) % EVERY == 0)}{rest}" for k, rest in enumerate(lines[1:]))
    lots = lots_of(1, LotUse.SWEEP, 8)
    twin = trials_of(read(f"{written}\n{DRESS}"), shop, 1, lots)
    trials = trials_of(read(COUNTING), replace(shop, variables={500: 0.0}), parts, lots)
    assert not trials.alike
    assert trials.own[:, D].tolist() == [0, 0, 0, 0, 1, 0] * 2
    mine, theirs = (each.measure(each.own[None]) for each in (trials, twin))
    assert mine.cost.mean() * parts == pytest.approx(theirs.cost.mean() * parts, rel=1e-9)
    assert mine.Ra.mean() == pytest.approx(theirs.Ra.mean(), rel=1e-9)


def test_a_swept_interval_replaces_the_counter_of_the_program(folder: Path) -> None:
    found = sweep(folder / "counting.nc", None, SweepRanges(every=(EVERY, EVERY)), parts=6, variables={500: 0.0})
    assert found.speeds[0].cost.value == pytest.approx(found.own.cost.value, rel=1e-12)


@pytest.mark.nightly
def test_optimise_accepts_a_counting_program(folder: Path) -> None:
    found = optimise(folder / "counting.nc", variables={500: 0.0}, parts=6, budget=1000, bounds={"E": (8000, 20_000)})
    record = grind(read(found.after), job({500: 0.0}))
    assert found.quantity("cost").expected[1] == pytest.approx(record.parts["total_cost"].sum(), rel=1e-9)
    assert {word.place for word in found.words} == {"N50", "N70"}
    assert "N50: D#110 is kept as it is" in " ".join(found.remarks)
    assert not any("#500 was given" in each for each in found.remarks)


def test_dress_intervals_apply_to_runs_with_different_blocks(folder: Path) -> None:
    text = COUNTING.replace(FINISH, "IF [#500 EQ 1] GOTO 80\n" + FINISH)
    (folder / "uneven.nc").write_text(text, encoding="utf-8")
    swept = SweepRanges(every=(1, 3))
    found = sweep(folder / "uneven.nc", folder / "counting.toml", swept, parts=6, variables={500: 0.0}, untried=True)
    one, two, three = (point.seconds for point in found.speeds)
    assert one - two == pytest.approx(3.0 * (two - three), rel=1e-6)
    assert one > two


@pytest.mark.nightly
def test_a_given_variable_that_is_never_read_is_reported(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    plate = folder / "plate.nc"
    told = "#500 was given a value at the start, but nothing has read it; leave it out, or mend its number"
    for words in (["sweep", "--E", "15000..16000"], ["optimise", "--budget", "1s"]):
        status(words[0], plate, *words[1:], "--parts", "2", "--set", "#500=3", "--json")
        assert told in json.loads(capfd.readouterr().out)["remarks"]
    readings = folder / "readings.csv"
    readings.write_text("mean_power\n", encoding="utf-8")
    words = ["--measurements", readings, "--state", folder / "state.json", "--policy", "E12000D0", "--parts", "2"]
    assert status("advise", plate, *words, "--set", "#500=3") == 0
    assert told in capfd.readouterr().err
    with pytest.warns(UserWarning, match=re.escape(told)):
        gym.make("grind/Job-v0", program=str(plate), variables="#500=3")


def test_the_environment_runs_a_counting_program(folder: Path) -> None:
    env = gym.make("grind/Job-v0", program=str(folder / "counting.nc"), parts=4, variables="#500=1, ")
    assert env.spec is not None
    again = gym.make(gym.spec(env.spec.id), **json.loads(json.dumps(env.spec.kwargs)))
    for each in (env, again):
        each.reset(seed=3)
        taken = [each.step(np.array([0.0, 1.0], np.float32))[4]["D"] for _ in range(8)]
        assert taken == [3] * 8
    made = env.unwrapped
    record = grind(read(made.part_program(), "part.nc"), made.written().job)  # type: ignore[attr-defined]
    assert record.strokes.tobytes() == made.record().strokes.tobytes()  # type: ignore[attr-defined]


def test_invalid_variables_are_refused(folder: Path) -> None:
    program = str(folder / "counting.nc")
    with pytest.raises(TaskError, match="must be a text such as '#500=0, #101=15000'"):
        gym.make("grind/Job-v0", program=program, variables={500: 0})
    with pytest.raises(ControlError, match="variables: #500 is no assignment"):
        gym.make("grind/Job-v0", program=program, variables="#500")
    with pytest.raises(ControlError, match="variable #5000 cannot be set at the start"):
        sweep(program, variables={5000: 1.0})
    assert status("sweep", program, "--set", "nothing") == 2
    assert status("optimise", program, "--set", "nothing") == 2
    assert status("advise", program, "--set", "nothing") == 2


def test_an_error_in_a_batch_names_the_line_of_the_file(folder: Path) -> None:
    line = COUNTING.splitlines().index("#500=#500+1") + 1
    with pytest.raises(ControlError, match=rf"counting.nc:{line}:6: #500 has no value"):
        sweep(folder / "counting.nc", parts=5)


def test_a_computed_jump_is_refused_for_several_parts() -> None:
    text = STEPS.replace("GOTO 45", "GOTO [40+5]")
    with pytest.raises(JobProgramError, match=r"GOTO leads to an N number that is worked out.*write the number there"):
        repeated(read(text), 2)
