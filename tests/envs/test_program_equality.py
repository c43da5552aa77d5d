"""The part program of a random episode, run by `machine.grind`, gives the results of the environment part by part.

The machine counts the travel of the wheel between rough and finish block of a part, the tasks do not. The part cools
meanwhile. Therefore parts ground in several blocks have materials without thermal expansion here. The machine does not
know the prices of new wheels and of lateness.
"""

import importlib
import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.blocks.task_job import conditions, job
from grind_env.envs.blocks.task_program import CycleBlock
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.distribution_splits import EVERY, SPLITS
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.reset_options import Fixed, Given
from grind_env.envs.task_names import environment_id, task_names
from grind_env.envs.tasks import Kind, load_task
from grind_env.machine.grind import grind
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.record import GrindingRecord
from tests.envs.harness import Array, every_id, without_expansion
from tests.examples import examples

PARTS = 5

#: environments with other forms of programs, and the test modules that run them with `machine.grind`
ELSEWHERE = {
    "grind/Job-v0": "test_job_env",
    "grind/Reciprocation-v0": "test_cross_env",
    "grind/Task-v0": "test_user_tasks",
    "grind/WidePlates-v0": "test_cross_env",
}


def test_every_environment_is_covered() -> None:
    assert {environment_id(name) for name in task_names()} | set(ELSEWHERE) == set(every_id())
    for env_id in ELSEWHERE:
        module = importlib.import_module(f"tests.envs.{ELSEWHERE[env_id]}")
        proofs = [
            getattr(module, name) for name in dir(module) if name.startswith("test_") and "grinds_the_same" in name
        ]
        assert any(hasattr(proof, "hypothesis") for proof in proofs), env_id


class Episode:
    """First parts of a random episode, run by the environment and, from their program, by `machine.grind`."""

    def __init__(self, name: str, given: Given, seed: int, policy_seed: int, pre_dress: bool) -> None:
        task = load_task(name)
        if not all(kind.starts_part for kind in task.kinds):
            task = without_expansion(task)
        simulation = BlockSimulation(task)
        episodes = simulation.start([np.random.default_rng(seed)], [given])
        wheel, tape = episodes.wheel(0), episodes.tape[0].copy()
        rows = [TapeRow(*row) for row in tape]
        ends = np.array([task.kinds[int(row.kind)].ends_part for row in rows])
        count = int(np.flatnonzero(ends)[PARTS - 1]) + 1
        rng = np.random.default_rng(policy_seed)
        self.task, self.blocks, self.ends = task, list[CycleBlock](), ends[:count]
        self.kinds: list[Kind] = [
            replace(task.kinds[int(row.kind)], material=task.materials[int(row.material)]) for row in rows[:count]
        ]
        outcomes, results = [], []
        for _ in range(count):
            E = np.floor(np.exp(rng.uniform(*np.log(task.action.speed_ends), 1)))
            D, dress = np.floor(rng.random(1) * 1.7), np.floor(rng.random(1) * 2.0) * pre_dress
            self.blocks.append(simulation.writer.block(episodes, 0, E[0], D[0], dress[0]))
            outcome, result = simulation.step(episodes, E, D, dress)
            outcomes.append(outcome[0])
            results.append(result[0])
        self.outcome = Outcome(*np.array(outcomes).T)
        self.result = Tally(*np.array(results).T)
        shop = job(task, *(block.kind for block in self.blocks[: int(np.argmax(ends)) + 1]))
        start = replace(shop.wheel, diamond_flat=wheel.wd, diameter=wheel.ds)
        if task.start.wear_flat_area is not None:
            start = replace(start, wear_flat_area=wheel.A, volume_since_dress=wheel.V)
        shop = replace(shop, wheel=start, parts=tuple(conditions(task, tape)[:PARTS]))
        self.record: GrindingRecord = grind(read(simulation.writer.program(self.blocks)), shop)
        self.final_wheel = episodes.wheel(0)

    def by_part(self, values: Array) -> Array:
        """Return the sums over the blocks of each part."""
        return np.add.reduceat(values, np.concatenate([[0], np.flatnonzero(self.ends)[:-1] + 1]))

    def by_block(self) -> list[Array]:
        """Return the strokes of the record, block by block."""
        strokes = self.record.strokes
        lines, first = np.unique(strokes["line"], return_index=True)
        return [strokes[strokes["line"] == line] for line in lines[np.argsort(first)]]

    def changes(self) -> Array:
        """Return the mask of the blocks with a wheel change after them: the wheel of the next block is larger."""
        diameters = [(strokes["ds"][0], strokes["ds"][-1]) for strokes in self.by_block()]
        return np.array([after[0] > before[1] for before, after in itertools.pairwise(diameters)])


@pytest.mark.parametrize("name", task_names())
@examples(25)
@given(
    seed=st.integers(0, 10_000),
    policy_seed=st.integers(0, 10_000),
    pre_dress=st.booleans(),
    # the extrapolation split has its own materials
    material=st.sampled_from([None, *range(len(load_task("power_limited").materials)), *3 * ["extrapolation"]]),
    left=st.floats(0.1, 8.0),
)
def test_the_part_program_of_an_episode_grinds_the_same_parts(
    name: str, seed: int, policy_seed: int, pre_dress: bool, material: int | str | None, left: float
) -> None:
    fixed = Fixed(material=float(material)) if isinstance(material, int) else Fixed()
    if load_task(name).wheel_change is not None:  # so that the wheel is changed within these parts
        fixed = fixed._replace(executions_left=left)
    split = SPLITS[material if isinstance(material, str) else EVERY]
    episode = Episode(name, Given(fixed=fixed, split=split), seed, policy_seed, pre_dress)
    task, outcome, result, record = episode.task, episode.outcome, episode.result, episode.record
    parts, last, limit = record.parts, episode.ends, task.limits(task.kinds[0]).power
    # random speeds overload the spindle; in titanium the lag of the wheel grows so large that a stroke cuts deep
    told = ("the spindle s", "the process model holds up to")
    assert len(parts) == PARTS and all(any(text in each for text in told) for each in record.warnings)
    for block, strokes in enumerate(episode.by_block()):
        assert len(strokes) == result.strokes[block]
        assert strokes["load"].max() == pytest.approx(result.peak_load[block], rel=1e-9)
        # in a stroke that reverses over the part the power is a mean and the load the maximum
        assert min(strokes["load"].max(), limit) == pytest.approx(outcome.peak_power[block], rel=1e-9)
        assert (strokes["power"] <= np.minimum(strokes["load"], limit) * (1.0 + 1e-9)).all()
        assert strokes["load"].max() / limit == pytest.approx(outcome.power_ratio[block], rel=1e-9)
        assert strokes["Ra"][-1] == pytest.approx(outcome.roughness[block], rel=1e-9)
    assert parts["dresses"].tolist() == episode.by_part(result.dresses).tolist()
    exact = {"rtol": 1e-9, "atol": 1e-9}
    np.testing.assert_allclose(parts["size_error"], outcome.size_error[last], **exact)
    np.testing.assert_allclose(parts["Ra"], outcome.roughness[last], **exact)
    np.testing.assert_allclose(parts["worn"], episode.by_part(result.worn), **exact)
    np.testing.assert_allclose(parts["dressed_off"], episode.by_part(result.dressed_off), **exact)
    np.testing.assert_allclose(parts["survival"], outcome.good[last], rtol=1e-7, atol=1e-12)
    for term, cost in (("wheel_cost", outcome.wheel_cost), ("dress_cost", outcome.dress_cost)):
        np.testing.assert_allclose(parts[term], episode.by_part(cost), **exact)
    changed = outcome.change_cost > 0.0
    assert episode.changes().tolist() == changed[:-1].tolist()
    strokes = np.bincount(record.strokes["part"] - 1, record.strokes["seconds"], PARTS)
    dresses = np.bincount(record.dresses["part"] - 1, record.dresses["seconds"], PARTS)
    gauged = episode.by_part(np.ones(len(result.strokes))) - 1.0
    stops = (
        task.setup.load
        + task.setup.gauge * gauged
        + (task.wheel_change.seconds if task.wheel_change else 0.0) * episode.by_part(changed)
    )
    stops = stops + task.machine.stall_time * (parts["peak_torque"] >= 1.0)
    seconds = episode.by_part(outcome.seconds)
    np.testing.assert_allclose(strokes + dresses + stops, seconds, rtol=1e-9, err_msg="seconds")
    travel = parts["seconds"] - seconds
    assert (np.abs(travel) < 1e-6).all()
    shop_costs = outcome.late_cost + outcome.change_cost + outcome.handover_cost
    cost = episode.by_part(outcome.cost - shop_costs) + task.rates.hourly * travel / 3600.0
    np.testing.assert_allclose(parts["total_cost"], cost, rtol=1e-9)
    if not changed[-1]:
        for field in ("ds", "A"):
            np.testing.assert_allclose(record.strokes[field][-1], getattr(episode.final_wheel, field), rtol=1e-9)


def test_the_wheel_changes_between_parts_and_within_one() -> None:
    found = set()
    for seed in range(12):
        episode = Episode("CBN", Given(fixed=Fixed(executions_left=3.5)), seed, seed, pre_dress=False)
        found |= {episode.blocks[k].kind.ends_part for k in np.flatnonzero(episode.changes())}
    assert found == {False, True}


def test_parts_of_several_kinds_and_materials_are_ground_in_one_run() -> None:
    kinds = {kind.name for seed in range(12) for kind in Episode("rush", Given(), seed, seed, pre_dress=False).kinds}
    assert len(kinds) == 3
