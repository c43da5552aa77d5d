import math
import re
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.blocks.task_job import conditions, job_of
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.env import GrindEnv
from grind_env.envs.ids import reciprocation, wide_plates
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import physical
from grind_env.envs.past_readings import History
from grind_env.envs.reset_options import Fixed, Given, nominal_context
from grind_env.envs.tasks import read_task
from grind_env.machine.grind import grind
from grind_env.machine.loops.strip_stroke import strips_of
from grind_env.machine.loops.table_speed import pace_of
from grind_env.machine.loops.zone_layout import strip_zones
from grind_env.machine.part.stroke_record import WheelSeen
from grind_env.machine.record import GrindingRecord
from grind_env.process.process_interface import PROCESS
from tests.envs.harness import whole_tape
from tests.examples import examples

PARTS = 4

Info = dict[str, Any]


def play(env: GrindEnv, seed: int, policy_seed: int) -> list[Info]:
    env.reset(seed=seed)
    size = env.action_space.shape[0]
    actions = np.random.default_rng(policy_seed).uniform(-1, 1, (PARTS, size)).astype(np.float32)
    return [env.step(action)[4] for action in actions]


def ground(env: GrindEnv) -> GrindingRecord:
    """Run program and requests of the episode with `machine.grind`, on the wheel and the parts of its seed."""
    drawn = env.simulation.start([np.random.default_rng(env.np_random_seed)])
    job = job_of(env.task, env.blocks)
    wheel = replace(job.wheel, diamond_flat=drawn.wheel(0).wd)
    job = replace(job, wheel=wheel, parts=tuple(conditions(env.task, drawn.tape[0])[:PARTS]))
    control = replace(job.control, operator_dress_at=env.written().requests)
    return grind(read(env.part_program()), job, control=control)


def too_many_dresses(text: str) -> list[int]:
    """Return the lines of the cycles with D above depth over pick."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        words = {name: float(value) for name, value in re.findall(r"([YJD])(-?[\d.]+)", line)}
        if line.startswith("G83") and words.get("D", 0.0) > math.ceil(words["Y"] / words["J"] - 1e-9):
            found.append(number)
    return found


@pytest.mark.bits
@pytest.mark.parametrize("made", [wide_plates, reciprocation])
@examples(6)
@given(seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000), predress=st.booleans())
def test_the_part_program_of_an_episode_grinds_the_same_parts(
    made: ModuleType, seed: int, policy_seed: int, predress: bool
) -> None:
    env = made.make(predress=predress, info="full")
    infos = play(env, seed, policy_seed)
    record, own = ground(env), env.record()
    assert record.warnings == own.warnings
    # fast tables overload the 5 kW spindle; a warning names every block with more dresses than plunges, and no other
    told = [each for each in own.warnings if "the spindle" not in each]
    assert all("asks for more dresses than the cycle has plunges" in each for each in told)
    assert [int(each.split(":")[1]) for each in told] == too_many_dresses(env.part_program())
    # ground on the wheel and parts drawn from the seed, and on those of the environment
    for name in ("strokes", "dresses", "parts"):
        assert getattr(record, name).tobytes() == getattr(own, name).tobytes(), name
    parts = record.parts
    assert env.episodes is not None
    for number, (info, row) in enumerate(zip(infos, whole_tape(env), strict=False), 1):
        strokes, stock = record.strokes[record.strokes["part"] == number], TapeRow(*row).stock
        assert set(strokes["E"]) == {info["E"]}
        assert strokes["Z"].max() == pytest.approx(stock, abs=1e-12)
        # one to the primary point, then for each plunge of 0.02 mm three cross picks and one stroke at the end
        assert made is reciprocation or len(strokes) == 1 + 4 * math.ceil(round(stock / 0.02, 6))
    good = parts["survival"]
    dresses = [info["D"] + info.get("predress", 0.0) for info in infos]
    assert parts["dresses"].tolist() == dresses
    assert (record.dresses["cause"] == "pre").sum() == sum(info.get("predress", 0.0) for info in infos)
    assert (record.dresses["cause"] == "operator").sum() == (made is reciprocation) * sum(info["D"] for info in infos)
    assert parts["seconds"] == pytest.approx([info["seconds"] for info in infos], rel=1e-12)
    assert good == pytest.approx([info["good_parts"] for info in infos], rel=1e-6, abs=1e-12)
    found = {"rise": "rise", "burn_ratio": "burn_ratio", "peak_power": "peak_power", "roughness": "Ra"}
    for name, column in (found | {"size_error": "worst_error"}).items():
        assert parts[column] == pytest.approx([getattr(each, name) for each in env.outcomes], rel=1e-9, abs=1e-9), name
    wheel = env.episodes.wheel(0)
    for name in WheelSeen._fields:
        assert getattr(wheel, name) == pytest.approx(record.strokes[name][-1], rel=1e-9), name
    assert parts["total_cost"] == pytest.approx([info["block_cost"] for info in infos], rel=1e-8)


def test_the_block_is_a_g83_that_crosses_the_part_from_edge_to_edge() -> None:
    env = wide_plates.make(predress=True, show_block=True)
    env.reset(seed=0)
    assert env.episodes is not None
    stock = f"{whole_tape(env)[0, 1]:.3f}".lstrip("0").rstrip("0")
    text = env.step(env.codec.encode(9487.0, 1.0, 1.0)[0])[4]["block"]
    assert text == f"G83.1 X330. I-30. Y-{stock} J-.02 Z35. K12. L0 F1500. E9487. P9100 D1"
    plain = env.step(np.array([0.0, -1.0, -0.5], np.float32))[4]["block"]
    assert plain.startswith("G83 ") and plain.endswith(" E9487. P9100 D0")
    assert text in env.part_program() and plain in env.part_program()


def test_the_strips_match_a_traverse_computed_step_by_step() -> None:
    env = wide_plates.make()
    task, kind = env.task, env.task.kinds[0]
    env.reset(seed=0, options={"context": {**nominal_context(task), "stock": 1.06}})
    assert env.episodes is not None
    wheel, stock = env.episodes.wheel(0), float(whole_tape(env)[0, 1])
    env.step(np.array([0.0, -1.0], np.float32))
    # strips are 1 mm wide; the 25 mm wheel crosses there and back in picks of 12 mm
    there, back = (0, 12, 24, 35), (35, 23, 11, 0)
    strips = strip_zones(np.arange(60.0))
    depths = [0.0, *np.minimum(kind.pick * np.arange(1, 20), stock)[: int(np.ceil(stock / kind.pick))]]
    p, v, own = task.parameters(kind), 9487.0 / 60.0, np.array([PROCESS.own()])
    seconds, pace = 360.0 / v + v / 1000.0 + 0.15, pace_of(v, 360.0, 300.0, 0.0, 1000.0)
    for number, Z in enumerate(depths):
        for edge in (there if number % 2 else back) if number else (0,):
            lies = edge, edge + 25, Z, pace, kind.width, kind.length, p, Z, own, seconds
            wheel, *_ = strips_of(PROCESS)(wheel, strips, *lies)
    S, Rs = strips.T[:2]
    part = env.record().parts[0]
    assert part["size_error"] == pytest.approx(1000.0 * (stock - S.mean()), rel=1e-9)
    assert abs(part["worst_error"]) == pytest.approx(1000.0 * np.abs(stock - S).max(), rel=1e-9)
    assert part["taper"] == pytest.approx(1000.0 * np.ptp(S), rel=1e-9)
    assert part["Ra"] == pytest.approx(Rs.mean(), rel=1e-9)


def tapers(context: dict[str, float], D: int, parts: int = 8) -> np.ndarray[Any, np.dtype[np.float64]]:
    env = wide_plates.make(action="dict")
    nominal = {**nominal_context(env.task), "stock": 1.0, **context}
    env.reset(seed=0, options={"context": nominal})
    for _ in range(parts):
        env.step({"E": np.array([12_000.0], np.float32), "D": D})
    return np.asarray(env.record().parts["taper"])


def test_the_taper_grows_as_the_wheel_dulls_and_shrinks_with_dresses() -> None:
    plain = tapers({}, 0)
    assert (plain > 0.5).all()
    assert (np.diff(plain[1:]) > 0.0).all()
    levels = [tapers({"kA": kA}, 0)[1:].mean() for kA in (0.25, 0.5, 1.0, 2.0, 4.0)]
    assert (np.diff(levels) > 0.0).all()
    by_dresses = [tapers({}, D)[1:].mean() for D in (0, 1, 2)]
    assert (np.diff(by_dresses) < 0.0).all()


def test_the_observation_shows_taper_and_worst_size_after_every_part() -> None:
    env = wide_plates.make()
    observation, _ = env.reset(seed=3, options={"context": {"noise": 0.0}})
    assert observation[-1] == 0.0 and env.observation_info()[-1].name == "taper"
    for _ in range(3):
        observation = env.step(np.array([0.3, -0.8], np.float32))[0]
        seen = physical(observation, env.observation_info())
        part = env.record().parts[-1]
        assert seen["taper"] == pytest.approx(part["taper"], rel=1e-6)
        assert seen["size_error"] == pytest.approx(part["worst_error"], rel=1e-5)
        width_of_cut = env.record().strokes["b"][-1]
        assert 0.0 < width_of_cut < 25.0


def test_the_taper_of_every_part_has_its_own_noise_of_two_size_readings() -> None:
    simulation = BlockSimulation(read_task("wide_plates"))
    exact = Given(fixed=Fixed(noise=0.0))
    tapers = list[list[np.ndarray]]()
    for noisy in (Given(), exact):
        episodes = simulation.start([np.random.default_rng(seed) for seed in range(40)], [noisy] * 40)
        tapers.append([])
        for _ in range(simulation.task.blocks):
            simulation.step(episodes, np.full(40, 12_000.0), np.zeros(40))
            tapers[-1].append(episodes.memory[:, History._fields.index("taper")].copy())
    noise = np.array(tapers[0]) - np.array(tapers[1])
    assert noise.std() == pytest.approx(0.7 * 2**0.5, rel=0.06)
    assert len(np.unique(noise)) == noise.size
