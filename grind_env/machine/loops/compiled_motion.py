"""Rules of the control, compiled; `control.cycle_formulas` and `control.motion_profile` define and explain them.

The control itself runs them in plain Python: a program is read and checked without numba.
"""

from grind_env.control import cycle_formulas, motion_profile
from grind_env.kernel import inlined_rule

motion_time = inlined_rule(cycle_formulas.motion_time)
travelled = inlined_rule(motion_profile.travelled)
