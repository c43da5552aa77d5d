"""`grind/Reciprocation-v0`: G81 with a continuous infeed."""

from grind_env.envs.task_env_factory import fixed
from grind_env.envs.vector_env import side_by_side

make = fixed(
    "reciprocation",
    """
    Choose the table speed and the dressing of every part that is ground with a continuous infeed.

    ## Description

    A step is one part. `G81 X.. I.. E.. P..` starts the table, `G01 Y.. F..` feeds the wheel down at 0.4 mm/min, a
    dwell sparks out, and `G80` stops the table. A stroke is as deep as the infeed during its time. So strokes get
    thinner as **E** rises, and load the wheel more as E falls. G81 has no D word: the agent's **D** is the number of
    dresses that the operator requests, at equal fractions of depth. The control serves each request at the next
    reversal point. Plates, wheel and random draws are those of `grind/PowerLimited-v0`.

    Actions, observation, reward and episode are those of `GrindEnv`, with E from 3000 to 30,000 mm/min and D from 0 to
    3; `predress=True` lets an action ask for a G81.1. The observation has no pick of the coming block; `last_pick` is
    the infeed during a stroke of the last block. `info["block"]` holds all blocks of the step, one line each.

    `part_program()` is the episode as a program; `written().requests` says when the operator has to ask for a dress.
    """,
)
make_vector = side_by_side(make)
