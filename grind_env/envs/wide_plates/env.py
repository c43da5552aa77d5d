"""`grind/WidePlates-v0`: parts wider than the wheel, ground with the cross picks of a G83."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from grind_env.control import read
from grind_env.envs.blocks.program import conditions, job_from_surface
from grind_env.envs.env import GrindEnv
from grind_env.envs.tasks import read_task
from grind_env.machine.grind import grind
from grind_env.machine.job import WheelStart
from grind_env.machine.record import GrindingRecord
from grind_env.process.state import WheelState

TASK = "wide_plates"


class WidePlatesEnv(GrindEnv):
    """Choose the table speed and the dressing of every part that is ground in strips.

    ## Description

    The plates are 60 mm wide, the wheel 25 mm. A step is one part: `G83 X.. I.. Y.. J.. Z.. K.. L.. F.. E.. P.. D..`
    plunges at either end of the crossover and moves the wheel across by K at every reversal, so that one traverse
    grinds the plate in overlapping strips. Where it plunges, the wheel cuts over its whole width and is pressed back
    more than in the strips that follow: these come out deeper. This **taper** grows with the force, and so with E and
    with the wear flats of the wheel; the wear of its radius adds to the mean size error, until a dress sets the wheel
    to size anew. The taper is measured on every part, and a part is judged where it is farthest from its size: by the
    stock left on the strip that has most of it, or that is cut deepest below its size.

    `part_program()` is the episode as a program, and `record()` what `machine.grind` makes of it. Actions, reward and
    episode are those of `GrindEnv`, with E from 3 to 30 m/min and D from 0 to 3; `predress=True` lets an action ask for
    the G83.1 form.

    Args:
        observation: `"measured"` or `"full"`; `"measured"` by default.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: let an action ask for a dress before the first stroke, G83.1.
        cycle: the cycle, `"G83"`; G82 is refused, since the plates are wider than the wheel.
        render_mode: as for `GrindEnv`.
    """

    load = staticmethod(read_task)

    def __init__(
        self,
        observation: str | None = None,
        show_block: bool = True,
        action: str = "box",
        predress: bool = False,
        cycle: str = "G83",
        render_mode: str | None = None,
    ) -> None:
        super().__init__(TASK, observation, show_block, action, predress, cycle, render_mode)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """As `GrindEnv.reset`."""
        observation, info = super().reset(seed=seed, options=options)
        assert self.episodes is not None
        self.first_wheel = WheelState(*self.episodes.wheels[0].tolist())
        return observation, info

    def record(self) -> GrindingRecord:
        """Strokes, dresses and finished parts since the last reset: the part program, ground.

        Raises:
            gymnasium.error.ResetNeeded: before the first step of the episode.
        """
        if self.episodes is None or not self.blocks:
            raise gym.error.ResetNeeded("nothing has been ground: call reset() and step() first")
        job, start, wheel = job_from_surface(self.task), self.task.start, self.first_wheel
        found = WheelStart(
            diameter=wheel.ds,
            diamond_flat=wheel.wd,
            wear_flat_area=start.wear_flat_area,
            volume_since_dress=start.volume,
        )
        parts = conditions(self.task, self.episodes.tape[0])[: len(self.blocks)]
        return grind(read(self.part_program()), replace(job, wheel=found), conditions=parts)
