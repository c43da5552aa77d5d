"""The cycle rules of the control, compiled for the block kernel; `control.rules` defines and explains them.

The control itself runs them in plain Python: a program is read and checked without numba.
"""

from grind_env.control import profile, rules
from grind_env.kernel import inlined

motion_time = inlined(rules.motion_time)
depth_after_pick = inlined(rules.depth_after_pick)
dresses_due = inlined(rules.dresses_due)
travelled = inlined(profile.travelled)
