from collections.abc import Sequence
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.contexts import Given
from grind_env.envs.program import CycleBlock, coming_block, conditions, job, number, part_program
from grind_env.envs.rows import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, load_task, task_names
from grind_env.machine.cycle import CycleResult, PartState
from grind_env.machine.grind import grind
from grind_env.machine.record import GrindingRecord
from grind_env.process.cost import Limits
from grind_env.process.state import WheelState
from tests.envs.harness import Array

PARTS = 4


class Episode:
    """The first parts of a random episode, as the environment ran them and as `machine.grind` runs their program."""

    def __init__(self, name: str, seed: int, policy_seed: int, kind: str, pre_dress: bool) -> None:
        task = load_task(name)
        simulation = Simulation(task)
        # machine.grind knows one kind of part a run: in a task of orders, all orders are of one kind
        kinds = task.numbers((kind,), "") if task.orders else None
        episodes = simulation.start([np.random.default_rng(seed)], [Given(kinds=kinds)])
        wheel, tape = WheelState(*episodes.wheels[0]), episodes.tape[0].copy()
        ends = np.array([task.kinds[int(number)].ends_part for number in tape[:, 0]])
        count = int(np.flatnonzero(ends)[PARTS - 1]) + 1
        rng = np.random.default_rng(policy_seed)
        self.task, self.blocks, self.ends = task, list[CycleBlock](), ends[:count]
        outcomes, results = [], []
        speeds = task.action.speed_levels or task.action.speed_range or ()
        for _ in range(count):
            E = np.floor(1000.0 * np.exp(rng.uniform(np.log(min(speeds)), np.log(max(speeds)), 1)))
            D, dress = np.floor(rng.random(1) * 1.7), np.floor(rng.random(1) * 2.0) * pre_dress
            self.blocks.append(coming_block(task, episodes, 0, E[0], D[0], dress[0]))
            outcome, result = simulation.step(episodes, E, D, dress)
            outcomes.append(outcome[0])
            results.append(result[0])
        self.outcome = Outcome(*np.array(outcomes).T)
        self.result = CycleResult(*np.array(results).T)
        self.last_surface = PartState(*episodes.parts[0])
        shop = job(task, *(block.kind for block in self.blocks[: count // PARTS]))
        start = replace(shop.wheel, diamond_flat=wheel.wd, diameter=wheel.ds)
        if task.start.wear_flat_area is not None:
            start = replace(start, wear_flat_area=wheel.A, volume_since_dress=wheel.V)
        given = conditions(task, tape)[:PARTS]
        self.record: GrindingRecord = grind(
            read(part_program(task, self.blocks)), replace(shop, wheel=start), conditions=given
        )
        self.final_wheel = WheelState(*episodes.wheels[0])

    def by_part(self, values: Array) -> Array:
        """Sums over the blocks of each part."""
        return np.add.reduceat(values, np.concatenate([[0], np.flatnonzero(self.ends)[:-1] + 1]))

    def by_block(self) -> list[Array]:
        """The strokes of the record, block by block."""
        strokes = self.record.strokes
        lines, first = np.unique(strokes["line"], return_index=True)
        return [strokes[strokes["line"] == line] for line in lines[np.argsort(first)]]


def logistic(x: float) -> float:
    return float(1.0 / (1.0 + np.exp(-np.clip(x, -500.0, 500.0))))


def survival(task: Task, episode: Episode) -> list[float]:
    """Probability that each part is good, from the strokes of the record and the limits of every block."""
    good, whole, ground, deepest = [], 1.0, 0.0, 0.0
    for block, strokes in zip(episode.blocks, episode.by_block(), strict=True):
        kind, limits = block.kind, Limits(*task.limits(block.kind))
        if kind.starts_part:
            whole, ground, deepest = 1.0, 0.0, 0.0
        plunge = strokes["Z"] > np.maximum.accumulate(np.concatenate([[deepest], strokes["Z"]]))[:-1]
        counts = (strokes["Z"].max() - strokes["Z"] <= 0.05 + DEPTH_TOLERANCE) | (kind.rise_allowance > 0.0)
        deepest = strokes["Z"].max()
        ground += strokes["ae"].sum()
        whole *= 1.0 - logistic((strokes["T"][plunge & counts].max() - limits.rise) / 12.0)
        whole *= 1.0 - logistic((strokes["power"].max() / limits.power - 1.0) / 0.02)
        if limits.roughness > 0.0:
            whole *= 1.0 - logistic((strokes["Ra"][-1] / limits.roughness - 1.0) / 0.04)
        if limits.size > 0.0:
            stock = block.surface + block.stock
            whole *= 1.0 - logistic((abs(1000.0 * (stock - ground)) - limits.size) / 0.8)
        if kind.ends_part:
            good.append(whole)
    return good


CASES = [
    (name, kind.name, pre_dress)
    for name in task_names()
    for kind in (load_task(name).kinds if load_task(name).orders else load_task(name).kinds[-1:])
    for pre_dress in (False, True)
    if name in ("power_limited", "wide_rails") or not pre_dress
]


@pytest.mark.parametrize(("name", "kind", "pre_dress"), CASES)
@settings(max_examples=5)
@given(seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000))
def test_the_part_program_of_an_episode_grinds_the_same_parts(
    name: str, kind: str, pre_dress: bool, seed: int, policy_seed: int
) -> None:
    episode = Episode(name, seed, policy_seed, kind, pre_dress)
    task, outcome, result, record = episode.task, episode.outcome, episode.result, episode.record
    parts, last = record.parts, episode.ends
    assert len(parts) == PARTS and not record.warnings
    for block, strokes in enumerate(episode.by_block()):
        assert len(strokes) == result.strokes[block]
        assert strokes["power"].max() == pytest.approx(result.peak_power[block], rel=1e-9)
        assert strokes["Ra"][-1] == pytest.approx(outcome.roughness[block], rel=1e-9)
    assert parts["dresses"].tolist() == episode.by_part(result.dresses).tolist()
    exact = {"rtol": 1e-9, "atol": 1e-9}
    np.testing.assert_allclose(parts["size_error"], outcome.size_error[last], **exact)
    np.testing.assert_allclose(parts["Ra"], outcome.roughness[last], **exact)
    np.testing.assert_allclose(parts["worn"], episode.by_part(result.worn), **exact)
    np.testing.assert_allclose(parts["dressed_off"], episode.by_part(result.dressed_off), **exact)
    np.testing.assert_allclose(survival(task, episode), outcome.good[last], rtol=1e-7, atol=1e-12)
    # the way of the wheel from the end of a rough block to its finish block is not counted by the environment
    strokes = np.bincount(record.strokes["part"] - 1, record.strokes["seconds"], PARTS)
    dresses = np.bincount(record.dresses["part"] - 1, record.dresses["seconds"], PARTS)
    np.testing.assert_allclose(
        strokes + dresses + task.setup.load, episode.by_part(outcome.seconds), rtol=1e-9, err_msg="seconds"
    )
    travel = parts["seconds"] - episode.by_part(outcome.seconds)
    assert (np.abs(travel) < (1e-6 if all(last) else 3.0)).all() and (travel > -1e-6).all()
    if all(last) and len({block.kind for block in episode.blocks}) == 1:
        np.testing.assert_allclose(parts["survival"], outcome.good, rtol=1e-7, atol=1e-12)
        np.testing.assert_allclose(parts["total_cost"], outcome.cost - outcome.late_cost, rtol=1e-9)
    np.testing.assert_allclose(record.strokes["ds"][-1], episode.final_wheel.ds, rtol=1e-9)
    np.testing.assert_allclose(record.strokes["A"][-1], episode.final_wheel.A, rtol=1e-9)


def test_a_wheel_change_stands_in_the_program() -> None:
    env = gym.make("grind/CBN-v0").unwrapped
    env.reset(seed=0)
    changed = [env.step(np.array([0.5, 1.0]))[4]["reward_terms"]["change"] < 0.0 for _ in range(12)]
    assert sum(changed) == 1
    after = changed.index(True) + 1
    stops = [line for line in env.part_program().splitlines() if line.startswith(("M00", "M01"))]
    assert [("CHANGE THE WHEEL" in stop) for stop in stops] == [k == after for k in range(1, 12)]


def test_rough_and_finish_of_a_part_are_gauged_between() -> None:
    env = gym.make("grind/WideRails-v0").unwrapped
    env.reset(seed=0)
    for _ in range(4):
        env.step(np.zeros(2))
    stops = [line[:3] for line in env.part_program().splitlines() if line.startswith("M0")]
    assert stops == ["M01", "M00", "M01"]


@pytest.mark.parametrize(
    "value, text", [(0.3, ".3"), (-30.0, "-30."), (-0.02, "-.02"), (11943.0, "11943."), (0.0, "0.")]
)
def test_numbers_are_written_as_the_control_reads_them(value: float, text: str) -> None:
    assert number(value) == text


def blocks_of(text: str) -> Sequence[str]:
    return [line for line in text.splitlines() if line.startswith("G82")]


def test_an_order_of_another_kind_has_its_own_words() -> None:
    env = gym.make("grind/JobShop-v0").unwrapped
    env.reset(seed=3)
    infos = [env.step(np.zeros(2))[4] for _ in range(30)]
    assert blocks_of(env.part_program()) == [info["block"] for info in infos]
    picks = {block.kind.name: block.kind.pick for block in env.blocks}
    assert len(picks) == 3
    for info, block in zip(infos, env.blocks, strict=True):
        assert f"J{number(-block.kind.pick)} L{block.kind.sparkout + 1} " in info["block"]
