"""The user's own job: every cycle block of a part program is a step."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env import examples
from grind_env.control import Programs, read_file
from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import (
    check_file,
    check_flags,
    check_number,
    check_parts,
    is_full,
    refuse_cycle,
    refuse_predress,
    refuse_render,
)
from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.contexts import Given, read_options
from grind_env.envs.infos import InfoWriter
from grind_env.envs.job.outline import BlockOutline
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.job.tape import JobTape, barred_factors
from grind_env.envs.job.text import MOST_PARTS, batch_name, repeated, with_words_chosen
from grind_env.envs.job.view import RunBlock, job_view, text_of
from grind_env.envs.observations import Reading
from grind_env.envs.program_episode import ProgramEpisode
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.shown import shown_space
from grind_env.envs.simulation import Episodes
from grind_env.files import beside
from grind_env.machine.job import Job, JobError
from grind_env.machine.job_file import load_job
from grind_env.machine.record import GrindingRecord
from grind_env.render.view import View

MOST_SPREAD = 2.0
"""Highest factor on all that is random."""

EXAMPLE = examples.path("plate_g82.nc")
"""The program that the environment steps if none is given."""


class JobEnv(Showing, gym.Env[NDArray[np.float32], Any]):
    """Choose the table speed and the dressing of every cycle block of a part program.

    ## Description

    Before every G81, G82 or G83 the program takes E and D from the agent in place of those in the block, and goes on to
    the next cycle block. A step is therefore everything from one cycle block to the next one. The program is run in
    compiled code if it alone settles where the strokes lie, and by the control if the wheel, the operator or a grooving
    cycle has a say (`why_not_replayed` says it). `part_program()` is the program with the words chosen; `machine.grind`
    runs it to the same record. A cycle block that runs more than once, in a subprogram that M98 calls several times, is
    several steps, and no one text holds what was chosen for them: write such calls out where the program is to be taken
    back to the machine.

    With `parts` the program is run for a batch: the operator loads the next part where it ends, the wheel carries over,
    and lots and stocks change as the job's `[lots]` says. A program that loads its parts itself (M00) needs none.

    ## Action space

    By default `Box(-1, 1, (2,), float32)`: E geometric from 3 to 30 m/min, D = 0 up to 1/3 and 1 to 3 in equal bins
    above. The other forms are those of `GrindEnv`, with E in mm/min for a program in inches, too. In a G81, which has
    no D word, and in a block for which no dress program P is known, D has no effect (`info["D"]` is then 0). There is
    no third component for a pre-dress: it is not a word of the block but another code, and whether a G82 is a G82.1 the
    program says.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, and the coming block, scaled to about -1..1.
    `observation_info()` lists every entry; what is the same in all blocks of the program is none, so that two programs
    may have observations of different length. `observation="full"` adds the hidden state of the wheel and of the lot,
    behind all that is measured.

    ## Reward

    Minus the cost of the step in units of `reference_cost`, which is what a cycle block costs when the program runs
    with its own words on nominal parts: a program with good words earns about -1 a step. `info["reward_terms"]` holds
    the terms: machine time, wheel, dresser, the expected cost of scrap when a part is finished, and with the last
    block the price of handing over a dull wheel. `info["cost"]` is the expected number of parts scrapped, and the
    ratios of burning, power and Ra to their limits are those of `GrindEnv`. No cost is negative, so no step earns more
    than 0. No lower bound is known: what the program does between two of its cycle blocks, and how often it strokes
    while a G81 reciprocates, is up to the program.

    ## Episode

    The program from its start to its end, `parts` times, where it is `terminated`. Wheel, coolant and lots of material
    differ from episode to episode as in the other tasks; everything random is drawn at reset. `reset(options=...)`
    fixes the factors of lot, wheel, coolant and noise or restricts what they are drawn from
    (`grind_env.envs.contexts`); stock and material are those of the job.

    Args:
        program: file of the part program; the example plate if not given.
        job: its job file; the program's name with `.toml` if not given.
        parts: how often the program is run.
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
        parts: int = 1,
    ) -> None:
        check_flags(show_block=show_block, predress=predress)
        refuse_predress(predress, "the program says where a cycle of grind/Job-v0 is a G82.1")
        refuse_cycle(cycle, "the program of grind/Job-v0 says which cycles it runs")
        refuse_render(render_mode, RENDER_MODES)
        self.simulation = load_simulation(program, job, parts, spread, observation)
        self.spread, self.show_block, self.render_mode = spread, show_block, render_mode
        self.codec = ActionCodec(self.simulation.task, action)
        self.infos = InfoWriter(self.simulation.task, self.codec.names)
        self.action_space: spaces.Space[Any] = self.codec.space
        self.observation_space = shown_space(self.simulation)
        self.given = Given()
        self.episodes: Episodes | None = None
        self.ground: list[RunBlock] = []
        self.outcomes: list[Outcome] = []

    @property
    def programs(self) -> Programs:
        """The program; of a batch, with all its parts."""
        return self.simulation.programs

    @property
    def job(self) -> Job:
        """The job."""
        return self.simulation.job

    @property
    def blocks(self) -> tuple[BlockOutline, ...]:
        """The cycle blocks of the program."""
        return self.simulation.blocks

    @property
    def entries(self) -> tuple[Reading, ...]:
        """Of the observation."""
        return self.simulation.entries

    @property
    def reference_cost(self) -> float:
        """What a reward of -1 stands for, $."""
        return self.simulation.task.reference_cost

    @property
    def why_not_replayed(self) -> str | None:
        """Why the control has to execute the program step by step; None if compiled code runs it."""
        return None if self.simulation.why is None else str(self.simulation.why)

    @property
    def tape(self) -> JobTape | None:
        """What was drawn for the episode; None before the first reset."""
        return None if self.episodes is None else self.simulation.tape(self.episodes, 0)

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.entries

    def part_program(self) -> str:
        """The program with the words chosen since the last reset; later blocks keep their own.

        Raises:
            JobProgramError: a block of a subprogram has been run with different words, so that no text says both.
        """
        words = [self.simulation.words(*block) for block in self.ground]
        chosen = zip((self.blocks[block.number].block for block in self.ground), words, strict=True)
        return with_words_chosen(self.programs, list(chosen))

    def part_job(self) -> Job:
        """The job of that program: `machine.grind` makes of both what the episode was, with its lots and stocks.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        tape = self.simulation.tape(self._begun(), 0)
        return replace(self.job, parts=tape.conditions)

    def record(self) -> GrindingRecord:
        """Strokes, dresses and finished parts since the last reset, as `machine.grind` records them.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        tape = self.simulation.tape(self._begun(), 0)
        program = ProgramEpisode(self.programs, self.job, tape.conditions)
        for block in self.ground:
            program.step(self.simulation.words(*block))
        return program.run.record()

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
        given = read_given(self.simulation, options, self.given)
        super().reset(seed=seed)
        self.given, self.ground, self.outcomes = given, [], []
        if self.episodes is None:
            self.episodes = self.simulation.start([self.np_random], [given])
        else:
            self.simulation.restart(self.episodes, 0, self.np_random, given)
        self.follow()
        return self.simulation.observe(self.episodes)[0], {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Run a cycle block and on to the next one.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the last block.
            ActionError: the action is not in the action space.
            GrindError: the control or the machine refuses the block; nothing has then been ground.
        """
        simulation, episodes = self.simulation, self._begun()
        number = int(episodes.block[0])
        if number >= len(self.blocks):
            raise gym.error.ResetNeeded("the program has come to its end: call reset() before step()")
        choice = simulation.taken(episodes, self.codec.choose(self.codec.single(action)))
        speeds, executions = choice
        outcomes, _ = simulation.step(episodes, speeds, executions)
        outcome = Outcome(*outcomes[0].tolist())
        self.ground.append(RunBlock(number, float(speeds[0]), int(executions[0])))
        self.outcomes.append(outcome)
        self.follow()
        info = self.infos.single(outcome, choice)
        if self.show_block:
            info["block"] = text_of(simulation, self.ground[-1])
        terminated = number + 1 == len(self.blocks)
        return simulation.observe(episodes)[0], outcome.reward, terminated, False, info

    def view(self) -> View:
        """The machine after the last block.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        speeds = self.codec.low, self.codec.high
        return job_view(self.simulation, self._begun(), 0, self.ground, self.outcomes, speeds)

    def _begun(self) -> Episodes:
        if self.episodes is None:
            raise gym.error.ResetNeeded("no episode has begun: call reset() first")
        return self.episodes


def load_simulation(program: str | None, job: str | None, parts: int, spread: float, observation: str) -> JobSimulation:
    """The simulation of a program in a file; arguments as for `JobEnv`.

    Raises:
        GrindError: the program or the job cannot be run, or an argument is not legal.
    """
    check_file("program", program)
    check_file("job", job)
    check_number("spread", spread, 0.0, MOST_SPREAD)
    check_parts(parts, MOST_PARTS)
    full = is_full(observation)
    path = EXAMPLE if program is None else Path(program)
    programs = repeated(read_file(path), parts)
    settings = load_job(beside(path, ".toml") if job is None else job)
    if settings.parts:
        message = "the job says how each part differs, but here lots and stocks are drawn; leave [[parts]] out of it"
        raise JobError(message, "parts")
    file = "" if path.resolve().parent == EXAMPLE.parent.resolve() else str(path)
    return JobSimulation(programs, settings, spread, full=full, name=batch_name(path, parts), file=file)


def read_given(simulation: JobSimulation, options: Mapping[str, Any] | None, before: Given) -> Given:
    """What the options of a reset give; what they do not name stays as it was `before`.

    Raises:
        ContextError: if an option is not legal.
    """
    return read_options(simulation.task, options, before, barred_factors(simulation.spread))
