"""The published one-step problem of Wen, Tay & Nee: wheel speed, table speed, dress depth and dress lead of a part.

X. M. Wen, A. A. O. Tay, A. Y. C. Nee, "Micro-computer-based optimization of the surface grinding process",
J. Mater. Process. Technol. 29 (1992) 75-90. The formulas and constants were written down from memory of that paper
and of those that restate it (Saravanan et al. 2002, Baskar et al. 2004, Rao & Pawar 2010, Pawar & Rao 2013). Cost,
removal parameter and roughness reproduce published optima to better than 1 % (tests/envs/test_wen.py), which
confirms formula and constants together; the specific energy is active at no published optimum, so nothing confirms
it. The wheel-wear constraint of the paper does not reproduce and the stiffness constraint never acts: both are left
out (scenarios, 4.3).

Lengths in mm, speeds in m/min, costs in $, as in the paper. The depth of cut is a constant here, and the table
speed Vw plays the part of E.
"""

import math
from typing import Any, NamedTuple

from grind_env.kernel import entry, inlined, power
from grind_env.kernel.columns import column_reader, column_writer

LABOUR = 30.0
"""Mc, labour and administration, $/h."""
WORK_LENGTH, OVERRUN_LENGTH = 300.0, 150.0
"""Lw and Le, mm."""
WORK_WIDTH, OVERRUN_WIDTH = 60.0, 25.0
"""bw and be, mm."""
CROSS_FEED = 2.0
"""fb, mm per pass."""
SPARKOUT_PASSES = 2.0
"""Sp."""
WHEEL_DIAMETER, WHEEL_WIDTH = 355.0, 25.0
"""De and bs, mm."""
G_RATIO = 60.0
"""G."""
IDLE_DISTANCE, IDLE_SPEED = 100.0, 254.0
"""Sd in mm and Vr in mm/min."""
LOADED_PARTS, LOAD_TIME = 1.0, 5.0
"""p, workpieces on the table, and t1 in min."""
SETUP_TIME, BATCH = 30.0, 12.0
"""tch in min, and Nt, parts."""
PARTS_PER_DRESS, PARTS_PER_DRESSER = 20.0, 2000.0
"""Nd and Ntd, parts."""
WHEEL_PRICE, DRESSER_PRICE = 0.003, 25.0
"""Cs in $/mm3 and Cd in $."""
BOND_INDEX = 6.99
"""VOL, wheel bond percentage index."""
GRAIN_SIZE = 0.3
"""dg, mm."""
HARDNESS = 58.0
"""Rc of the work, HRC."""
FLAT_START, FLAT_GROWTH = 0.0, 3.937e-7
"""A0, wear-flat area of a dressed wheel, and Ku, its growth, 1/mm."""

COST_SCALE = 10.0
"""CT*, $."""
REMOVAL_SCALE = 20.0
"""WRP*, mm3/(min N); also the least removal parameter of a finish part."""
ROUGHNESS_SCALE = 1.8
"""Ra*, um; also the highest Ra of a rough part."""


class Setting(NamedTuple):
    """What is chosen."""

    Vs: float
    """Wheel speed, m/min."""
    Vw: float
    """Table speed, m/min."""
    doc: float
    """Depth of dressing, mm."""
    L: float
    """Lead of dressing, mm per wheel revolution."""


LOWEST = Setting(1000.0, 10.0, 0.01, 0.01)
HIGHEST = Setting(2023.0, 22.7, 0.137, 0.137)
"""Bounds of the published problem."""


class Case(NamedTuple):
    """A way of grinding: what is taken off, and what is asked of it."""

    aw: float
    """Stock, mm."""
    ap: float
    """Down feed, mm per pass."""
    cost_weight: float
    removal_weight: float
    roughness_weight: float
    roughness_limit: float
    """Highest Ra, um."""
    removal_floor: float
    """Least removal parameter, mm3/(min N)."""


CASES = {
    "rough": Case(0.1, 0.0505, 0.5, 0.5, 0.0, ROUGHNESS_SCALE, 0.0),
    "finish": Case(0.055, 0.0105, 0.3, 0.0, 0.7, math.inf, REMOVAL_SCALE),
}
"""The two problems of the paper by name."""


class WenVerdict(NamedTuple):
    """What a setting gives."""

    production_cost: float
    """CT, $ per part."""
    removal: float
    """Workpiece removal parameter WRP, mm3/(min N)."""
    roughness: float
    """Ra, um."""
    energy: float
    """Specific energy U, J/mm3."""
    burn_threshold: float
    """Specific energy U* at which the work burns, J/mm3."""
    objective: float
    """COF of the paper, to be made small."""
    violation: float
    """Sum of the relative violations of the limits; 0 for a feasible setting."""


@inlined
def production_cost(s: Setting, c: Case) -> float:
    """Production cost CT, $ per part: grinding, idle travel and load, set-up, dressing, wheel, dresser."""
    minute = LABOUR / 60.0
    wheel_face = math.pi * WHEEL_WIDTH * WHEEL_DIAMETER
    pass_time = (WORK_LENGTH + OVERRUN_LENGTH) / (1000.0 * s.Vw) * (WORK_WIDTH + OVERRUN_WIDTH) / CROSS_FEED
    wear_passes = c.aw * WORK_WIDTH * WORK_LENGTH / (wheel_face * c.ap * G_RATIO)
    grinding = minute / LOADED_PARTS * pass_time * (c.aw / c.ap + SPARKOUT_PASSES + wear_passes)
    idle = minute / LOADED_PARTS * (IDLE_DISTANCE / IDLE_SPEED + LOAD_TIME)
    setup = minute * SETUP_TIME / BATCH
    dressing = minute * wheel_face / (LOADED_PARTS * PARTS_PER_DRESS * s.L * 1000.0 * s.Vs)
    worn = c.aw * WORK_WIDTH * WORK_LENGTH / (LOADED_PARTS * G_RATIO)
    dressed_off = s.doc * wheel_face / (LOADED_PARTS * PARTS_PER_DRESS)
    dresser = DRESSER_PRICE / (LOADED_PARTS * PARTS_PER_DRESSER)
    return grinding + idle + setup + dressing + WHEEL_PRICE * (worn + dressed_off) + dresser


@inlined
def removal_parameter(s: Setting) -> float:
    """Workpiece removal parameter WRP, mm3/(min N): removal rate per normal force (Lindsay & Hahn)."""
    dressing = (1.0 + 2.0 * s.doc / (3.0 * s.L)) * power(s.L, 11.0 / 19.0)
    wheel = power(WHEEL_DIAMETER, 43.0 / 304.0) * power(BOND_INDEX, 0.47) * power(GRAIN_SIZE, 5.0 / 38.0)
    return 94.4 * dressing * power(s.Vw / s.Vs, 3.0 / 19.0) * s.Vs / (wheel * power(HARDNESS, 27.0 / 19.0))


@inlined
def roughness(s: Setting, c: Case) -> float:
    """Ra, um, over the mean chip thickness.

    The second branch is stated up to a thickness of 2.54 only; the published rough optima lie at 3.0 to 3.3 and
    extrapolate it, and so does this.
    """
    grain = power(GRAIN_SIZE, 16.0 / 27.0) * power(c.ap, 19.0 / 27.0) / power(WHEEL_DIAMETER, 8.0 / 27.0)
    thickness = 12.5e3 * grain * (1.0 + s.doc / s.L) * power(s.L * s.Vw / s.Vs, 16.0 / 27.0)
    return 0.4587 * power(thickness, 0.30) if thickness < 0.254 else 0.7866 * power(thickness, 0.72)


@inlined
def specific_energy(s: Setting, c: Case) -> float:
    """Specific energy U, J/mm3: chips, ploughing, and wear flats that grow with sliding ("product form")."""
    contact = math.sqrt(WHEEL_DIAMETER) / math.sqrt(c.ap)
    friction = 6.9e-3 * 2102.4 * s.Vw / (WHEEL_DIAMETER * s.Vs)
    slid = s.Vs * WORK_LENGTH * c.aw / (s.Vw * math.sqrt(WHEEL_DIAMETER) * math.sqrt(c.ap))
    flats = FLAT_START + FLAT_GROWTH * slid
    return 13.8 + 9.64e-4 * s.Vs / (c.ap * s.Vw) + friction * flats * contact * s.Vs / s.Vw


@inlined
def burn_threshold(s: Setting, c: Case) -> float:
    """Specific energy U* at which steel burns, J/mm3 (Malkin)."""
    return 6.2 + 1.76 * power(WHEEL_DIAMETER, 0.25) / (power(c.ap, 0.75) * math.sqrt(s.Vw))


@inlined
def judge(s: Setting, c: Case) -> WenVerdict:
    """Objective and violation of a setting, and what they are made of."""
    CT, WRP, Ra = production_cost(s, c), removal_parameter(s), roughness(s, c)
    U, U_star = specific_energy(s, c), burn_threshold(s, c)
    objective = (
        c.cost_weight * CT / COST_SCALE
        - c.removal_weight * WRP / REMOVAL_SCALE
        + c.roughness_weight * Ra / ROUGHNESS_SCALE
    )
    violation = (
        max(0.0, (Ra - c.roughness_limit) / ROUGHNESS_SCALE)
        + max(0.0, (c.removal_floor - WRP) / REMOVAL_SCALE)
        + max(0.0, U / U_star - 1.0)
    )
    return WenVerdict(CT, WRP, Ra, U, U_star, objective, violation)


read_setting, read_case = column_reader(Setting), column_reader(Case)
write_verdict = column_writer(WenVerdict)


@entry
def judge_settings(settings: Any, cases: Any, verdicts: Any) -> None:
    """Judge settings, one a row.

    Args:
        settings: shape (N, fields of `Setting`).
        cases: shape (N, fields of `Case`).
        verdicts: shape (N, fields of `WenVerdict`); written.
    """
    for i in range(settings.shape[0]):
        write_verdict(verdicts, i, judge(read_setting(settings, i), read_case(cases, i)))
