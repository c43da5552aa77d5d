"""`grind/WidePlates-v0`: plates wider than the wheel, ground in G83 cross picks."""

from grind_env.envs.task_env_factory import fixed
from grind_env.envs.vector_env import side_by_side

make = fixed(
    "wide_plates",
    """
    Choose the table speed and the dressing of every part that is ground in strips.

    ## Description

    The plates are 60 mm wide, the wheel 25 mm. A step is one part: `G83 X.. I.. Y.. J.. Z.. K.. L.. F.. E.. P.. D..`
    plunges at both ends of the cross travel and moves the wheel across by K at every reversal. So one traverse grinds
    the plate in overlapping strips. Where it plunges, the wheel cuts over its whole width and is pressed back most;
    the strips that follow come out deeper. This **taper** grows with the force, and so with E and with the wear flats
    of the wheel. Radial wear adds to the mean size error until a dress sets the wheel to size again. The taper is
    measured on every part. A part is judged by the strip farthest from its size: the one with most stock left, or the
    one cut deepest below size. The wheel has one radius over its width. In a shop, the leading edge takes the depth
    and wear makes steps on the face; the model has no such steps.

    `part_program()` is the episode as a program, and `record()` is the record of `machine.grind` for it. Actions,
    reward and episode are those of `GrindEnv`, with E from 3000 to 30,000 mm/min and D from 0 to 3; `predress=True`
    lets an action ask for a G83.1.
    """,
)
make_vector = side_by_side(make)
