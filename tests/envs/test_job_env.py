from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.control import read, read_file
from grind_env.envs.env import GrindEnv
from grind_env.envs.ids import job as job_env
from grind_env.envs.job import job_simulation as job_simulation
from grind_env.envs.job.program_outline import JobChoice, outline_of_runs
from grind_env.envs.program_episode import PassageError
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script.block_settings import Ranges
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from tests.envs.harness import job_drawn, refusal, reward_terms_of, tape_of_job
from tests.examples import examples
from tests.machine.harness import DRESS

ID = "grind/Job-v0"
EXAMPLES = Path(grind_env.__file__).parent / "examples"
NAMES = ["keyway_g81", "plate_g82", "rail_g83"]
PLATE = """G00 X-30. Y0 Z0
G82 X230. I-30. Y-.05 J-.01 L0 F60. E15000. P9100 D1
M01
G82 Y-.06 J-.005 L2 E9000.
G80
G00 Y20.
"""
BATCH = f"G71 G94 G90 G19 S1910 M03 M08\nG00 Y20.\n{PLATE}M00\n{PLATE}M00\n{PLATE}M30\n{DRESS}"
JOB = """[part]
material = "aisi_52100"
length = 200
width = 20
height = 20
stock = 0.06
roughness_limit = 0.5
tolerance = 9
scrap_cost = 40
"""
NESTED = "G71 G94 G90 G19 S1910 M03 M08\nM98 P11\nM30\n" + "".join(f"O{n}\nM98 P{n + 1}\nM99\n" for n in (11, 12, 13))
NESTED += "O14\n" + PLATE.replace("D1", "") + f"M99\n{DRESS}"
CALLED_3000_TIMES = (
    "G71 G94 G90 G19 S1910 M03 M08\n" + 4 * "M98 P2 L750\n" + f"M30\nO2\nG00 Y20.\n{PLATE}M00\nM99\n{DRESS}"
)
GROOVED = (
    "G71 G94 G90 G18 S1910 M03 M08\nG00 X1. Z0\n"
    f"G77 X-1. Z-50. I.7 K40. D0 F6.\nM00\nG19\nG00 X-30. Y20.\n{PLATE}M00\n{PLATE}M30\n{DRESS}"
)
FREE = (
    JOB.replace("scrap_cost = 40", "scrap_cost = 0")
    + """[setup]
wheel_overrides = { price = 0 }
dresser_overrides = { cost_per_dress = 0 }
machine_overrides = { hourly_rate = 0 }
"""
)


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a program of three parts with two blocks each."""
    return written(tmp_path_factory.mktemp("batch"), BATCH)


def written(folder: Path, program: str, job: str = JOB) -> str:
    path = folder / "part.nc"
    path.write_text(program)
    path.with_suffix(".toml").write_text(job)
    return str(path)


def example(name: str) -> str:
    return str(EXAMPLES / f"{name}.nc")


def play(env: GrindEnv, policy_seed: int, seed: int | None = 0) -> list[dict[str, Any]]:
    """Play an episode with uniform actions; return its infos."""
    rng = np.random.default_rng(policy_seed)
    env.reset(seed=seed)
    infos, terminated = [], False
    while not terminated:
        _, reward, terminated, truncated, info = env.step(rng.uniform(-1, 1, 2).astype(np.float32))
        assert not truncated
        assert reward == pytest.approx(sum(reward_terms_of(info).values()), rel=1e-12)
        infos.append(info)
    return infos


def assert_same_record(a: GrindingRecord, b: GrindingRecord) -> None:
    for name in ("strokes", "dresses", "parts"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes(), name


def assert_infos_match_record(env: GrindEnv, infos: list[dict[str, Any]]) -> GrindingRecord:
    """Compare the infos with costs, seconds and good parts of the record; return the record."""
    record = env.record()
    handover = -infos[-1]["reward_handover"] * env.task.reference_cost
    cost = sum(info["block_cost"] for info in infos)
    assert cost == pytest.approx(record.parts["total_cost"].sum() + handover, rel=1e-9)
    assert sum(info["seconds"] for info in infos) == pytest.approx(record.seconds, rel=1e-9)
    assert sum(info["good_parts"] for info in infos) == pytest.approx(record.parts["survival"].sum(), rel=1e-9)
    return record


# --- the environment is the program ------------------------------------------------------------------


@examples(25)
@given(name=st.sampled_from([*NAMES, "batch"]), seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000))
def test_the_program_of_an_episode_grinds_the_same_record(batch: str, name: str, seed: int, policy_seed: int) -> None:
    env = job_env.make(batch if name == "batch" else example(name), info="full")
    infos = play(env, policy_seed, seed)
    record = assert_infos_match_record(env, infos)
    assert_same_record(grind(read(env.part_program(), "part.nc"), env.written().job), record)
    assert record.dresses.size == sum(info["D"] for info in infos)
    scrap = record.parts.size - record.parts["survival"].sum()
    assert sum(info["cost"] for info in infos) == pytest.approx(scrap, rel=1e-9, abs=1e-12)


def test_the_first_step_includes_a_part_finished_before_the_first_cycle_block(tmp_path: Path) -> None:
    env = job_env.make(written(tmp_path, GROOVED), info="full")
    infos = play(env, 0)
    record = assert_infos_match_record(env, infos)
    assert record.parts.size == 3 and record.parts["scrap_cost"][0] == pytest.approx(40.0)
    assert infos[0]["cost"] == pytest.approx(1.0) and infos[0]["good_parts"] == 0.0
    assert [block.depth for block in env.simulation.blocks] == pytest.approx([0.05, 0.01, 0.05, 0.01])
    # a turning tool makes the groove: the readings of the first plate are those without a groove
    views = []
    for text in (GROOVED, f"G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y20.\n{PLATE}M00\n{PLATE}M30\n{DRESS}"):
        each = job_env.make(written(tmp_path, text), spread=0.0)
        each.reset(seed=0)
        views.append(seen(each, each.step(np.zeros(2, np.float32))[0]))
    for name in ("mean_power", "first_power", "peak_power", "last_pick", "volume", "dresses"):
        assert views[0][name] == pytest.approx(views[1][name], rel=1e-6), name


@pytest.mark.parametrize("name", ["plate_g82", "rail_g83"])
def test_the_programmed_E_and_D_earn_minus_one_per_block_on_nominal_parts(name: str) -> None:
    env = job_env.make(example(name), spread=0.0)
    env.reset(seed=1)
    rewards = []
    for block in env.simulation.blocks:
        action = env.codec.encode(block.plan.feed, block.plan.dresses)[0]
        rewards.append(env.step(action)[1])
    assert sum(rewards) == pytest.approx(-len(rewards), rel=1e-9)
    assert_same_record(grind(read_file(example(name)), env.simulation.job), env.record())


def test_the_chosen_E_and_D_are_written_into_their_block() -> None:
    env = job_env.make(example("plate_g82"), show_block=True)
    env.reset(seed=0)
    info = env.step(env.codec.encode(7000.0, 3)[0])[4]
    assert info["block"] == "N50 G82 X230. I-30. Y-.17 J-.01 L0 F60. E7000. P9100 D3"
    text = (EXAMPLES / "plate_g82.nc").read_text()
    # the finish block has not been run and keeps its words
    assert env.part_program() == text.replace("E15000. P9100 D1", "E7000. P9100 D3")
    assert (info["E"], info["D"]) == (7000.0, 3.0)


def test_a_program_in_inches_gets_E_in_inches(tmp_path: Path) -> None:
    cycle = "G82 X9. I-1.2 Y-.002 J-.0004 L1 F2.4 E472. P9100\nM30\n"
    env = job_env.make(
        written(tmp_path, "G70 G94 G90 G19 S1910 M03 M08\nG00 X-1.2 Y0 Z0\n" + cycle + DRESS), show_block=True
    )
    env.reset(seed=0)
    info = env.step(env.codec.encode(12_700.0, 1)[0])[4]
    assert "E500.0000" in info["block"]
    assert info["E"] == 12_700.0
    assert (env.record().strokes["E"] == 12_700.0).all()
    assert env.record().dresses.size == 1


def test_a_block_without_dresses_gets_no_D_word(tmp_path: Path) -> None:
    cycle = "G82 X230. I-30. Y-.05 J-.01 L1 F60. E9000."
    env = job_env.make(
        written(tmp_path, f"G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y0 Z0\n{cycle}\nM30\n"), show_block=True
    )
    for each in (env, job_env.make(example("keyway_g81"), show_block=True)):
        each.reset(seed=0)
        info = each.step(np.array([0.0, 1.0]))[4]
        assert info["D"] == 0.0 and " D" not in info["block"]
        assert not each.simulation.blocks[0].takes_dresses


def test_a_subprogram_run_with_different_words_has_no_part_program(tmp_path: Path) -> None:
    text = f"G71 G94 G90 G19 S1910 M03 M08\nM98 P50 L2\nM30\nO50\n{PLATE}M00\nM99\n{DRESS}"
    env = job_env.make(written(tmp_path, text))
    assert len(env.simulation.blocks) == 4
    env.reset(seed=0)
    for speed in (5000.0, 9000.0, 5000.0, 9000.0):
        env.step(env.codec.encode(speed, 1)[0])
    assert env.part_program().count("E5000.") == 1
    env.reset(seed=0)
    for speed in (5000.0, 9000.0, 6000.0, 9000.0):
        env.step(env.codec.encode(speed, 1)[0])
    assert "part.nc:6" in refusal(GrindError, env.part_program)


def test_a_cycle_block_in_another_file_has_no_part_program(tmp_path: Path) -> None:
    (tmp_path / "O50.nc").write_text(f"{PLATE}M99\n{DRESS}")
    env = job_env.make(written(tmp_path, "G71 G94 G90 G19 S1910 M03 M08\nM98 P50\nM30\n"))
    play(env, 0)
    assert "O50.nc:2" in refusal(GrindError, env.part_program)


# --- observations -------------------------------------------------------------------------------------


def seen(env: GrindEnv, observation: Any) -> dict[str, float]:
    return {e.name: float(e.offset + e.scale * v) for e, v in zip(env.observation_info(), observation, strict=True)}


def test_exact_gauges_show_the_values_of_the_record(batch: str) -> None:
    env = job_env.make(batch, spread=0.0)
    observation, _ = env.reset(seed=0)
    assert seen(env, observation)["remaining"] == 1.0
    views = []
    for executions in (1, 0, 0, 2, 0, 0):
        views.append(seen(env, env.step(env.codec.encode(10_000.0, executions)[0])[0]))
    strokes, parts = env.record().strokes, env.record().parts
    # rough: 5 picks and a coverage stroke, the dress after pick 3, so that strokes 2 to 6 are plunges
    rough = strokes[:6]
    assert rough["Z"] == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.04, 0.05], abs=1e-12)
    assert views[0]["first_power"] == pytest.approx(rough["power"][1:6].mean(), rel=1e-6)
    assert views[0]["mean_power"] == pytest.approx(rough["power"][3:6].mean(), rel=1e-6)
    assert views[0]["peak_power"] == pytest.approx(rough["power"].max(), rel=1e-6)
    assert views[0]["volume"] == pytest.approx(0.03 * 200.0, rel=1e-6)
    assert views[1]["volume"] == pytest.approx(0.04 * 200.0, rel=1e-6)
    assert [view["blocks_since_dress"] for view in views] == pytest.approx([0, 1, 2, 0, 1, 2])
    assert [view["dresses"] for view in views] == pytest.approx([1, 1, 1, 3, 3, 3])
    errors = [view["size_error"] for view in views]
    expected = [0.0, *parts["size_error"][[0, 0, 1, 1, 2]]]
    assert errors == pytest.approx(expected, abs=1e-4)
    # the roughness of the first part is known when the second one is finished
    assert [view["roughness"] for view in views[:3]] == [0.0, 0.0, 0.0]
    assert views[3]["roughness"] == pytest.approx(parts["Ra"][0] / 0.5, rel=1e-6)
    assert [view["starts_part"] for view in views] == pytest.approx([0, 1, 0, 1, 0, 0])
    assert [view["depth"] for view in views] == pytest.approx([0.01, 0.05, 0.01, 0.05, 0.01, 0.0], abs=1e-7)
    assert [view["remaining"] for view in views] == pytest.approx(np.arange(5, -1, -1) / 6.0)
    assert views[-1]["diameter"] == pytest.approx(strokes["ds"][-1], rel=1e-5)


def test_a_noisy_gauge_is_off_by_its_noise(batch: str) -> None:
    exact, noisy = job_env.make(batch, spread=0.0), job_env.make(batch)
    action = np.zeros(2, np.float32)
    exact.reset(seed=3)
    noisy.reset(seed=3)
    view = seen(noisy, noisy.step(action)[0])
    power = noisy.record().strokes["power"].max()
    z = tape_of_job(noisy).noise[0, 2]
    assert view["peak_power"] == pytest.approx(power * (1.0 + 0.03 * z) + 20.0 * z, rel=1e-5)
    assert abs(z) > 1e-3
    assert seen(exact, exact.step(action)[0])["peak_power"] != pytest.approx(view["peak_power"], rel=1e-3)


def test_the_full_observation_shows_the_state_of_wheel_and_lot(batch: str) -> None:
    env = job_env.make(batch, observation="full")
    fresh = seen(env, env.reset(seed=2)[0])
    assert fresh["growth"] == pytest.approx(tape_of_job(env).conditions[0].factors["kA"], rel=1e-5)
    view = seen(env, env.step(np.zeros(2, np.float32))[0])
    last = env.record().strokes[-1]
    assert view["wear_flat"] == pytest.approx(last["A"], rel=1e-5)
    assert view["wheel_volume"] == pytest.approx(last["V"], rel=1e-5)
    assert fresh["wear_flat"] < view["wear_flat"]


def test_everything_random_is_drawn_at_reset(batch: str) -> None:
    envs = [job_env.make(batch) for _ in range(2)]
    for policy_seed, env in enumerate(envs):
        play(env, policy_seed, seed=5)
    first, second = (tape_of_job(env) for env in envs)
    assert first is not None and second is not None
    assert first.conditions == second.conditions
    assert first.noise.tobytes() == second.noise.tobytes()
    assert first.new_lot[0]
    factors = [envs[0].np_random.random() for _ in range(2)]
    assert factors[0] != factors[1]


def test_lots_come_with_their_probability_and_last_until_the_next() -> None:
    tape = job_drawn(np.random.default_rng(0), 6000, 1.0)
    assert np.mean(tape.new_lot) == pytest.approx(1.0 / 6.0, abs=0.02)
    growth = np.array([condition.factors["kA"] for condition in tape.conditions])
    changes, begins = np.diff(growth) != 0.0, np.array(tape.new_lot[1:])
    assert not changes[~begins].any()
    # two lots in a row may both be cut at 1.8 sigma, on the same side
    assert changes[begins].mean() > 0.99
    logs = np.log(growth[np.array(tape.new_lot)])
    # a normal distribution cut at 1.8 sigma has 0.93 of its standard deviation
    assert logs.std() == pytest.approx(0.93 * 0.45, rel=0.06)
    nominal = job_drawn(np.random.default_rng(0), 60, 0.0)
    assert all(set(condition.factors.values()) == {1.0} for condition in nominal.conditions)
    assert nominal.new_lot == (True, *[False] * 59)
    assert (nominal.noise == 0.0).all()


# --- refused programs and jobs ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "job", "part"),
    [
        ("G71 G94 G90 G19 S1910 M03 M08\nG01 Y5. F100.\nM30\n", JOB, "no stroke"),
        ("G71\nG82 X1. Q\nM30\n", JOB, "part.nc:2"),
        (BATCH, JOB.replace("length = 200\n", ""), "part.length is missing"),
        (BATCH.replace("35. F191.", "3. F191.").replace("P9100 D1", "P9100"), JOB, "O9100"),
        # only a dress would be one level too deep
        (NESTED, JOB, "nest at most 4 levels"),
        (BATCH.replace("M30", "M99"), JOB, "a second time; end it with M30"),
        (CALLED_3000_TIMES, JOB, "more than 2000 cycle blocks"),
        (BATCH, FREE, "costs nothing"),
        ("G71 G94 G90 G18\nG00 X30. Z0\nG77 X24. Z-50. I.7 K40. D0 F6.\nM30\n", JOB, "no cycle block"),
    ],
)
def test_a_faulty_program_or_job_is_refused_when_the_environment_is_made(
    tmp_path: Path, program: str, job: str, part: str
) -> None:
    assert part in refusal(GrindError, job_env.make, written(tmp_path, program, job))


def test_a_program_without_a_script_is_tried_with_the_extremes_of_E_and_D(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[JobChoice] = []

    def noted(programs: Any, job: Any, trials: Any, between: Any) -> Any:
        tried.extend(trials)
        return outline_of_runs(programs, job, trials, between)

    monkeypatch.setattr(job_simulation, "outline_of_runs", noted)
    assert job_env.make().simulation.why is None and not tried
    env = job_env.make(written(tmp_path, GROOVED))
    assert "part.nc:3: there is no script of this program" in str(env.simulation.why)
    assert {(3000.0, 3), (30_000.0, 0), (30_000.0, 3)} <= set(tried)
    assert (env.codec.low, env.codec.high) == (3000.0, 30_000.0)


def looped(assigned: str, executions: int) -> str:
    """Return a program with a loop and a dress program that assigns a variable."""
    loop = (
        f"#1=0\n#2=0\nWHILE[#1 LT 3]DO1\nN50 G82 X230. I-30. Y-[.03+#1*.03] J-.01 L0 F60. E15000. P9100 D{executions}\n"
        "G80\nG00 X-30.\n#1=#1+1\nEND1\nG80\nG00 Y20.\nM30\n"
    )
    dress = DRESS.replace("M99", f"{assigned}\nM99")
    return f"G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y0 Z-2.5\n{loop}{dress}"


@pytest.mark.parametrize("executions", [0, 1])
@pytest.mark.parametrize("assigned", ["#1=#1+1", "#1=5", "#1=#1+.5"])
def test_a_program_is_refused_if_a_dress_decides_which_blocks_run(
    tmp_path: Path, assigned: str, executions: int
) -> None:
    path = written(tmp_path, looped(assigned, executions))
    programs, job = read_file(path), load_job(Path(path).with_suffix(".toml"))
    said = refusal(ScriptError, script_of, programs, job, Ranges(E=(3000.0, 30_000.0)))
    assert "it reads #1, which depends on the wheel, on its dresses" in said
    assert "depends on the E and D chosen in it" in refusal(PassageError, job_env.make, path)


def test_a_variable_assigned_by_a_dress_matters_only_if_it_is_read(tmp_path: Path) -> None:
    assert job_env.make(written(tmp_path, looped("#2=5", 1))).simulation.why is None
    env = job_env.make(written(tmp_path, looped("#2=#2+1", 1).replace("Y-[.03", "Y-[.03+#2*.005")))
    assert "it reads #2" in str(env.simulation.why)
    env.reset(seed=1)
    for _ in env.simulation.blocks:
        env.step(env.codec.encode(15_000.0, 2)[0])
    assert_same_record(grind(read(env.part_program()), env.written().job), env.record())


def test_an_action_that_leads_to_other_blocks_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    # the loop ends early after one dress, but not after none or three
    text = looped("#2=#2+1", 0).replace("END1", "IF[#2 EQ 1]GOTO 9\nEND1").replace("END1\nG80", "END1\nN9 G80")
    env = job_env.make(written(tmp_path, text))
    env.reset(seed=1)
    one, none = (env.codec.encode(15_000.0, executions)[0] for executions in (1, 0))
    for _ in range(2):
        assert "part.nc:6: which cycle blocks the program runs behind" in refusal(PassageError, env.step, one)
        assert not env.blocks
    env.step(none)
    assert len(env.blocks) == 1


def test_missing_files_are_named_and_another_job_file_can_be_given(tmp_path: Path) -> None:
    assert "nowhere.nc" in refusal(GrindError, job_env.make, str(tmp_path / "nowhere.nc"))
    path = tmp_path / "alone.nc"
    path.write_text(BATCH)
    assert "alone.toml" in refusal(GrindError, job_env.make, str(path))
    other = tmp_path / "other.toml"
    assert "other.toml" in refusal(GrindError, job_env.make, str(path), job=str(other))
    other.write_text(JOB)
    assert job_env.make(str(path), job=str(other)).simulation.job == load_job(other)


def test_a_spread_that_is_no_float_is_refused() -> None:
    for spread in (10**400, 10**5000):
        assert "from 0 to 2" in refusal(GrindError, job_env.make, spread=spread)


# --- a batch of parts ---------------------------------------------------------------------------------


def test_a_program_is_run_for_a_batch_of_parts() -> None:
    env = job_env.make(parts=3, info="full")
    text = env.simulation.writer.program([])
    assert [line for line in text.splitlines() if line.endswith(("M00", "M30"))] == ["M00", "M00", "N100 M30"]
    assert text.count("G82") == 6 and text.count("O9100") == 1
    assert [(block.part, block.starts_part) for block in env.simulation.blocks] == [
        (k // 2, k % 2 == 0) for k in range(6)
    ]
    infos = play(env, policy_seed=3, seed=4)
    record = assert_infos_match_record(env, infos)
    assert_same_record(grind(read(env.part_program(), "part.nc"), env.written().job), record)
    assert record.parts.size == 3
    # the wheel carries over from part to part
    parts, ds = record.strokes["part"], record.strokes["ds"]
    for number in (2, 3):
        worn = ds[parts == number - 1][-1] - ds[parts == number][0]
        assert 0.0 <= worn < 0.2 and ds[parts == number][0] < 300.0


def test_a_batch_repeats_a_program_with_or_without_an_end_word(tmp_path: Path) -> None:
    once = f"G71 G94 G90 G19 S1910 M03 M08 (NO M30 HERE)\nM98 P2\nG00 Y20.{{}}\nO2\nG00 Y20.\n{PLATE}M99\n{DRESS}"
    for ending in ("\nM30", "\nM2 (END)", ""):
        env = job_env.make(written(tmp_path, once.format(ending)), parts=3, spread=0.0)
        assert (len(env.simulation.blocks), env.simulation.parts) == (6, 3)
    lines = [source.text for source in env.simulation.programs.main.blocks]
    assert [line for line in lines if line.startswith("M")] == ["M98 P2", "M00"] * 2 + ["M98 P2"]


def test_a_program_that_ends_in_a_subprogram_is_refused_for_a_batch(tmp_path: Path) -> None:
    path = written(tmp_path, f"G71 G94 G90 G19 S1910 M03 M08\nM98 P2\nO2\nG00 Y20.\n{PLATE}M30\nM99\n{DRESS}")
    assert len(job_env.make(path).simulation.blocks) == 2
    for make in (job_env.make, job_env.make_vector):
        message = refusal(GrindError, make, program=path, parts=3)
        assert "part.nc:11: the program ends in a subprogram" in message and "main program" in message


@pytest.mark.parametrize("parts", [0, -1, 1.5, True, "3", 1001])
def test_a_batch_has_a_whole_number_of_parts_from_1_to_1000(parts: Any) -> None:
    for make in (job_env.make, job_env.make_vector):
        message = refusal(GrindError, make, parts=parts)
        assert message == f"parts is {parts!r}, but must be a whole number from 1 to 1000"


def test_the_lots_table_of_a_job_sets_the_spread_of_parts(tmp_path: Path) -> None:
    lots = f"{JOB}[lots]\nprobability = 0\nstock = 0.1"
    path = written(tmp_path, f"G71 G94 G90 G19 S1910 M03 M08\nG00 Y20.\n{PLATE}M30\n{DRESS}", lots)
    env = job_env.make(path, parts=100)
    stocks = []
    for seed in range(20):
        env.reset(seed=seed)
        assert len({condition.factors["kA"] for condition in tape_of_job(env).conditions}) == 1
        assert tape_of_job(env).new_lot[0] and not any(tape_of_job(env).new_lot[1:])
        stocks += [condition.stock for condition in tape_of_job(env).conditions]
    assert np.mean(stocks) == pytest.approx(0.06, rel=0.01)
    assert np.std(stocks) == pytest.approx(0.1 * 0.06, rel=0.06)
    exact = job_env.make(path, parts=3, spread=0.0)
    exact.reset(seed=0)
    assert [condition.stock for condition in tape_of_job(exact).conditions] == [None] * 3


# --- replayed or executed -----------------------------------------------------------------------------


STAGED = JOB + "\n[[part.stages]]\nstock = 0.05\n"


@pytest.mark.parametrize(
    ("cycle", "job", "line", "why"),
    [
        ("G81 X230. I-30. E9000.\nG01 Y-.03 F.6\nM01\nG04 X1.\n", JOB, 6, "the table goes on after a stop"),
        ("G82 X230. I-30. Y-.05 J-.01 F60. E9000.\nG80\nG00 Y20.\nG17 G41 G01 X-40. F500.\nX-50.\nG40 X-60.\n", JOB,
         6, "its motions depend on the radius of the wheel"),
        ("G82 X230. I-30. Y-.05 J-.01 F60. E9000.\nG80\nG96 S1800\nG95 G01 Y2. F.05\nG94 F60.\n", JOB, 6,
         "its motions depend on the radius of the wheel"),
        ("G81 X230. I-30. E9000.\nG01 Y-.03 F.6\nX220.\nG01 Y-.04 F.6\n", JOB, 6, "the program redirects the table"),
        ("G81 X230. I-30. E9000.\nG01 Y-.03 F.6\nE9000.\nG01 Y-.04 F.6\n", JOB, 6, "the program redirects the table"),
        ("G82 X230. I-30. Y-.05 J-.01 F.5 E9000.\n", JOB, 3, "a pick is still under way in the middle of the stroke"),
        ("G82 X230. I-30. Y-.05 J-.01 F1.5 E9000. P9100\n", JOB, 3, "a dress waits for a pick to end"),
        ("G82 X230. I-30. Y-.05 J-.01 F60. E9000.\nM01\n", STAGED, 3, "after this cycle the part is judged"),
    ],
)  # fmt: skip
def test_the_environment_gives_the_reason_why_a_program_has_no_script(
    tmp_path: Path, cycle: str, job: str, line: int, why: str
) -> None:
    head = "G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y0 Z0\n"
    path = written(tmp_path, f"{head}{cycle}G80\nG00 Y20.\nM30\n{DRESS}", job)
    env = job_env.make(path)
    reason = str(env.simulation.why)
    assert reason.startswith(f"part.nc:{line}: there is no script of this program: {why}") and "\n" not in reason
    play(env, policy_seed=0)
    assert_same_record(grind(read(env.part_program()), env.written().job), env.record())


def test_the_observation_begins_with_the_volume_that_the_wheel_has_ground(tmp_path: Path) -> None:
    env = job_env.make(written(tmp_path, BATCH, f"{JOB}\n[wheel]\nvolume_since_dress = 300\n"), spread=0.0)
    read = env.simulation.read
    assert read(env.reset(seed=0)[0][None])["volume"] == pytest.approx(300.0)
    after = env.step(env.codec.encode(12_000.0, 0)[0])[0]
    assert read(after[None])["volume"] == pytest.approx(300.0 + 0.05 * 200.0, rel=0.01)


def test_a_wheel_change_at_the_end_of_an_executed_program_takes_time(tmp_path: Path) -> None:
    cycle = "G82 X230. I-30. Y-.03 J-.01 F1. E12000. P9100"
    plate = f"G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y0 Z0\n{cycle}\nG80\nG00 Y20.\nM30\n"
    worn = f"{JOB}\n[times]\nwheel_change = 300\n[wheel]\ndiameter = 220.01\n"
    env = job_env.make(written(tmp_path, plate + DRESS, worn), spread=0.0)
    assert env.simulation.why is not None
    env.reset(seed=0)
    info = env.step(env.codec.encode(9000.0, 1)[0])[4]
    assert info["seconds"] == pytest.approx(env.record().seconds, rel=1e-12) and info["seconds"] > 300.0


def test_a_batch_stops_the_table_and_cancels_a_preset_between_its_parts(tmp_path: Path) -> None:
    plate = "G71 G94 G90 G19 S1910 M03 M08\nG00 X-30. Y0 Z0\nG92 X-10. Y1.\n"
    plate += "G82 X250. I-10. Y.97 J-.01 L1 F100. E12000. P9100\nM30\n"
    env = job_env.make(written(tmp_path, plate + DRESS), spread=0.0, parts=3)
    assert env.simulation.why is None
    play(env, policy_seed=1)
    assert np.ptp(env.record().parts["S"]) < 2e-3


def test_a_stop_in_the_dress_program_gauges_no_part(tmp_path: Path) -> None:
    stopped = BATCH.replace("N4 G00 Y10.", "N4 M00\nN5 G00 Y10.").replace("N5 G91", "N6 G91")
    env = job_env.make(written(tmp_path, stopped), info="full")
    assert env.simulation.why is None
    assert_infos_match_record(env, play(env, policy_seed=3))
