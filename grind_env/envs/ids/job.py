"""`grind/Job-v0`: E and D of every cycle block of a part program."""

import warnings

from grind_env.control.cli_options import variables_of
from grind_env.envs.actions import ActionError
from grind_env.envs.arguments import check_flags, check_variables
from grind_env.envs.env import GrindEnv, renders
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.tasks import TaskError
from grind_env.envs.vector_env import side_by_side
from grind_env.errors import GrindWarning


@renders
def make(
    program: str | None = None,
    job: str | None = None,
    observation: str = "measured",
    spread: float = 1.0,
    show_block: bool = False,
    action: str = "box",
    predress: bool = False,
    render_mode: str | None = None,
    cycle: str | None = None,
    parts: int = 1,
    variables: str | None = None,
    plant: str | None = None,
    info: str = "measured",
    out_of_range: str | None = None,
) -> GrindEnv:
    """Choose the table speed and the dressing of every cycle block of a part program.

    ## Description

    Before every G81, G82 or G83 the program takes E and D from the agent instead of the block, and runs to the next
    cycle block. So a step covers everything from one cycle block to the next. The program runs in compiled code if the
    program alone decides where the strokes lie. If the wheel, the operator or a grooving cycle decides, too, the
    control executes it event by event (`env.unwrapped.simulation.why` has the reason). `part_program()` is the program
    with the chosen E and D; `machine.grind` runs it to the same record. A cycle block that M98 runs several times is
    several steps, which one program text cannot hold: write such calls out to take the program back to the machine.

    With `parts` the program is run for a batch: the operator loads the next part at its end, the wheel carries over,
    and lots and stocks change as in `[lots]` of the job. A program that loads its parts itself (M00) needs no `parts`.
    Variables #100 to #199 and #500 to #999 keep their values from run to run, so that a program can count.

    ## Action space

    The default is `Box(-1, 1, (2,), float32)`: E on a geometric scale from 3000 to 30,000 mm/min, D = 0 up to 1/3 and 1
    to 3 in equal bins above. The other forms are those of `GrindEnv`, with E in mm/min even for a program in inches. In
    a G81, which has no D word, and in a block without a known dress program P, D has no effect (`info["D"]` is then 0).
    Actions have no pre-dress: G82.1 is another code and not a word of the block, so the program decides between G82 and
    G82.1.

    ## Observation space

    `Box`, float32: what a machine measures, noisy and delayed, and the coming block, scaled (see the table).
    `observation_info()` lists every entry; readings that are equal in all blocks of the program are left out, so that
    two programs may have observations of different length. `observation="full"` adds the hidden state of the wheel and
    of the lot, after all measured entries.

    ## Reward

    Minus the cost of the step in units of `task.reference_cost`: the mean cost of a cycle block when the program runs
    with its own E and D on nominal parts. A program with good values earns about -1 a step. The terms are machine time
    (`info["reward_time"]`), wheel, dresser, the expected cost of scrap when a part is finished, and with the last block
    the price of handing over a dull wheel. `info["cost"]` is the number of parts found bad, or with `info="full"` the
    expected number; all else is as for `GrindEnv`. No cost is negative, so no step earns more than 0.
    No lower bound is known: the program decides what happens between two cycle blocks and how often the table strokes
    in a G81.

    ## Episode

    An episode is `parts` runs of the program from start to end, and is `terminated` after the last one. Wheel, coolant
    and lots of material differ from episode to episode as in the other tasks; everything random is decided at reset.
    `reset(options=...)` fixes the factors of lot, wheel, coolant and noise or restricts what they are drawn from
    (`grind_env.envs.reset_options`); stock and material are those of the job.

    `env.spec.max_episode_steps` is one more than the steps of an episode. Wrappers such as `TimeAwareObservation` read
    this number, and a `TimeLimit` of this length truncates no episode. A `max_episode_steps` that you give to
    `gym.make` or `gym.make_vec` truncates.

    Args:
        program: file of the part program; the example plate if not given.
        job: its job file; the program's name with `.toml` if not given.
        parts: number of runs of the program.
        observation: `"measured"` or `"full"`.
        spread: factor on all that is random; 0 for the nominal job with exact gauges.
        show_block: put the text of the block that was run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: leave it False; the program says which cycles begin with a dress.
        render_mode: as for `GrindEnv`.
        cycle: leave it None; the program says which cycles it runs.
        variables: values of # variables before the first part, as `"#500=0, #101=15000"`.
        plant: name of an out-of-model machine: `"meter:7"`; `"meter"` or `"held-out"` to draw one in every episode;
            `"module:name"` for your own (`grind_env.plants`). The default is that of the job.
        info: `"measured"` for what a shop knows of a step, or `"full"` for probabilities and true ratios instead.
        out_of_range: what happens to actions beyond the bounds of the action space: `"clip"` or `"raise"`. By default
            `"clip"` for `action="box"`, with one warning, and `"raise"` for the other forms.

    Raises:
        GrindError: the program or the job cannot be run, or an argument is not legal.
    """
    check_flags(predress=predress)
    if predress:
        why = "the program says where a cycle of grind/Job-v0 is a G82.1"
        raise ActionError(f"predress is {predress!r}, but {why}: leave it out")
    if cycle is not None:
        raise TaskError(f"cycle is {cycle!r}, but the program of grind/Job-v0 says which cycles it runs: leave it out")
    numbers = variables_of(check_variables(variables), "variables:")
    simulation = load_simulation(program, job, parts, spread, observation, numbers, plant)
    for sentence in simulation.unread:
        warnings.warn(sentence, GrindWarning, stacklevel=2)
    return GrindEnv(
        simulation, show_block=show_block, action=action, render_mode=render_mode, info=info, out_of_range=out_of_range
    )


make_vector = side_by_side(make)
