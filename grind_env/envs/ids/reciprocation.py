"""`grind/Reciprocation-v0`: G81 with a continuous infeed."""

from grind_env.envs.any_task import fixed
from grind_env.envs.vector_env import side_by_side

make = fixed(
    "reciprocation",
    """
    Choose the table speed and the dressing of every part that is ground with a continuous infeed.

    ## Description

    A step is one part: `G81 X.. I.. E.. P..` sets the table going, `G01 Y.. F..` feeds the wheel down at 0.5 mm/min
    while it reciprocates, a dwell sparks out, and `G80` stops it. A stroke is as deep as the infeed goes in its time,
    so that it gets thinner as **E** rises, and heavier on the wheel as E falls. G81 has no D word: the agent's **D**
    is that many requests of the operator for a dress, at equal fractions of depth, each of which the control serves
    at the next reversal point. Plates, wheel and what is random are those of `grind/PowerLimited-v0`.

    Actions, observation, reward and episode are those of `GrindEnv`, with E from 3000 to 30,000 mm/min and D from 0 to
    3; `predress=True` lets an action ask for the G81.1 form. The coming block has no pick to be observed; `last_pick`
    is what the infeed covered in a stroke of the last block. `info["block"]` holds all blocks of the step, a line each.

    `part_program()` is the episode as a program; `written().requests` says when the operator has to ask for a dress.
    """,
)
make_vector = side_by_side(make)
