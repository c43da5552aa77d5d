"""Rules of the control, compiled; `control.rules` and `control.profile` define and explain them.

The control itself runs them in plain Python: a program is read and checked without numba.
"""

from grind_env.control import profile, rules
from grind_env.kernel import inlined_rule

motion_time = inlined_rule(rules.motion_time)
travelled = inlined_rule(profile.travelled)
