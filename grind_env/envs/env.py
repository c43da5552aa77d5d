"""The single environment."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_flags, is_full, refuse_render
from grind_env.envs.blocks.program import drawn_job
from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.contexts import Given, read_options
from grind_env.envs.form import check_task
from grind_env.envs.forms import form_of
from grind_env.envs.infos import InfoWriter
from grind_env.envs.observations import Reading
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.shown import shown_space
from grind_env.envs.simulation import Episodes
from grind_env.envs.tasks import Task, load_task
from grind_env.machine.job import Job
from grind_env.process.state import WheelState
from grind_env.render.view import View

REWARD = Outcome._fields.index("reward")


class GrindEnv(Showing, gym.Env[NDArray[np.float32], Any]):
    """Choose the table speed and the dressing of every cycle block of a batch.

    ## Description

    A step is one G82 cycle block of a surface grinder: the table reciprocates with feedrate **E**, the wheel
    plunges at every reversal point until the stock is removed, sparks out, and the control runs the dress
    program **D** times within the cycle, evenly in depth. (A task with an infeed has G81 blocks, one with a cross pick
    G83 blocks: see `grind/Reciprocation-v0` and `grind/WidePlates-v0`.) The wheel dulls, loads, wears and grows waves;
    slow tables glaze it and burn the part, fast tables cost power, roughness and size, and dressing costs time and
    wheel.

    ## Action space

    By default `Box(-1, 1, (2,), float32)`: E geometric over the speed range of the task (or equal bins over its speed
    levels), D = 0 up to 1/3 and in bins of equal width above it, from 1 to the most executions that the task allows: a
    policy that has learned nothing dresses in the minority of its blocks. The same decision is taken with
    `action="multidiscrete"`, `MultiDiscrete([levels, most + 1])`, with `action="discrete"`, the pair as one number, or
    with `action="dict"`, `{"E": mm/min, "D": executions}`. The two discrete forms have 24 levels of E that divide its
    range geometrically, or those of the task. `predress=True` adds a third component (a dress if it is above 0), factor
    or key: a dress before the first plunge, G82.1. `env.unwrapped.codec` converts both ways.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, scaled to about -1..1. `observation_info()`
    lists every entry; what never changes in a task is none. `observation="full"` adds the hidden state of the wheel and
    of the lot, behind all that is measured.

    ## Reward

    Minus the cost of the block in units of `task.reference_cost`: machine time, wheel, dresser, the expected
    cost of scrap, and with the last block the price of handing over a dull wheel; where the task has them, lateness
    and wheel changes. The best fixed plan earns about -1 a step, a good policy -0.6; a scrapped part costs 10 and
    more. `info["reward_terms"]` holds the terms, `info["cost"]` the probability that the part which this block
    finished is scrap. `info["burn_ratio"]`, `info["power_ratio"]` and `info["roughness_ratio"]` say how near the block
    came to burning and to its limits of power and Ra, which are at 1; the last one is 0 where Ra has no limit.

    A part is scrap by its size, its Ra, the highest temperature rise that it has felt, or a spindle that has
    stalled. The burn ratio (Malkin) only warns of heat: it scraps nothing.

    ## Episode

    Starts with a freshly dressed wheel (unless the task says otherwise) and ends `terminated` after the last
    block. Everything random is drawn at reset; `reset(options={"context": ..., "split": ...})` fixes factors or
    restricts what they are drawn from (`grind_env.envs.contexts`). What is fixed is not told in the observation: a
    material other than that of a task with a single material has to be found out like a lot or a wheel.

    With two blocks per part, `machine.grind` gives other part times: it adds the travel between the blocks (2 to 4 s).

    Args:
        task: name of a task, for example `"power_limited"`, or the path of a task file, such as `"shop.toml"`; what
            stands in one, `grind tasks --schema` says. `grind/Task-v0` takes any; each other id fixes its task, and
            through `gym.make` another would carry the wrong id and reference scores.
        observation: `"measured"` or `"full"`; by default what the task says, which is `"measured"` for all but Oracle6.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: let an action ask for a dress before the first plunge.
        cycle: that of the blocks, or None; any other is refused.
        render_mode: `"rgb_array"` for a picture, `"human"` for a window that follows the
            episode (without a screen, text in the terminal), `"ansi"` for text.
    """

    load = staticmethod(load_task)
    """Task of a name or of a file."""
    form_of = staticmethod(form_of)
    """Form of its blocks."""

    def __init__(
        self,
        task: str = "power_limited",
        observation: str | None = None,
        show_block: bool = True,
        action: str = "box",
        predress: bool = False,
        cycle: str | None = None,
        render_mode: str | None = None,
    ) -> None:
        self.task = self.load(task)
        self.form = self.form_of(self.task)
        check_flags(show_block=show_block, predress=predress)
        refuse_render(render_mode, RENDER_MODES)
        check_task(self.task, cycle)
        self.simulation = self.form.simulation(self.task, full=wants_full(self.task, observation), pre_dress=predress)
        self.codec = ActionCodec(self.task, action, predress=predress)
        self.infos = InfoWriter(self.task, self.codec.names)
        self.render_mode = render_mode
        self.show_block = show_block
        self.action_space: spaces.Space[Any] = self.codec.space
        self.observation_space = shown_space(self.simulation)
        self.given = Given()
        self.episodes: Episodes | None = None
        self.blocks: list[Any] = []
        self.outcomes: list[Outcome] = []
        self._first_wheel: list[float] = []

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.simulation.entries

    def part_program(self) -> str:
        """The blocks run since the last reset as a part program with its dress program."""
        return self.form.program(self.task, self.blocks)

    def part_job(self) -> Job:
        """The job of that program: `machine.grind` makes of both what the episode was, with its wheel, lots and stocks.

        Raises:
            gymnasium.error.ResetNeeded: before the first step of the episode.
        """
        if self.episodes is None or not self.blocks:
            raise gym.error.ResetNeeded("nothing has been ground: call reset() and step() first")
        bare = self.form.job(self.task, self.blocks)
        return drawn_job(self.task, bare, WheelState(*self._first_wheel), self.episodes.tape[0])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode; the same seed draws the same episode.

        Args:
            seed: of the generator, which else goes on.
            options: `"context"` and `"split"`, see `grind_env.envs.contexts`; they hold until others are given.

        Raises:
            ContextError: if an option is not legal.
        """
        given = read_options(self.task, options, self.given)
        super().reset(seed=seed)
        self.given, self.blocks, self.outcomes = given, [], []
        if self.episodes is None:
            self.episodes = self.simulation.start([self.np_random], [given])
        else:
            self.simulation.restart(self.episodes, 0, self.np_random, given)
        self._first_wheel = self.episodes.wheels[0].tolist()
        self.follow()
        return self.simulation.observe(self.episodes)[0], {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Grind one block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last block.
            ActionError: if the action is not in the action space.
        """
        episodes = self.episodes
        if episodes is None or episodes.block[0] >= self.task.blocks:
            raise gym.error.ResetNeeded("the episode has not begun or is over: call reset() before step()")
        choice = self.codec.choose(self.codec.single(action))
        block = self.form.block(self.task, episodes, 0, *(float(values[0]) for values in choice))
        outcomes, _ = self.simulation.step(episodes, *choice)
        outcome = Outcome(*outcomes[0].tolist())
        self.blocks.append(block)
        self.outcomes.append(outcome)
        self.follow()
        info = self.infos.single(outcome, choice)
        if self.show_block:
            info["block"] = self.form.text(self.task, block)
        terminated = bool(episodes.block[0] >= self.task.blocks)
        return self.simulation.observe(episodes)[0], outcome.reward, terminated, False, info

    def view(self) -> View:
        """The machine after the last block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self.episodes is None:
            raise gym.error.ResetNeeded("there is nothing to show yet: call reset() before render()")
        return self.form.view(self.task, self.episodes, 0, self.blocks, self.outcomes, self.form.text)


def wants_full(task: Task, observation: str | None) -> bool:
    """Whether the hidden state is asked for; None leaves it to the task.

    Raises:
        TaskError: if `observation` is neither `"measured"` nor `"full"`.
    """
    return is_full(task.observation if observation is None else observation)
