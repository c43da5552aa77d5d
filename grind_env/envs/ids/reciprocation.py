"""`grind/Reciprocation-v0`: G81 with a continuous infeed."""

from grind_env.envs.any_task import simulation_of
from grind_env.envs.env import GrindEnv, renders
from grind_env.envs.tasks import read_task
from grind_env.envs.vector_env import side_by_side


@renders
def make(
    observation: str | None = None,
    show_block: bool = False,
    action: str = "box",
    predress: bool = False,
    render_mode: str | None = None,
    plant: str | None = None,
    info: str = "measured",
    out_of_range: str | None = None,
) -> GrindEnv:
    """Choose the table speed and the dressing of every part that is ground with a continuous infeed.

    ## Description

    A step is one part: `G81 X.. I.. E.. P..` sets the table going, `G01 Y.. F..` feeds the wheel down at 0.5 mm/min
    while it reciprocates, a dwell sparks out, and `G80` stops it. A stroke is as deep as the infeed goes in its time,
    so that it gets thinner as **E** rises, and heavier on the wheel as E falls. G81 has no D word: the agent's **D**
    is that many requests of the operator for a dress, at equal fractions of depth, each of which the control serves
    at the next reversal point. Plates, wheel and what is random are those of `grind/PowerLimited-v0`.

    Actions, observation, reward and episode are those of `GrindEnv`, with E from 3 to 30 m/min and D from 0 to 3;
    `predress=True` lets an action ask for the G81.1 form. The coming block has no pick to be observed; `last_pick` is
    what the infeed covered in a stroke of the last block. `info["block"]` holds all blocks of the step, a line each.

    `part_program()` is the episode as a program; `operator_dress_at()` says when the operator has to ask for a dress.

    Args:
        observation: `"measured"` or `"full"`; `"measured"` by default.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: let an action ask for a dress before the first stroke, G81.1.
        render_mode: as for `GrindEnv`.
        plant: name of a machine that is not the model, as `"meter:7"`, or without a seed of those that every episode
            draws one from, as `"meter"` or `"held-out"`; `"module:name"` for one's own (`grind_env.plants`).
        info: `"measured"` for what a shop knows of a step, or `"full"` for chances and true ratios in place of it.
        out_of_range: what happens to actions beyond the bounds of the action space: `"clip"` or `"raise"`. By default
            `"clip"` for `action="box"`, with one warning, and `"raise"` for the other forms.
    """
    simulation = simulation_of(read_task("reciprocation"), observation, predress, plant=plant)
    return GrindEnv(
        simulation, show_block=show_block, action=action, render_mode=render_mode, info=info, out_of_range=out_of_range
    )


make_vector = side_by_side(make)
