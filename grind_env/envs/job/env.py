"""The user's own job: every cycle block of a part program is a step."""

from collections.abc import Callable, Mapping
from copy import copy
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.control import Programs, read_file
from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import (
    check_file,
    check_flags,
    check_number,
    is_full,
    refuse_cycle,
    refuse_predress,
    refuse_render,
)
from grind_env.envs.contexts import Given, read_options
from grind_env.envs.infos import info_of_costs
from grind_env.envs.job.outline import Choice, Outline, costs, handover, outline
from grind_env.envs.job.program import with_words_chosen
from grind_env.envs.job.readings import Gauges, coming, hidden, job_task, readings, scaled
from grind_env.envs.job.tape import JobTape, barred_factors, draw
from grind_env.envs.job.view import block_of_run, job_view
from grind_env.envs.observations import Reading, bounds
from grind_env.envs.program_episode import ProgramEpisode, step_all
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.tape import FACTORS
from grind_env.machine.job_file import load_job
from grind_env.machine.record import GrindingRecord
from grind_env.render.view import GroundBlock, View

MOST_SPREAD = 2.0
"""Highest factor on all that is random."""

EXAMPLE = Path(__file__).parents[2] / "examples" / "plate_g82.nc"
"""The program that the environment steps if none is given."""


class JobEnv(Showing, gym.Env[NDArray[np.float32], Any]):
    """Choose the table speed and the dressing of every cycle block of a part program.

    ## Description

    The control executes the program; before every G81, G82 or G83 it stops, takes E and D from the agent in place of
    those in the block, and goes on to the next cycle block. A step is therefore everything from one cycle block to
    the next one. `part_program()` is the program with the words chosen; `machine.grind` runs it to the same record.
    A cycle block that runs more than once, in a subprogram that M98 calls several times, is several steps, and no one
    text holds what was chosen for them: write such calls out where the program is to be taken back to the machine.

    ## Action space

    By default `Box(-1, 1, (2,), float32)`: E geometric from 3 to 30 m/min, D in equal-width bins from 0 to 3. The other
    forms are those of `GrindEnv`, with E in mm/min for a program in inches, too. In a G81, which has no D word, and in
    a block for which no dress program P is known, D has no effect (`info["D"]` is then 0). There is no third component
    for a pre-dress: it is not a word of the block but another code, and whether a G82 is a G82.1 the program says.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, and the coming block, scaled to about -1..1.
    `observation_info()` lists every entry. `observation="full"` adds the hidden state of the wheel and of the lot.

    ## Reward

    Minus the cost of the step in units of `reference_cost`, which is what a cycle block costs when the program runs
    with its own words on nominal parts: a program with good words earns about -1 a step. `info["reward_terms"]` holds
    the terms: machine time, wheel, dresser, the expected cost of scrap when a part is finished, and with the last
    block the price of handing over a dull wheel. `info["cost"]` is the expected number of parts scrapped. No cost is
    negative, so no step earns more than 0. No lower bound is known: what the program does between two of its cycle
    blocks, and how often it strokes while a G81 reciprocates, is up to the program.

    ## Episode

    The program from its start to its end, where it is `terminated`. Wheel, coolant and lots of material differ from
    episode to episode as in the other tasks; everything random is drawn at reset. `reset(options=...)` fixes the
    factors of lot, wheel, coolant and noise or restricts what they are drawn from (`grind_env.envs.contexts`); stock
    and material are those of the job.

    Args:
        program: file of the part program; the example plate if not given.
        job: its job file; the program's name with `.toml` if not given.
        observation: `"measured"` or `"full"`.
        spread: factor on all that is random; 0 for the nominal job with exact gauges.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: False; the program says which cycles begin with a dress.
        render_mode: as for `GrindEnv`.
        cycle: None; the program says which cycles it runs.

    Raises:
        GrindError: the program or the job cannot be run, or an argument is not legal.
    """

    def __init__(
        self,
        program: str | None = None,
        job: str | None = None,
        observation: str = "measured",
        spread: float = 1.0,
        show_block: bool = True,
        action: str = "box",
        predress: bool = False,
        render_mode: str | None = None,
        cycle: str | None = None,
    ) -> None:
        check_file("program", program)
        check_file("job", job)
        check_number("spread", spread, 0.0, MOST_SPREAD)
        check_flags(show_block=show_block, predress=predress)
        refuse_predress(predress, "the program says where a cycle of grind/Job-v0 is a G82.1")
        refuse_cycle(cycle, "the program of grind/Job-v0 says which cycles it runs")
        refuse_render(render_mode, RENDER_MODES)
        self.full = is_full(observation)
        path = EXAMPLE if program is None else Path(program)
        self.programs: Programs = read_file(path)
        self.job = load_job(path.with_suffix(".toml") if job is None else job)
        task = job_task(self.job, spread)
        self.codec = ActionCodec(task, action)
        speeds, most = (self.codec.low, self.codec.high), self.codec.executions
        extremes = [Choice(speeds[0], most), Choice(speeds[1], 0), Choice(speeds[1], most)]
        self.outline: Outline = outline(self.programs, self.job, extremes)
        self.spread = spread
        self.show_block, self.render_mode = show_block, render_mode
        self.entries = readings(task, full=self.full)
        self.action_space: spaces.Space[Any] = self.codec.space
        self.observation_space = spaces.Box(*bounds(self.entries), dtype=np.float32)
        self.given = Given()
        self.tape: JobTape | None = None
        self.episode: ProgramEpisode | None = None
        self.gauges = Gauges()
        self.ground: list[GroundBlock] = []
        self.text = ""

    @property
    def reference_cost(self) -> float:
        """What a reward of -1 stands for, $."""
        return self.outline.cost

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.entries

    def part_program(self) -> str:
        """The program with the words chosen since the last reset; later blocks keep their own.

        Raises:
            JobProgramError: a block of a subprogram has been run with different words, so that no text says both.
        """
        return with_words_chosen(self.programs, [] if self.episode is None else self.episode.chosen)

    def record(self) -> GrindingRecord:
        """Strokes, dresses and finished parts since the last reset.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        return self._begun()[0].run.record()

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
        given = self.read_given(options, self.given)
        super().reset(seed=seed)
        self.given = given
        plan = self.outline
        tape = draw(self.np_random, len(plan.blocks), plan.parts, self.spread, given)
        self.episode = ProgramEpisode(self.programs, self.job, tape.conditions)
        self.tape = tape
        self.gauges = Gauges()
        self.ground, self.text = [], ""
        self.follow()
        return self._observation(), {}

    def read_given(self, options: Mapping[str, Any] | None, before: Given) -> Given:
        """What the options of a reset give; what they do not name stays as it was `before`.

        Raises:
            ContextError: if an option is not legal.
        """
        return read_options(job_task(self.job, self.spread), options, before, barred_factors(self.spread))

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Run a cycle block and on to the next one.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last block.
            ActionError: the action is not in the action space.
            GrindError: the control or the machine refuses the block; nothing has then been ground.
        """
        episode, tape = self._begun()
        if episode.block is None:
            raise gym.error.ResetNeeded("the program has come to its end: call reset() before step()")
        E, D = (float(values[0]) for values in self.codec.choose(self.codec.single(action)))
        number = len(episode.chosen)
        block = self.outline.blocks[number]
        choice = Choice(E, int(D) if block.takes_dresses else 0)
        run = step_all([episode], {0: block.words(choice)})[0]
        terminated = episode.block is None
        self.gauges.note(run, choice, self.job, tape.noise[number])
        terms = costs(run, self.job) | {"handover": handover(episode.run, run.plan, self.job) if terminated else 0.0}
        cost = sum(terms.values())
        self.ground.append(
            block_of_run(run, choice._replace(speed=run.plan.feed), episode.run.part, self.job.limits, cost)
        )
        self.text = run.plan.text
        self.follow()
        info = info_of_costs(
            terms,
            self.reference_cost,
            finished=float(run.finished.size),
            good=float(run.finished["survival"].sum()),
            seconds=run.seconds,
            speed=run.plan.feed,
            executions=float(choice.executions),
        )
        if self.show_block:
            info["block"] = self.text
        return self._observation(), -cost / self.reference_cost, terminated, False, info

    def keep(self) -> Callable[[], None]:
        """Return a function that restores episode and generator to their present state."""
        random, state = self.np_random, self.np_random.bit_generator.state
        tape, episode, gauges, ground, text = self.tape, self.episode, copy(self.gauges), self.ground, self.text
        blocks = len(ground)

        def take_back() -> None:
            random.bit_generator.state = state
            if episode is not None and len(episode.chosen) > blocks:
                episode.rewind(blocks)
            del ground[blocks:]
            self.tape, self.episode, self.gauges, self.ground, self.text = tape, episode, gauges, ground, text

        return take_back

    def view(self) -> View:
        """The machine after the last block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        return job_view(self.outline, self._begun()[0], self.ground, self.text, (self.codec.low, self.codec.high))

    def _begun(self) -> tuple[ProgramEpisode, JobTape]:
        if self.episode is None or self.tape is None:
            raise gym.error.ResetNeeded("no episode has begun: call reset() first")
        return self.episode, self.tape

    def _observation(self) -> NDArray[np.float32]:
        episode, tape = self._begun()
        blocks, number = self.outline.blocks, len(episode.chosen)
        wheel = self.outline.wheel if episode.run.wheel is None else episode.run.wheel
        part = blocks[min(number, len(blocks) - 1)].part
        values = self.gauges.values(wheel) | {"remaining": (len(blocks) - number) / len(blocks)}
        if number < len(blocks):
            block = blocks[number]
            values |= coming(block) | {"new_lot": float(block.starts_part and tape.new_lot[part])}
        if self.full:
            factors = tape.conditions[part].factors
            values |= hidden(wheel, {name: factors[name] for name in FACTORS})
        return scaled(values, self.entries)
