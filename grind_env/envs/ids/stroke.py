"""`grind/Stroke-v0`: E and dressing of every stroke."""

from grind_env.envs.arguments import check_flags, is_full, refuse_cycle, refuse_predress
from grind_env.envs.blocks.program import check_task
from grind_env.envs.env import GrindEnv
from grind_env.envs.machines import plants_of
from grind_env.envs.showing import renders
from grind_env.envs.strokes.simulation import StrokeSimulation
from grind_env.envs.tasks import read_task
from grind_env.envs.vector_env import side_by_side


@renders
def make(
    observation: str = "measured",
    show_block: bool = True,
    action: str = "box",
    predress: bool = False,
    render_mode: str | None = None,
    cycle: str | None = None,
    plant: str | None = None,
    info: str = "measured",
) -> GrindEnv:
    """Choose the table speed of every stroke, and whether the wheel is dressed before it.

    ## Description

    The plates of `grind/PowerLimited-v0`, ten to an episode, at the grain of the table: after every pick the agent
    chooses **E** for the next stroke and whether to ask the control for a dress now. In the program G81 keeps the table
    going, each `G01 Y.. E..` makes a pick and changes the table speed, and a dress is the operator's request. Before
    the first stroke of a part it is the pre-dress of G81.1. A part is ground in picks of 0.02 mm, the last one
    shortened, and two spark-out strokes.

    ## Action space

    By default `Box(-1, 1, (2,), float32)`: E geometric from 3 to 30 m/min; a dress if the second component is above
    1/3. The other forms are those of `GrindEnv`, with D the number of dresses before the stroke, 0 or 1. There is no
    third component for a pre-dress, because D is one: before the first stroke of a part it is that of G81.1.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, scaled to about -1..1. `observation_info()` lists
    every entry. `observation="full"` adds the hidden state of the wheel and of the lot, behind all that is measured.
    Before the first stroke of a part its stock is known by the pre-gauge only, which `strokes_left` then follows.

    ## Reward

    Minus the cost of the stroke in units of `task.reference_cost`: machine time (the first stroke of a part with its
    loading), wheel, dresser, with the last stroke of a part the expected cost of scrap, and with the last of all the
    price of handing over a dull wheel. The best fixed plan earns about -1 a stroke. `info["reward_terms"]` holds the
    terms, `info["cost"]` 1 if a part finished by the stroke is found bad; all else is as for `GrindEnv`, with
    `info="full"` of the stroke and of the surface that it leaves.

    ## Episode

    Starts with a freshly dressed wheel and ends `terminated` with the last part. Everything random is decided at reset.

    Args:
        observation: `"measured"` or `"full"`.
        show_block: put the blocks of the program that led to the stroke into `info["block"]`, a line each.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: False; D is the pre-dress.
        render_mode: as for `GrindEnv`.
        cycle: None; there is no cycle to choose.
        plant: name of a machine that is not the model, as `"meter:7"`, or without a seed of those that every episode
            draws one from, as `"meter"` or `"held-out"`; `"module:name"` for one's own (`grind_env.plants`).
        info: `"measured"` for what a shop knows of a step, or `"full"` for chances and true ratios in place of it.
    """
    full = is_full(observation)
    check_flags(predress=predress)
    refuse_predress(predress, "D = 1 in grind/Stroke-v0 is the dress before the stroke, also the first one's G81.1")
    refuse_cycle(cycle, "every part of grind/Stroke-v0 is ground by G81 and the picks of the agent's steps")
    task = read_task("stroke")
    check_task(task)
    simulation = StrokeSimulation(task, full=full, plants=plants_of(plant))
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode, info=info)


make_vector = side_by_side(make)
