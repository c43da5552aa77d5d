import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs import task_env_factory
from grind_env.envs.observations import physical
from grind_env.envs.past_readings import History
from grind_env.envs.picture_builder import coming_part, extent_of
from grind_env.envs.task_names import task_names
from grind_env.envs.tasks import load_task

gym.register_envs(grind_env)

STALLED = History._fields.index("stalled")


@pytest.mark.parametrize("name", task_names())
def test_a_view_agrees_with_info_and_observation(name: str) -> None:
    env = task_env_factory.make(name, observation="full", info="full", show_block=True)
    task = env.task
    observation, _ = env.reset(seed=3)
    rng = np.random.default_rng(0)
    cost, good, executions = 0.0, 0.0, 0
    for k in range(min(task.blocks, 8)):
        coming = coming_part(task, env.episodes, 0)
        observation, _, _, _, info = env.step(rng.uniform(-1.0, 1.0, 2).astype(np.float32))
        view = env.view()
        seen = physical(observation, env.observation_info())
        cost, good, executions = cost + info["block_cost"], good + info["good_parts"], executions + int(info["D"])
        assert view.text == info["block"]
        assert view.number == len(view.ground) == k + 1
        assert (view.cost, view.good_parts) == pytest.approx((cost, good))
        assert sum(block.executions for block in view.ground) == executions == round(float(seen["dresses"]))
        assert view.ground[-1].speed == info["E"]
        # the picture shows the true diameter, the observation the gauged one
        assert view.wheel.ds == pytest.approx(float(seen["diameter"]), abs=0.01 * max(task.spread.measurement, 1.0))
        assert pytest.approx(float(seen["wear_flat"]), abs=1e-6) == view.wheel.A
        assert view.part.stock == coming.stock == coming.left
        # the Y word counts from the touched-off surface, which is already ground away before a finish block
        depth = float(view.text.split(" Y-")[1].split()[0]) - env.blocks[-1].surface
        assert depth == pytest.approx(view.part.stock, abs=5e-4)
        # a part ground hot may be too thin; a part is left as it is after a stall
        assert view.part.left == pytest.approx(1e-3 * env.outcomes[-1].size_error, abs=1e-12)
        assert view.part.left < 0.5 * view.part.stock or env.episodes.memory[0, STALLED] == 1.0


def test_before_the_first_block_the_part_has_all_its_stock() -> None:
    env = task_env_factory.make("oracle6")
    env.reset(seed=0)
    view = env.view()
    assert (view.ground, view.text, view.last, view.number) == ((), "", None, 0)
    assert view.part.left == view.part.stock == 0.2
    assert view.radius_lost == 0.0


def test_the_extent_of_an_episode_follows_from_its_task() -> None:
    found = extent_of(load_task("oracle6"))
    assert (found.title, found.blocks, found.parts) == ("Six blocks with a known optimum", 6, 6)
    assert found.most_executions == 1
    assert (found.lowest_speed, found.highest_speed) == (6000.0, 21000.0)
    assert (found.new_diameter, found.longest) == (300.0, 200.0)
