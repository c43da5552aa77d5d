"""`grind/WidePlates-v0`: plates wider than the wheel, ground in G83 cross picks."""

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
    cycle: str = "G83",
    render_mode: str | None = None,
    plant: str | None = None,
    info: str = "measured",
    out_of_range: str | None = None,
) -> GrindEnv:
    """Choose the table speed and the dressing of every part that is ground in strips.

    ## Description

    The plates are 60 mm wide, the wheel 25 mm. A step is one part: `G83 X.. I.. Y.. J.. Z.. K.. L.. F.. E.. P.. D..`
    plunges at either end of the crossover and moves the wheel across by K at every reversal, so that one traverse
    grinds the plate in overlapping strips. Where it plunges, the wheel cuts over its whole width and is pressed back
    more than in the strips that follow: these come out deeper. This **taper** grows with the force, and so with E and
    with the wear flats of the wheel; the wear of its radius adds to the mean size error, until a dress sets the wheel
    to size anew. The taper is measured on every part, and a part is judged where it is farthest from its size: by the
    stock left on the strip that has most of it, or that is cut deepest below its size. The wheel has one radius over
    its width: the steps that wear makes on the face of a wheel whose leading edge takes the depth are not modelled.

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
        plant: name of a machine that is not the model, as `"meter:7"`, or without a seed of those that every episode
            draws one from, as `"meter"` or `"held-out"`; `"module:name"` for one's own (`grind_env.plants`).
        info: `"measured"` for what a shop knows of a step, or `"full"` for chances and true ratios in place of it.
        out_of_range: what happens to actions beyond the bounds of the action space: `"clip"` or `"raise"`. By default
            `"clip"` for `action="box"`, with one warning, and `"raise"` for the other forms.
    """
    simulation = simulation_of(read_task("wide_plates"), observation, predress, cycle, plant=plant)
    return GrindEnv(
        simulation, show_block=show_block, action=action, render_mode=render_mode, info=info, out_of_range=out_of_range
    )


make_vector = side_by_side(make)
