"""Environments of tasks of blocks: the arguments of `gym.make`, and the simulation of a task.

The pages of the ids show the docstrings of `make` here and in the modules of `grind_env.envs.ids`.
"""

import inspect
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from grind_env.envs.arguments import check_flags, is_full
from grind_env.envs.blocks.task_job import check_task
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.docstring_sections import meanings
from grind_env.envs.env import GrindEnv, renders
from grind_env.envs.plant_options import plants_of
from grind_env.envs.tasks import Task, load_task, read_task
from grind_env.envs.vector_env import side_by_side

SPEEDS = 12  #: number of values of E that are tried, spaced geometrically over the range, if the task has no levels
INTERVALS = (1, 2, 3, 5, 8, 12, 20)  #: blocks from one dress to the next; plans without a dress are tried, too
EPISODES = 16  #: number of episodes of each plan
COST = Outcome._fields.index("cost")


def usual_cost(task: Task) -> float:
    """Return the mean cost of a block, $, with the cheapest fixed pair of E and dress interval.

    A dress has one execution. All plans grind the same few episodes, because lots, stocks and wheels decide the cost.
    """
    simulation = BlockSimulation(replace(task, reference_cost=1.0))
    tried = [float(round(speed)) for speed in np.geomspace(*task.action.speed_ends, SPEEDS)]
    if task.action.speed_levels is not None:
        tried = [*task.action.speed_levels]
    plans = np.array(list(product(tried, (0, *INTERVALS))))
    speeds, every = np.repeat(plans, EPISODES, axis=0).T
    episodes = simulation.start([np.random.default_rng(k % EPISODES) for k in range(len(speeds))])
    cost = np.zeros(len(speeds))
    for block in range(1, task.blocks + 1):
        dresses = (every > 0.0) & (block % np.maximum(every, 1.0) == 0.0)
        cost += simulation.step(episodes, speeds, dresses.astype(float))[0][:, COST]
    return float(cost.reshape(len(plans), EPISODES).mean(axis=1).min()) / task.blocks


def simulation_of(
    task: Task,
    observation: str | None = None,
    predress: bool = False,
    cycle: str | None = None,
    plant: str | None = None,
) -> BlockSimulation:
    """Return the simulation of a task of blocks; arguments as for `make`.

    Raises:
        TaskError: an argument is not legal.
        PlantError: there is no such machine.
    """
    check_flags(predress=predress)
    check_task(task, cycle)
    full = is_full(task.observation if observation is None else observation)
    if task.reference_cost == 0.0:
        task = replace(task, reference_cost=usual_cost(task))
    return BlockSimulation(task, full=full, pre_dress=predress, plants=plants_of(plant, task.plant))


@renders
def make(
    task: str = "power_limited",
    observation: str | None = None,
    show_block: bool = False,
    action: str = "box",
    predress: bool = False,
    cycle: str | None = None,
    render_mode: str | None = None,
    plant: str | None = None,
    info: str = "measured",
    out_of_range: str | None = None,
) -> GrindEnv:
    """Choose the table speed and the dressing of every cycle block of a batch.

    ## Description

    A step is one G82 cycle block of a surface grinder. The table reciprocates with feedrate **E**; the wheel plunges at
    every reversal point until the stock is removed, then sparks out. Within the cycle, the control runs the dress
    program **D** times at equal intervals of depth. (A task with an infeed has G81 blocks, a task with a cross pick G83
    blocks: see `grind/Reciprocation-v0` and `grind/WidePlates-v0`.) The wheel dulls, loads, and wears. Slow tables
    glaze the wheel and burn the part, fast tables cost power, roughness and size, and dressing costs time and wheel.

    ## Action space

    The default is `Box(-1, 1, (2,), float32)`. The first component chooses E from the speed range of the task (table
    below). The second component chooses D: 0 up to 1/3, above 1/3 in bins of equal width from 1 to the largest D. So an
    untrained policy dresses in the minority of its blocks. Other forms are `action="multidiscrete"`,
    `MultiDiscrete([levels, largest D + 1])`, `action="discrete"`, the pair as one number, and `action="dict"`,
    `{"E": mm/min, "D": executions}`. The two discrete forms have the levels of E of the task, or 24 that divide its
    range geometrically. `predress=True` adds a third component (a dress if it is above 0), factor or key: a dress
    before the first plunge, G82.1. `env.unwrapped.codec` converts both ways.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, scaled (see the table). `observation_info()`
    lists every entry; readings that never change in a task are left out. `observation="full"` adds the hidden state of
    the wheel and of the lot, after all measured entries.

    ## Reward

    Minus the cost of the block in units of `task.reference_cost`: machine time, wheel, dresser, the expected cost of
    scrap, and with the last block the price of handing over a dull wheel; where the task has them, lateness and wheel
    changes. The best fixed plan earns about -1 a step, a good policy -0.6; a scrapped part costs 10 and more. The
    `info` of a step holds the terms as `reward_time`, `reward_wheel` and so on, and what a shop knows. `info["cost"]`
    (not $) is 1 if this block finished a part that is found bad (more likely scrap than not), else 0. Further entries
    are `good_parts`, `block_cost`, `seconds` and the readings of meter and gauges. `power_ratio` and `roughness_ratio`
    are the last readings over their limits. With `info="full"`, `cost` and `good_parts` are probabilities, and the two
    ratios are the true ones of the block (0 where Ra has no limit). Then `burn_ratio` says how near the block came to
    burning: 1 is at the limit.

    A part is scrap because of its size, its Ra, its highest temperature rise, or a stalled spindle. The burn ratio
    (Malkin) only warns of heat: it scraps nothing.

    ## Episode

    An episode starts with a freshly dressed wheel (unless the task says otherwise) and is `terminated` after the last
    block. Everything random is decided at reset; `reset(options={"context": ..., "split": ...})` fixes factors or
    restricts their draws (`grind_env.envs.reset_options`). The observation does not show fixed factors: in a task
    of one material, the agent has to find out another material like a lot or a wheel.

    `env.spec.max_episode_steps` is one more than the steps of an episode. Wrappers such as `TimeAwareObservation` read
    this number, and a `TimeLimit` of this length truncates no episode. A `max_episode_steps` that you give to
    `gym.make` or `gym.make_vec` truncates.

    Args:
        task: name of a task, for example `"power_limited"`, or the path of a task file, such as `"shop.toml"`;
            `grind tasks --schema` lists its keys. `grind/Task-v0` takes any task; each other id fixes its task, because
            through `gym.make` another task would have the wrong id and reference scores.
        observation: `"measured"` or `"full"`; the default is that of the task: `"measured"` for all but Oracle6.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: let an action ask for a dress before the first plunge.
        cycle: leave it None; the task sets the cycle of its blocks.
        render_mode: `"rgb_array"` for a picture, `"human"` for a window that follows the
            episode (without a screen, text in the terminal), `"ansi"` for text.
        plant: name of an out-of-model machine: `"meter:7"`; `"meter"` or `"held-out"` to draw one in every episode;
            `"module:name"` for your own (`grind_env.plants`). The default is the machine of the task; for tasks of the
            package this is the model.
        info: `"measured"` for what a shop knows of a step, or `"full"` for probabilities and true ratios instead.
        out_of_range: what happens to actions beyond the bounds of the action space: `"clip"` or `"raise"`. By default
            `"clip"` for `action="box"`, with one warning, and `"raise"` for the other forms.
    """
    simulation = simulation_of(load_task(task), observation, predress, cycle, plant)
    return GrindEnv(
        simulation, show_block=show_block, action=action, render_mode=render_mode, info=info, out_of_range=out_of_range
    )


make_vector = side_by_side(make)
OF_SIMULATIONS = inspect.signature(simulation_of).parameters.keys() - {"task"}


def fixed(task: str, words: str) -> Callable[..., GrindEnv]:
    """Return the `make` of an id that fixes its task, with the text of its page and the other arguments of `make`."""

    @renders
    def made(**given: Any) -> GrindEnv:
        simulated = {name: given.pop(name) for name in OF_SIMULATIONS & given.keys()}
        return GrindEnv(simulation_of(read_task(task), **simulated), **given)

    signature, said = inspect.signature(make), meanings(make, "Args")
    _, *others = signature.parameters.values()
    arguments = "\n".join(f"    {each.name}: {said[each.name]}" for each in others)
    made.__name__ = made.__qualname__ = make.__name__
    made.__module__ = f"grind_env.envs.ids.{task}"
    made.__doc__ = f"{inspect.cleandoc(words)}\n\nArgs:\n{arguments}\n"
    vars(made)["__signature__"] = signature.replace(parameters=others)
    return made
