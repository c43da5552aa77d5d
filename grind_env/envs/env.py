"""The single environment."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.actions import ActionCodec
from grind_env.envs.observations import Reading, bounds
from grind_env.envs.program import CycleBlock, block_text, coming_block, part_program
from grind_env.envs.rows import Outcome
from grind_env.envs.simulation import Episodes, Simulation
from grind_env.envs.tasks import Task, TaskError, load_task

REWARD_TERMS = ("time", "wheel", "dress", "scrap", "handover")
"""The terms of the reward, in the order of the first columns of `Outcome`."""

OBSERVATIONS = ("measured", "full")


class GrindEnv(gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Choose the table speed and the dressing of every cycle block of a batch.

    ## Description

    A step is one G82 cycle block of a surface grinder: the table reciprocates with feedrate **E**, the wheel
    plunges at every reversal point until the stock is removed, sparks out, and the control runs the dress
    program **D** times within the cycle, evenly in depth. The wheel dulls, loads, wears and grows waves; slow
    tables glaze it and burn the part, fast tables cost power, roughness and size, and dressing costs time and
    wheel.

    ## Action space

    `Box(-1, 1, (2,), float32)`: E geometric over the speed range of the task (or equal bins over its speed
    levels), D in equal-width bins from 0 to the most executions that the task allows.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, scaled to about -1..1. `observation_info()`
    lists every entry. `observation="full"` adds the hidden state of the wheel and of the lot.

    ## Reward

    Minus the cost of the block in units of `task.reference_cost`: machine time, wheel, dresser, the expected
    cost of scrap, and with the last block the price of handing over a dull wheel. The best fixed plan earns
    about -1 a step, a good policy -0.6; a scrapped part costs 10 and more. `info["reward_terms"]` holds the
    terms, `info["cost"]` the probability that the part which this block finished is scrap.

    ## Episode

    Starts with a freshly dressed wheel (unless the task says otherwise) and ends `terminated` after the last
    block. All that is random is drawn at reset.

    Args:
        task: name of the task, for example `"power_limited"`.
        observation: `"measured"` or `"full"`; by default what the task says, which is `"measured"` for all but Oracle6.
        show_block: put the text of the block that was run into `info["block"]`.
        render_mode: none yet.
    """

    def __init__(
        self,
        task: str = "power_limited",
        observation: str | None = None,
        show_block: bool = True,
        render_mode: str | None = None,
    ) -> None:
        self.task: Task = load_task(task)
        refuse_render(render_mode)
        self.simulation = Simulation(self.task, full=wants_full(self.task, observation))
        self.codec = ActionCodec(self.task)
        self.render_mode = render_mode
        self.show_block = show_block
        self.action_space = self.codec.space
        self.observation_space = spaces.Box(*bounds(self.simulation.entries), dtype=np.float32)
        self.episodes: Episodes | None = None
        self.blocks: list[CycleBlock] = []

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.simulation.entries

    def part_program(self) -> str:
        """The blocks run since the last reset as a part program with its dress program."""
        return part_program(self.task, self.blocks)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode; the same seed draws the same episode."""
        super().reset(seed=seed)
        self.blocks = []
        if self.episodes is None:
            self.episodes = self.simulation.start([self.np_random])
        else:
            self.simulation.restart(self.episodes, 0, self.np_random)
        return self.simulation.observe(self.episodes)[0], {}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Grind one block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last block.
            ActionError: if the action is not in the action space.
        """
        episodes = self.episodes
        if episodes is None or self.simulation.over(episodes)[0]:
            raise gym.error.ResetNeeded("the episode has not begun or is over: call reset() before step()")
        speeds, executions = self.codec.decode([action])
        block = coming_block(self.task, episodes, 0, speeds[0], executions[0])
        self.blocks.append(block)
        outcomes, _ = self.simulation.step(episodes, speeds, executions)
        outcome = Outcome(*outcomes[0].tolist())
        info: dict[str, Any] = {
            "reward_terms": {
                name: 0.0 - value / self.task.reference_cost for name, value in zip(REWARD_TERMS, outcome, strict=False)
            },
            "cost": outcome.finished - outcome.good,
            "block_cost": outcome.cost,
            "good_parts": outcome.good,
            "seconds": outcome.seconds,
            "E": block.speed,
            "D": float(block.executions),
        }
        if self.show_block:
            info["block"] = block_text(self.task, block)
        terminated = bool(self.simulation.over(episodes)[0])
        return self.simulation.observe(episodes)[0], outcome.reward, terminated, False, info


def refuse_render(render_mode: str | None) -> None:
    """Check the render mode.

    Raises:
        TaskError: if there is one, since none is known yet.
    """
    if render_mode is not None:
        raise TaskError(f"render_mode is {render_mode!r}, but the environment has none: leave it out")


def wants_full(task: Task, observation: str | None) -> bool:
    """Whether the hidden state is asked for; None leaves it to the task.

    Raises:
        TaskError: if `observation` is neither `"measured"` nor `"full"`.
    """
    observation = task.observation if observation is None else observation
    if observation not in OBSERVATIONS:
        raise TaskError(f"observation is {observation!r}, but must be one of {', '.join(OBSERVATIONS)}")
    return observation == "full"
