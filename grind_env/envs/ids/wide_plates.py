"""`grind/WidePlates-v0`: plates wider than the wheel, ground in G83 cross picks."""

from grind_env.envs.any_task import fixed
from grind_env.envs.vector_env import side_by_side

make = fixed(
    "wide_plates",
    """
    Choose the table speed and the dressing of every part that is ground in strips.

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
    episode are those of `GrindEnv`, with E from 3000 to 30,000 mm/min and D from 0 to 3; `predress=True` lets an
    action ask for the G83.1 form.
    """,
)
make_vector = side_by_side(make)
