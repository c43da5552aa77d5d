"""The single environment of every id whose actions are E and D."""

from dataclasses import replace
from typing import Any, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_flags, check_render
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.infos import InfoWriter
from grind_env.envs.observations import Reading
from grind_env.envs.program_writer import Written
from grind_env.envs.reset_options import Given, read_options, with_machines
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import shown_space
from grind_env.machine.record import GrindingRecord
from grind_env.render import frames, terminal_view
from grind_env.render.picture_data import EpisodePicture

RENDER_MODES = ("rgb_array", "human", "ansi")
METADATA: dict[str, Any] = {"render_modes": [*RENDER_MODES], "render_fps": frames.FPS}

Make = TypeVar("Make")


def renders(make: Make) -> Make:
    """Give the render metadata of a class to a function that makes environments: `gym.make` reads them from it."""
    vars(make)["metadata"] = METADATA
    return make


class EpisodeLength:
    """Mixin that sets `spec.max_episode_steps`; list it before a class of Gymnasium.

    The value is the limit of the caller, or else one more than the steps of an episode. `gym.make(env.spec)` puts a
    `TimeLimit` of this many steps around the environment. A limit equal to the steps would truncate the last step,
    which terminates.
    """

    simulation: Simulation
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """Return the spec that `gym.make` or `gym.make_vec` used; None for an environment that was made directly."""
        return self._spec

    @spec.setter
    def spec(self, made: EnvSpec | None) -> None:
        if made is not None:
            limit = (
                made.kwargs.get("max_episode_steps") or made.max_episode_steps
            )  # `gym.make_vec` gives the argument precedence
            made = replace(made, max_episode_steps=limit or self.simulation.task.blocks + 1)
        self._spec = made


class GrindEnv(EpisodeLength, gym.Env[NDArray[np.float32], Any]):
    """Single environment of a simulation, made by `envs.task_env_factory` or a module of `envs.ids`.

    Args:
        simulation: dynamics, actions and observations.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        render_mode: `"rgb_array"` for a picture, `"human"` for a window that follows the
            episode (without a screen, text in the terminal), `"ansi"` for text.
        info: `"measured"`, or `"full"`; see `grind_env.envs.infos`.
        out_of_range: `"clip"` or `"raise"`, see `grind_env.envs.actions`.

    Attributes:
        task: task of the simulation.
        codec: converter of actions.
        given: factors fixed by the options of a reset.
        plant: name of the machine of the episode; empty for the model.
        episodes: the episode; None before the first reset.
        over: whether the last block has been ground.
        blocks: blocks since the reset, as `simulation.writer` takes them.
        outcomes: outcome of each block.

    Raises:
        GrindError: an argument is not legal.
    """

    metadata = METADATA

    def __init__(
        self,
        simulation: Simulation,
        *,
        show_block: bool = False,
        action: str = "box",
        render_mode: str | None = None,
        info: str = "measured",
        out_of_range: str | None = None,
    ) -> None:
        check_flags(show_block=show_block)
        check_render(render_mode, RENDER_MODES)
        self.simulation, self.task = simulation, simulation.task
        self.codec = ActionCodec(self.task, action, predress=simulation.pre_dress, out_of_range=out_of_range)
        self.infos = InfoWriter(simulation, self.codec.names, info)
        self.render_mode = render_mode
        self.follower: frames.Follower | None = None
        self.show_block = show_block
        self.action_space: spaces.Space[Any] = self.codec.space
        self.observation_space = shown_space(simulation)
        self.given = Given()
        self.plant = ""
        self.episodes: Episodes | None = None
        self.over = False
        self.blocks: list[Any] = []
        self.outcomes: list[Outcome] = []

    def observation_info(self) -> tuple[Reading, ...]:
        """Return name, unit, scale, noise and meaning of every entry of the observation."""
        return self.simulation.entries

    def written(self) -> Written:
        """Return the episode for the machine: part program, job, and times at which the operator asks for a dress.

        Raises:
            gymnasium.error.ResetNeeded: before the first step of the episode.
            GrindError: no single program text can hold the choices.
        """
        written = self.simulation.writer.written(self._ground(), 0, self.blocks)
        return written._replace(job=replace(written.job, plant=self.plant))

    def part_program(self) -> str:
        """Return the steps taken since the last reset as a part program with its dress program.

        A user's own program has the chosen words in the blocks that were run, and its own words in the others.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            JobProgramError: a block of a subprogram was run with different words, which no single text can hold.
        """
        if self.episodes is None:
            raise gym.error.ResetNeeded("no episode has begun: call reset() first")
        return self.simulation.writer.program(self.blocks)

    def record(self) -> GrindingRecord:
        """Return strokes, dresses and finished parts since the last reset, as `machine.grind` records them.

        Raises:
            gymnasium.error.ResetNeeded: before the first step of the episode.
        """
        record = self.simulation.writer.record(self._ground(), 0, self.blocks)
        return replace(record, job=replace(record.job, plant=self.plant))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Start an episode; the same seed draws the same episode.

        Args:
            seed: seed of the generator; without one the generator continues.
            options: `"context"`, `"split"` and `"plant"`, see `grind_env.envs.reset_options`; they hold until changed.

        Returns:
            The observation; and an info with the name of the machine if the environment was made with a plant.

        Raises:
            ContextError: if an option is not legal.
            PlantError: there is no such machine.
            OtherMachine: the environment was not made for it.
        """
        simulation = self.simulation
        given = read_options(self.task, options, self.given, simulation.unfixable, simulation.plants)
        super().reset(seed=seed)
        self.given, self.over, self.blocks, self.outcomes = given, False, [], []
        rngs = [self.np_random]
        [given] = with_machines(simulation, [given], rngs)
        self.plant = "" if given.plant is None else given.plant.text
        if self.episodes is None:
            self.episodes = simulation.start(rngs, [given], full_tape=False)
        else:
            simulation.restart_all(self.episodes, [0], rngs, [given])
        self._follow()
        return simulation.observe(self.episodes)[0], {"plant": self.plant} if self.plant else {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Grind one block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last block.
            ActionError: if the action is not in the action space.
            GrindError: the control or the machine refuses the block; nothing has then been ground.
        """
        simulation, episodes = self.simulation, self.episodes
        if episodes is None or self.over:
            raise gym.error.ResetNeeded("the episode has not begun or is over: call reset() before step()")
        choice = simulation.applied_choice(episodes, self.codec.choose(self.codec.single(action)))
        chosen = [values.item() for values in choice]
        block = simulation.writer.block(episodes, 0, *chosen)
        outcomes, _ = simulation.step(episodes, *choice)
        outcome = Outcome(*outcomes[0].tolist())
        self.blocks.append(block)
        self.outcomes.append(outcome)
        self._follow()
        observation = simulation.observe(episodes)[0]
        info = self.infos.single(outcome, observation, chosen)
        if self.show_block:
            info["block"] = simulation.writer.text(block)
        self.over = simulation.over(episodes).item()
        return observation, outcome.reward, self.over, False, info

    def view(self) -> EpisodePicture:
        """Return the machine after the last block, as data of a picture.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self.episodes is None:
            raise gym.error.ResetNeeded("there is nothing to show yet: call reset() before render()")
        return self.simulation.viewer.view(self.episodes, 0, self.blocks, self.outcomes)

    def render(self) -> Any:
        """Show the state after the last step; return a picture, uint8 of shape (540, 960, 3), a text, or None."""
        view = self.view()
        if self.render_mode is None:
            gym.logger.warn("render() shows nothing: make the env with render_mode='rgb_array', 'human' or 'ansi'")
            return None
        if self.render_mode == "ansi":
            return terminal_view.panel(view)
        if self.render_mode == "rgb_array":
            return frames.render(view)
        self.follower = self.follower or frames.Follower(view.extent.title)
        self.follower.show(view)
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self.follower is not None:
            self.follower.close()
            self.follower = None

    def _follow(self) -> None:
        if self.render_mode == "human":
            self.render()

    def _ground(self) -> Episodes:
        if self.episodes is None or not self.blocks:
            raise gym.error.ResetNeeded("nothing has been ground: call reset() and step() first")
        return self.episodes
