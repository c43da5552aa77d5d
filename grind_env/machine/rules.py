"""The cycle rules of the control, compiled; `control.rules` and `control.cycles` define and explain them.

The control itself runs them in plain Python: a program is read and checked without numba.
"""

from grind_env.control import profile, rules
from grind_env.control.cycles import plunge
from grind_env.kernel import inlined_rule

motion_time = inlined_rule(rules.motion_time)
travelled = inlined_rule(profile.travelled)
begin_plunge = inlined_rule(plunge.begin)
after_reversal = inlined_rule(plunge.after_reversal)
plunge_finished = inlined_rule(plunge.finished)
