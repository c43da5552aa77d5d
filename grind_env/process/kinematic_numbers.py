"""Numbers that compare cycles on different wheels and machines; the process model uses none of them.

Units are mm and s, but the wheel speed `vs` in m/s. Sources: [M] Malkin, Grinding Technology; [B] Badger, The
Grinding Doc, and Drazumeric, Badger, Roininen & Krajnik 2020, On geometry and kinematics of abrasive processes: the
theory of aggressiveness.
"""

import numpy as np

from grind_env.array_types import Table


def speed_ratio(vs: Table, vw: Table) -> Table:
    """Return the speed ratio q = vs/vw of wheel and table [M]; all of shape (strokes,)."""
    return 1000.0 * vs / vw


def aggressiveness(vw: Table, vs: Table, ae: Table, ds: Table) -> Table:
    """Return the aggressiveness of surface grinding, Aggr = 10^6 (vw/vs) (ae/ds)^0.5 [B].

    Aggressiveness is a measure of chip thickness that leaves out the grains. All are of shape (strokes,).

    Args:
        vw: table speed, mm/s.
        vs: wheel speed, m/s.
        ae: depth of cut, mm.
        ds: wheel diameter, mm.
    """
    return 1e6 * (vw / (1000.0 * vs)) * np.sqrt(ae / ds)
