"""Quantities of a wheel over a part, each a number that `checks.csv` names.

A stroke's own quantities have no function: they are fields of `StrokeResult`.
"""

from dataclasses import replace
from itertools import pairwise
from math import log, sqrt

import numpy as np

from grind_env.process.equations import part_growth
from grind_env.process.stroke_types import StrokeResult
from grind_env.validation.rig import Grinder, crossing

STEADY = 5  #: number of strokes after which the depth of cut has reached the downfeed
#: passes after which force and power should be near the threshold, and after which nothing changes any more
SPARK_OUT, FULL_SPARK_OUT = 10, 40
ROUGHING = 17  #: number of roughing strokes after which the growth of a part is computed
#: wear-flat areas, share of the wheel's face, with which the heat flux is raised in steps
FLATS: tuple[float, ...] = tuple(np.geomspace(0.004, 0.145, 181).tolist())


def flats(grinder: Grinder) -> float:
    """Return the wear-flat area, share of the wheel's face."""
    return grinder.wheel.A


def flats_after(grinder: Grinder, volume: float) -> float:
    """Return the wear-flat area after `volume` mm3/mm more."""
    grinder.grind_volume(volume)
    return grinder.wheel.A


def loading(grinder: Grinder) -> float:
    """Return the share of the pores that is loaded."""
    return grinder.wheel.lam


def grain_density(grinder: Grinder) -> float:
    """Return the active grains per area, 1/mm2, from force, force per grain and contact length of a stroke."""
    done = grinder.grind()
    return done.Fn / (done.fg * done.lc)


def force_ratio(grinder: Grinder) -> float:
    """Return the ratio of tangential to normal force."""
    done = grinder.grind(STEADY)
    return done.Ft / done.Fn


def power_per_width(grinder: Grinder) -> float:
    """Return the power over the engaged width, W/mm."""
    return grinder.grind(STEADY).power / grinder.setup.width


def g_ratio(grinder: Grinder, volume: float) -> float:
    """Return the G-ratio over the next `volume` mm3/mm."""
    grinder.grind_volume(volume)
    return grinder.g_ratio()


def wear_depth(grinder: Grinder, volume: float) -> float:
    """Return the radial wear over the next `volume` mm3/mm, mm."""
    grinder.grind_volume(volume)
    return grinder.wheel.W


def dressed_share(grinder: Grinder) -> float:
    """Return the share of the lost wheel volume that is dressed off, %: a dress every 15 parts of 0.1 mm stock."""
    removed = grinder.dress()
    worn = 0.0
    for _ in range(15):
        grinder.new_part()
        grinder.grind(10)
        grinder.grind(2, 0.0)
        worn += grinder.worn
    return 100.0 * removed / (removed + worn)


def threshold_force(grinder: Grinder) -> float:
    """Return the normal force below which nothing is cut, N/mm."""
    return grinder.threshold().Fn


def cut_at_half_the_threshold(grinder: Grinder) -> float:
    """Return the depth of cut at half the interference of the threshold, um."""
    return 1000.0 * grinder.trial(0.5 * grinder.threshold().Fn * grinder.setup.width / grinder.p.ke).ae


def rubbing_force(grinder: Grinder) -> float:
    """Return the ratio of the normal force at half the threshold interference to the threshold force."""
    threshold = grinder.threshold().Fn
    return grinder.trial(0.5 * threshold * grinder.setup.width / grinder.p.ke).Fn / threshold


def over_threshold(grinder: Grinder, name: str) -> float:
    """Return the ratio of a field of the last of ten spark-out passes to its value at the wheel's threshold."""
    grinder.grind(10)
    last = grinder.grind(SPARK_OUT, 0.0)
    return float(getattr(last, name) / getattr(grinder.threshold(), name))


def residual_power(grinder: Grinder) -> float:
    """Return the ratio of the power of a pass that cuts only 0.1 um to the power of the plunge."""
    return grinder.cut(1e-4).power / grinder.grind(STEADY).power


def least_energy(grinder: Grinder) -> float:
    """Return the specific energy of a cut so deep that only chips count, J/mm3.

    Flats and ploughing add a term that falls with the square root of the depth; cuts of 20 and 80 um eliminate it.
    """
    return 2.0 * grinder.cut(0.080).u_s - grinder.cut(0.020).u_s


def settled_roughness(grinder: Grinder) -> float:
    """Return the Ra of the wheel 100 mm3/mm later, um."""
    return grinder.grind_volume(100.0).Rg


def touched(grinder: Grinder) -> float:
    """Return by how much a cut of 1 nm reduces the Ra of an unground face, %."""
    return 100.0 * (1.0 - grinder.trial(1e-6).Ra / grinder.Rs)


def sparked_out(grinder: Grinder) -> float:
    """Return Ra of a part after 10 strokes and full spark-out, um."""
    grinder.grind(10)
    return grinder.grind(FULL_SPARK_OUT, 0.0).Ra


def spark_out_gain(grinder: Grinder) -> float:
    """Return the ratio of Ra after full spark-out to Ra of the plunge."""
    plunged = grinder.grind(40).Ra
    return grinder.grind(FULL_SPARK_OUT, 0.0).Ra / plunged


def growth(grinder: Grinder) -> float:
    """Return the growth in height of the part after roughing, um."""
    grinder.grind(ROUGHING)
    return 1000.0 * part_growth(sum(grinder.heat), grinder.p.swell)


def heat_kept(grinder: Grinder) -> float:
    """Return the ratio of the growth of an uncooled part to the growth from all heat that has entered it."""
    grinder.p = grinder.p._replace(r_1=0.0, r_2=0.0, r_3=0.0, r_4=0.0)
    entered = sum(grinder.grind().heat for _ in range(ROUGHING)) / grinder.setup.table_speed
    return part_growth(sum(grinder.heat), grinder.p.swell) / (grinder.p.swell * grinder.p.per_capacity * entered)


def flats_at_burn(grinder: Grinder) -> float:
    """Return the wear-flat area at which a cut of 10 um burns by Malkin's threshold, %."""
    return 100.0 * crossing(lambda flats: _cut_when(grinder, flats).burn_ratio - 1.0, FLATS[0], FLATS[-1])


def temperature_at_burn(grinder: Grinder) -> float:
    """Return the temperature rise of the cut of `flats_at_burn`, K."""
    return _cut_when(grinder, 0.01 * flats_at_burn(grinder)).T


def ploughing_force(grinder: Grinder) -> float:
    """Return the tangential force of a wheel without flats, less the chip force, at a cut of 10 um, N/mm."""
    done = _cut_when(grinder, 0.0)
    return done.Ft - grinder.p.u_ch * done.heq


def flat_pressure(grinder: Grinder) -> float:
    """Return the pressure under wear flats, by the normal force of a cut of 10 um with flats and without, N/mm2."""
    dull, flatless = (_cut_when(grinder, flats) for flats in (FLATS[-1], 0.0))
    return (dull.Fn - flatless.Fn) / (FLATS[-1] * sqrt(grinder.setup.diameter * 0.010))


def _unboiled(grinder: Grinder, depth: float, **parameters: float) -> StrokeResult:
    """Return a cut of a depth, mm, in a fluid that never boils, with other parameters."""
    return replace(grinder, p=grinder.p._replace(Tb=1e5, **parameters)).cut(depth)


def chip_heat(grinder: Grinder) -> float:
    """Return the heat that leaves with the chips, by the temperature with and without, J/mm3."""
    done = _unboiled(grinder, 0.010)
    return done.u_s * (1.0 - done.T / _unboiled(grinder, 0.010, e_ch=0.0).T)


def convection(grinder: Grinder) -> float:
    """Return the convection of the fluid over the contact, by the temperature with and without it, W/(m2 K)."""
    wet, without = (_unboiled(grinder, grinder.setup.downfeed, e_ch=0.0, hf=hf) for hf in (grinder.p.hf, 0.0))
    return 1e6 * wet.Ft * wet.vs * (1.0 / wet.T - 1.0 / without.T) / wet.lc


def temperature_factor(grinder: Grinder) -> float:
    """Return the C of T = C q/beta (lc/vw)^(1/2), where q is the heat flux into the work."""
    done = grinder.cut(0.010)
    flux = done.heat / (grinder.setup.width * done.lc)
    return 1e-6 * done.T * grinder.p.beta / flux * sqrt(grinder.setup.table_speed / done.lc)


def cooling_time(grinder: Grinder) -> float:
    """Return the time in which fluid and chuck reduce the temperature rise of a soaked part to 1/e, s."""
    grinder.grind(ROUGHING)
    grinder.Z = -1.0
    grinder.grind(SPARK_OUT, 0.0)
    before = sum(grinder.heat)
    grinder.grind(1, 0.0)
    return (grinder.setup.length / grinder.setup.table_speed + grinder.setup.pause) / log(before / sum(grinder.heat))


def texture_left(grinder: Grinder) -> float:
    """Return the share of the texture of an unground part that its first stroke leaves."""
    before, done = grinder.Rs, grinder.grind()
    return float((done.Ra - done.Rg) / (before - done.Rg))


def spark_out_left(grinder: Grinder, passes: float) -> float:
    """Return the ratio of Ra after ten strokes and some spark-out passes to Ra after full spark-out."""
    grinder.grind(10)
    some = grinder.grind(int(passes), 0.0).Ra
    return some / grinder.grind(FULL_SPARK_OUT, 0.0).Ra


def burn_out_flux(grinder: Grinder) -> float:
    """Return the heat flux at which the film boils, W/mm2: the temperature rises most steeply there."""
    strokes = [_cut_when(grinder, flats) for flats in FLATS]
    slopes = _steepness(strokes)
    return _flux(strokes[slopes.index(max(slopes))])


def boiling_range(grinder: Grinder) -> float:
    """Return the ratio of the heat flux at which the film has boiled to the flux at which it begins to boil."""
    strokes = [_cut_when(grinder, flats) for flats in FLATS]
    shares = [done.eps for done in strokes]
    middle = max(range(len(shares) - 1), key=lambda k: shares[k + 1] / shares[k])
    steep = [k for k, slope in enumerate(_steepness(strokes)) if slope > 2.0]
    if middle not in steep:
        return float("nan")
    first = next(k for k in range(middle, -1, -1) if k - 1 not in steep)
    last = next(k for k in range(middle, len(shares)) if k + 1 not in steep)
    return _flux(strokes[last + 1]) / _flux(strokes[first])


def _cut_when(grinder: Grinder, flats: float) -> StrokeResult:
    """Return a cut of 10 um with a wear-flat area, share of the wheel's face."""
    grinder.wheel = grinder.wheel._replace(A=flats)
    return grinder.cut(0.010)


def _flux(done: StrokeResult) -> float:
    """Return the heat flux over the contact, W/mm2."""
    return done.Ft * done.Q / (done.heq * done.lc)


def _steepness(strokes: list[StrokeResult]) -> list[float]:
    """Return the exponents of temperature on heat flux between successive strokes; 1 if both are proportional."""
    return [log(two.T / one.T) / log(_flux(two) / _flux(one)) for one, two in pairwise(strokes)]
