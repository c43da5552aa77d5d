"""`grind/Stroke-v0`: every stroke of the table is a step."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.control import read
from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_flags, is_full, refuse_cycle, refuse_predress, refuse_render
from grind_env.envs.contexts import CONTEXT_FACTORS, Given, read_options
from grind_env.envs.gauges import scaled
from grind_env.envs.infos import info_of_costs
from grind_env.envs.observations import Reading, bounds
from grind_env.envs.reciprocation.program import request_times
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.simulation import Simulation
from grind_env.envs.stroke.episode import StrokeEpisode
from grind_env.envs.stroke.readings import StrokeGauges, stroke_readings
from grind_env.envs.stroke.view import block_of_stroke, stroke_view
from grind_env.envs.tasks import Task, read_task
from grind_env.machine.part import PartRun
from grind_env.process.state import WheelState
from grind_env.render.view import GroundBlock, View


class StrokeEnv(Showing, gym.Env[NDArray[np.float32], Any]):
    """Choose the table speed of every stroke, and whether the wheel is dressed before it.

    ## Description

    The plates of `grind/PowerLimited-v0`, ten to an episode, at the grain of the table: after every pick the agent
    chooses **E** for the next stroke and whether to ask the control for a dress now. In the program G81 keeps the table
    going, each `G01 Y.. E..` makes a pick and changes the table speed, and a dress is the operator's request. Before
    the first stroke of a part it is the pre-dress of G81.1. A part is ground in picks of 0.02 mm, the last one
    shortened, and two spark-out strokes.

    ## Action space

    By default `Box(-1, 1, (2,), float32)`: E geometric from 3 to 30 m/min; a dress if the second component is 0 or
    more. The other forms are those of `GrindEnv`, with D the number of dresses before the stroke, 0 or 1. There is no
    third component for a pre-dress, because D is one: before the first stroke of a part it is that of G81.1.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, scaled to about -1..1. `observation_info()` lists
    every entry. `observation="full"` adds the hidden state of the wheel and of the lot.

    ## Reward

    Minus the cost of the stroke in units of `task.reference_cost`: machine time (the first stroke of a part with its
    loading), wheel, dresser, with the last stroke of a part the expected cost of scrap, and with the last of all the
    price of handing over a dull wheel. The best fixed plan earns about -1 a stroke. `info["reward_terms"]` holds the
    terms, `info["cost"]` the probability that a part finished by the stroke is scrap.

    ## Episode

    Starts with a freshly dressed wheel and ends `terminated` with the last part. Everything random is drawn at reset.

    Args:
        observation: `"measured"` or `"full"`.
        show_block: put the blocks of the program that led to the stroke into `info["block"]`, a line each.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: False; D is the pre-dress.
        render_mode: as for `GrindEnv`.
        cycle: None; there is no cycle to choose.
    """

    def __init__(
        self,
        observation: str = "measured",
        show_block: bool = True,
        action: str = "box",
        predress: bool = False,
        render_mode: str | None = None,
        cycle: str | None = None,
    ) -> None:
        check_flags(show_block=show_block, predress=predress)
        refuse_predress(predress, "D = 1 in grind/Stroke-v0 is the dress before the stroke, also the first one's G81.1")
        refuse_cycle(cycle, "every part of grind/Stroke-v0 is ground by G81 and the picks of the agent's steps")
        refuse_render(render_mode, RENDER_MODES)
        self.task = read_task("stroke")
        self.full = is_full(observation)
        self.show_block, self.render_mode = show_block, render_mode
        self.entries = stroke_readings(self.task, full=self.full)
        self.codec = ActionCodec(self.task, action)
        self.action_space: spaces.Space[Any] = self.codec.space
        self.observation_space = spaces.Box(*bounds(self.entries), dtype=np.float32)
        self.simulation = Simulation(self.task)
        self.given = Given()
        self.episode: StrokeEpisode | None = None
        self.gauges = StrokeGauges()
        self.noise: NDArray[np.float64] = np.zeros(0)
        self.made = 0
        self.ground: list[GroundBlock] = []
        self.part: PartRun | None = None
        self.text = ""

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.entries

    def part_program(self) -> str:
        """The strokes made since the last reset as a part program with its dress program."""
        return self._begun().program.text()

    def operator_dress_at(self) -> tuple[float, ...]:
        """Times of the control, s, at which the operator asks for a dress when that program runs."""
        return request_times(read(self.part_program()), self._begun().job.control)

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
        self.given = given
        drawn = self.simulation.start([self.np_random], [given])
        self.episode = StrokeEpisode(self.task, drawn.tape[0], WheelState(*drawn.wheels[0].tolist()))
        noise = self.task.spread.measurement if math.isnan(given.fixed.noise) else given.fixed.noise
        self.noise = noise * self.np_random.standard_normal(most_strokes(self.task))
        self.gauges, self.made = StrokeGauges(), 0
        self.ground, self.part, self.text = [], self.episode.part, ""
        self.follow()
        return self._observation(), {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Make a stroke.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last stroke.
            ActionError: the action is not in the action space.
        """
        episode = self._begun()
        if episode.part is None:
            raise gym.error.ResetNeeded("the last part is finished: call reset() before step()")
        E, D = (float(values[0]) for values in self.codec.choose(self.codec.single(action)))
        dress = D > 0.0
        part, lines, number = episode.part, len(episode.program.lines), episode.part.number - 1
        run = episode.step(E, dress)
        self.gauges.note(run, E, dress, self.noise[self.made], episode, number)
        self.made += 1
        self.part, self.text = part, "\n".join(episode.program.lines[lines:])
        self.ground.append(block_of_stroke(run, E, dress, part, episode.job.limits))
        self.follow()
        info = info_of_costs(
            run.costs,
            self.task.reference_cost,
            finished=float(run.finished is not None),
            good=0.0 if run.finished is None else float(run.finished["survival"]),
            seconds=run.seconds,
            speed=E,
            executions=D,
        )
        if self.show_block:
            info["block"] = self.text
        reward = -info["block_cost"] / self.task.reference_cost
        return self._observation(), reward, episode.part is None, False, info

    def view(self) -> View:
        """The machine after the last stroke.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        episode = self._begun()
        assert self.part is not None  # the reset has loaded one
        return stroke_view(episode, self.ground, self.part, self.text)

    def _begun(self) -> StrokeEpisode:
        if self.episode is None:
            raise gym.error.ResetNeeded("no episode has begun: call reset() first")
        return self.episode

    def _observation(self) -> NDArray[np.float32]:
        return scaled(self.gauges.values(self._begun()), self.entries)


def most_strokes(task: Task) -> int:
    """Strokes of an episode whose parts all have the greatest stock that a context can fix.

    The count of random numbers depends on the task only, never on what they turn out to be or on what is given.
    """
    kind = task.kinds[0]
    return task.blocks * (int(CONTEXT_FACTORS["stock"].high * kind.stock / kind.pick) + kind.sparkout + 2)
