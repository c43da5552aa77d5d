"""A plant with power laws from the literature for force, roughness, wear and dulling.

    Ft' = F1 heq^f,  Ra = R1 heq^e,  G = G1 heq^-q  (Peters and Snoeys),  dulling as V'^d

At the nominal point (10 um at 12 m/min, current wheel state), each law gives the package's value times a drawn factor.
Ft' replaces all force terms of the package; the depth of cut solves u - ae = b kc Ft'(ae)/ke. A stroke of the package
whose only term is the chip energy Ft' vs/Q has this force and depth, and gives heat and part. Power then hardly depends
on wheel speed. A spindle at its power limit does not slow down but stalls at too high a torque.
"""

import functools
import math
from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined, power
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.process import equations as eq
from grind_env.process.equations.roughness import REFERENCE_RATE
from grind_env.process.process_interface import Process, joined
from grind_env.process.stroke_types import StrokeConstants, StrokeResult, WheelState

#: nominal depth, mm, table speed, mm/s, and volume since the dress, mm3/mm; there the dulling rate is the package's
DEPTH, SPEED, VOLUME = 0.010, 200.0, 300.0
LEAST = 1e-9  #: smallest interference, mm, used in place of 0 or less


class ForeignOwn(NamedTuple):
    """Memory of the process; `ranges.toml` describes the fields."""

    #: tangential force over the package's at the nominal point; 0 for all laws of the package
    foreign_force: float = 0.0
    foreign_f: float = 1.0
    foreign_ra: float = 1.0
    foreign_e: float = 0.5
    foreign_wear: float = 1.0
    foreign_q: float = 0.5
    foreign_dulls: float = 1.0
    foreign_d: float = 1.0


ruled = replacer(
    StrokeConstants, *("u_ch", "kp", "pa", "pb", "sa", "mG", "per_G", "kf", "wi", "per_dr", "kA", "f0", "f1", "nr")
)
dulled = replacer(WheelState, "A")


@inlined
def nominal_force(wheel: WheelState, speed: float, k: StrokeConstants) -> float:
    """Return the package's tangential force per width at the nominal point, N/mm, for a wheel speed, m/s."""
    C = eq.grain_density(wheel.Cd, eq.freshness(wheel.V, k.per_Vr), k.Cref)
    pressure = eq.wear_flat_pressure(1.0 / (wheel.ds * speed), k.pa, k.pb * SPEED * k.per_vw)
    flats = pressure * eq.flat_area(wheel.A, wheel.lam, k.AL)
    Kt = eq.ploughing_pressure(C, wheel.lam, k.kp, k.per_Cref) + k.mu * flats
    rubbing = math.sqrt(wheel.ds * (DEPTH + k.sa * k.sa))
    return eq.chip_force(DEPTH * SPEED, 1.0 / speed, k.u_ch) + Kt * rubbing


@inlined
def _nearer(t: float, kappa: float, m: float) -> float:
    """Return t after a Newton step for t^m + kappa t = 1, from above, where the left side is convex."""
    grown = power(t, m)
    nearer: float = t - (grown + kappa * t - 1.0) / (m * grown / t + kappa)
    return nearer


@inlined
def depth_share(kappa: float, f: float) -> float:
    """Return the ratio y of depth of cut to interference, which solves y + kappa y^f = 1."""
    m = 1.0 / f
    t = power(1.0 + kappa, -f)
    t = _nearer(_nearer(_nearer(_nearer(_nearer(t, kappa, m), kappa, m), kappa, m), kappa, m), kappa, m)
    share: float = power(t, m)
    return share


@inlined
def flats_grown(wheel: WheelState, V: float, speed: float, own: Any, k: StrokeConstants) -> float:
    """Return the growth of the flats, a fraction of the wheel surface, up to `V`, mm3/mm since the dress: as V'^d."""
    rubbing = math.sqrt(wheel.ds * (DEPTH + k.sa * k.sa))
    rate = k.kA * eq.grain_sliding(rubbing, speed, 1.0 / wheel.ds, eq.turning(1.0, SPEED)) / DEPTH
    d = own.foreign_d
    done = power((V + 1.0) / VOLUME, d) - power((wheel.V + 1.0) / VOLUME, d)
    grown: float = own.foreign_dulls * rate * (VOLUME / d) * done * (1.0 - wheel.A * k.per_Amax)
    return grown


@functools.cache
def _foreign(inner: Process) -> Process:
    grind = inner.stroke

    @inlined
    def stroke(
        wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
    ) -> tuple[WheelState, Any, StrokeResult]:
        on = own.foreign_force > 0.0
        speed, u = eq.wheel_speed(wheel.ds, k.n, k.vs_set), max(Z - wheel.W - S, LEAST)
        Ft, per_depth = own.foreign_force * nominal_force(wheel, speed, k), k.vw / (DEPTH * SPEED)
        kappa = b * k.per_ke * k.kc * Ft / u * power(u * per_depth, own.foreign_f)
        chips = u * depth_share(kappa if on else 1.0, own.foreign_f) * per_depth  # over the nominal ones
        energy = Ft * power(chips, own.foreign_f - 1.0) * speed / (DEPTH * SPEED)

        heq = DEPTH * SPEED / speed
        ours, theirs = eq.log_chip_wear(heq, k.mG), eq.log_chip_wear(heq, own.foreign_q)
        smooth = own.foreign_ra * eq.roughening(1.0, ours, k.least_chips, k.log_gm, k.nr)
        scale = smooth * (k.f0 + k.f1 * math.sqrt(DEPTH * SPEED / REFERENCE_RATE))
        rough = scale * power(max(chips, eq.PLOUGHING_CHIP / heq), own.foreign_e)
        laws = ruled(
            k,
            (
                energy if on else k.u_ch,
                0.0 if on else k.kp,
                0.0 if on else k.pa,
                0.0 if on else k.pb,
                0.0 if on else k.sa,
                own.foreign_q if on else k.mG,
                own.foreign_wear * k.per_G * exp(ours - theirs) if on else k.per_G,
                0.0 if on else k.kf,
                0.0 if on else k.wi,
                0.0 if on else k.per_dr,
                0.0 if on else k.kA,
                rough if on else k.f0,
                0.0 if on else k.f1,
                0.0 if on else k.nr,
            ),
        )
        after, own, done = grind(wheel, own, S, Rs, Z, b, laws, seconds)
        A = min(wheel.A + flats_grown(wheel, after.V, speed, own, k), k.Amax)
        return dulled(after, (A if on else after.A,)), own, done

    return inner._replace(own=joined(inner.own, ForeignOwn), stroke=stroke)


FOREIGN = Family(
    name="foreign",
    what="force, roughness, wear and dulling follow other power laws; the nominal point is 10 um deep at 12 m/min",
    ranges=ranges_of("foreign"),
    wraps=_foreign,
)
