"""The ids in which E and D are chosen: the arguments that `gym.make` takes for each, and the simulation they make.

`grind_env.envs.env.GrindEnv` and `grind_env.envs.vector_env.GrindVectorEnv` are the environments of all of them. The
docstrings here are what the pages of the ids say.
"""

import inspect
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

from grind_env.control.options import variables_of
from grind_env.envs.arguments import check_flags, check_variables, is_full, refuse_cycle, refuse_predress
from grind_env.envs.blocks.program import check_task
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.env import GrindEnv
from grind_env.envs.infeed.simulation import InfeedSimulation
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.showing import METADATA
from grind_env.envs.strips.simulation import StripSimulation
from grind_env.envs.strokes.simulation import StrokeSimulation
from grind_env.envs.tasks import Task, load_task, read_task
from grind_env.envs.vector_env import GrindVectorEnv

Make = TypeVar("Make")

SIMULATIONS = {"G81": InfeedSimulation, "G82": BlockSimulation, "G83": StripSimulation}
"""What steps the blocks of a task, by their cycle."""
OF_VECTORS = inspect.signature(GrindVectorEnv).parameters.keys() - {"simulation", "num_envs"}
"""Arguments that a vector environment takes for itself."""


def renders(make: Make) -> Make:
    """Let a function that makes environments say how they render, as a class does: `gym.make` asks what it calls."""
    vars(make)["metadata"] = METADATA
    return make


def simulation_of(
    task: Task, observation: str | None = None, predress: bool = False, cycle: str | None = None
) -> BlockSimulation:
    """The simulation of a task of blocks; arguments as for `task`.

    Raises:
        TaskError: an argument is not legal.
    """
    check_flags(predress=predress)
    check_task(task, cycle)
    full = is_full(task.observation if observation is None else observation)
    return SIMULATIONS[task.cycle](task, full=full, pre_dress=predress)


def side_by_side(make: Callable[..., GrindEnv]) -> Callable[..., GrindVectorEnv]:
    """The vector form of an id: arguments as for the id, and those of `GrindVectorEnv`."""

    def vector(num_envs: int = 1, **arguments: Any) -> GrindVectorEnv:
        shown = {name: arguments.pop(name) for name in OF_VECTORS & arguments.keys()}
        return GrindVectorEnv(make(**arguments).simulation, num_envs, **shown)

    vector.__name__ = vector.__qualname__ = f"{make.__name__}_vector"
    vector.__doc__ = f"As `{make.__name__}`, many times side by side; further arguments as for `GrindVectorEnv`."
    return vector


@renders
def task(
    task: str = "power_limited",
    observation: str | None = None,
    show_block: bool = True,
    action: str = "box",
    predress: bool = False,
    cycle: str | None = None,
    render_mode: str | None = None,
) -> GrindEnv:
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
    simulation = simulation_of(load_task(task), observation, predress, cycle)
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode)


task_vector = side_by_side(task)


@renders
def reciprocation(
    observation: str | None = None,
    show_block: bool = True,
    action: str = "box",
    predress: bool = False,
    render_mode: str | None = None,
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
    """
    simulation = simulation_of(read_task("reciprocation"), observation, predress)
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode)


reciprocation_vector = side_by_side(reciprocation)


@renders
def wide_plates(
    observation: str | None = None,
    show_block: bool = True,
    action: str = "box",
    predress: bool = False,
    cycle: str = "G83",
    render_mode: str | None = None,
) -> GrindEnv:
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
    simulation = simulation_of(read_task("wide_plates"), observation, predress, cycle)
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode)


wide_plates_vector = side_by_side(wide_plates)


@renders
def stroke(
    observation: str = "measured",
    show_block: bool = True,
    action: str = "box",
    predress: bool = False,
    render_mode: str | None = None,
    cycle: str | None = None,
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
    terms, `info["cost"]` the probability that a part finished by the stroke is scrap; the ratios of burning, power and
    Ra to their limits are those of `GrindEnv`, of the stroke and of the surface that it leaves.

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
    full = is_full(observation)
    check_flags(predress=predress)
    refuse_predress(predress, "D = 1 in grind/Stroke-v0 is the dress before the stroke, also the first one's G81.1")
    refuse_cycle(cycle, "every part of grind/Stroke-v0 is ground by G81 and the picks of the agent's steps")
    task = read_task("stroke")
    check_task(task)
    simulation = StrokeSimulation(task, full=full)
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode)


stroke_vector = side_by_side(stroke)


@renders
def job(
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
    variables: str | None = None,
) -> GrindEnv:
    """Choose the table speed and the dressing of every cycle block of a part program.

    ## Description

    Before every G81, G82 or G83 the program takes E and D from the agent in place of those in the block, and goes on to
    the next cycle block. A step is therefore everything from one cycle block to the next one. The program is run in
    compiled code if it alone settles where the strokes lie, and by the control if the wheel, the operator or a grooving
    cycle has a say (`env.unwrapped.simulation.why` says it). `part_program()` is the program with the words chosen;
    `machine.grind` runs it to the same record. A cycle block that runs more than once, in a subprogram that M98 calls
    several times, is several steps, and no one text holds what was chosen for them: write such calls out where the
    program is to be taken back to the machine.

    With `parts` the program is run for a batch: the operator loads the next part where it ends, the wheel carries over,
    and lots and stocks change as the job's `[lots]` says. A program that loads its parts itself (M00) needs none. What
    a program keeps in #100 to #199 and #500 to #999 carries over from run to run, so that it may count.

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

    Minus the cost of the step in units of `task.reference_cost`, which is what a cycle block costs when the program
    runs with its own words on nominal parts: a program with good words earns about -1 a step. `info["reward_terms"]`
    holds the terms: machine time, wheel, dresser, the expected cost of scrap when a part is finished, and with the last
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
        variables: values of # variables before the first part, as `"#500=0, #101=15000"`.

    Raises:
        GrindError: the program or the job cannot be run, or an argument is not legal.
    """
    check_flags(predress=predress)
    refuse_predress(predress, "the program says where a cycle of grind/Job-v0 is a G82.1")
    refuse_cycle(cycle, "the program of grind/Job-v0 says which cycles it runs")
    held = variables_of(check_variables(variables), "variables:")
    simulation = load_simulation(program, job, parts, spread, observation, held)
    for sentence in simulation.unread:
        warnings.warn(sentence, stacklevel=2)
    return GrindEnv(simulation, show_block=show_block, action=action, render_mode=render_mode)


job_vector = side_by_side(job)
