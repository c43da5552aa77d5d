"""A plant with textbook laws and other exponents for energy, sliding, heat, wear and roughness.

With the chip thickness h = ae vw/vs, the flats A and the volume V since the dress, each over its reference:

    chip energy ~ h^-a,   sliding force ~ A^s lc,   heat into the work = a fixed share of the power
    dA ~ slid length A^-n h^-m,   1/G ~ h^q early(V),   Ra ~ h^e early(V) (1 + V/Vd)

At the nominal point (10 um at 12 m/min, a wheel just dressed) force, growth, wear and Ra are the package's times a
drawn factor. The stroke function is the package's with these laws as its constants, which conserves energy and volume.
"""

import functools
import math
from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined, log, power
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.plants.foreign import DEPTH, LEAST, SPEED
from grind_env.process import equations as eq
from grind_env.process.equations.roughness import REFERENCE_RATE
from grind_env.process.process_interface import Process, joined
from grind_env.process.stroke_types import StrokeConstants, StrokeResult, WheelState

#: ratio of the flats after a dress to the flats of a freshly fractured surface, for the catalogue's alumina wheels
DRESSED = 4.0 / 3.0
THINNEST = 0.005  #: smallest chip thickness, um; thinner chips count as this thick


class TextbookOwn(NamedTuple):
    """Memory of the process; `ranges.toml` describes the fields."""

    textbook_force: float = 0.0  #: force over the package's at the nominal point; 0 for the package's laws
    textbook_slides: float = 0.5
    textbook_a: float = 0.0
    textbook_s: float = 1.0
    textbook_heat: float = 1.0
    #: ratio of the temperature that the workpiece tolerates to the package's; shown rises are divided by this ratio
    textbook_burns: float = 1.0
    textbook_dulls: float = 1.0
    textbook_n: float = 0.0
    textbook_m: float = 0.0
    textbook_wear: float = 1.0
    textbook_q: float = 0.0
    textbook_loose: float = 1.0
    textbook_settles: float = 1.0
    textbook_ra: float = 1.0
    textbook_e: float = 0.0
    textbook_fresh: float = 0.0
    textbook_fades: float = 1.0
    textbook_roughens: float = 1.0


#: constants of a stroke that the laws replace
FIELDS = (
    *("u_ch", "kp", "pa", "pb", "AL", "beta", "krw", "hf", "e_ch", "per_capacity"),
    *("mG", "per_G", "kf", "wi", "per_dr", "kA", "kL", "f0", "f1", "nr"),
)
ruled = replacer(StrokeConstants, *FIELDS)
dulled = replacer(WheelState, "A")
heated = replacer(StrokeResult, "heat", "eps")


@inlined
def log_chips(
    u: float, start: float, give: float, Kn: float, sd: float, chip: float, a: float, k: StrokeConstants
) -> float:
    """Return the logarithm of the chip thickness over the nominal one, after a Newton step towards the force balance.

    Args:
        u: interference, mm.
        start: the logarithm before the step.
        give: compliance of the elastic loop, mm2/N.
        Kn: normal force of sliding per area of contact, N/mm2.
        sd: root of the equivalent diameter, mm^0.5.
        chip: tangential force of chips of the nominal thickness per width and depth, N/mm2.
        a: exponent of the chip energy.
        k: constants of the cycle.
    """
    at = chip * exp(-a * start)
    x = eq.cut_root(u, give, eq.threshold_force(Kn, sd, k.sa), Kn, sd, k.sa, at, k.kc)
    depth, sloped = eq.depth_of_cut(x, k.sa), 2.0 * (x + k.sa)
    yields = give * k.kc * at * sloped
    elasticity = yields / (sloped + yields + give * Kn * sd)
    found = log(max(depth * k.vw, LEAST) * (1.0 / (DEPTH * SPEED)))
    better: float = start + (found - start) / (1.0 - a * elasticity)
    return better


@functools.cache
def _textbook(inner: Process) -> Process:
    grind = inner.stroke

    @inlined
    def stroke(
        wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
    ) -> tuple[WheelState, Any, StrokeResult]:
        on = own.textbook_force > 0.0
        speed, sd = eq.wheel_speed(wheel.ds, k.n, k.vs_set), math.sqrt(wheel.ds)
        per_speed, nominal = 1.0 / speed, DEPTH * SPEED / speed
        dressed, rubbing = DRESSED * k.Af, sd * math.sqrt(DEPTH + k.sa * k.sa)
        A = max(wheel.A, LEAST)

        flats = eq.wear_flat_pressure(1.0 / (wheel.ds * speed), k.pa, k.pb * SPEED * k.per_vw)
        ours = eq.chip_force(DEPTH * SPEED, per_speed, k.u_ch) + (k.kp + k.mu * flats * dressed) * rubbing
        force = own.textbook_force * ours
        pressed = own.textbook_slides * force / (k.mu * rubbing) * power(A / dressed, own.textbook_s)
        energy = (1.0 - own.textbook_slides) * force / nominal

        u, give, chip = max(Z - wheel.W - S, LEAST), b * k.per_ke, energy * k.vw * per_speed
        thin, a = log(THINNEST / nominal), own.textbook_a
        t = max(log(u * k.vw * (1.0 / (DEPTH * SPEED))), thin)
        t = max(log_chips(u, t, give, pressed, sd, chip, a, k), thin)
        t = max(log_chips(u, t, give, pressed, sd, chip, a, k), thin)
        t = max(log_chips(u, t, give, pressed, sd, chip, a, k), thin)

        loose = (wheel.V + own.textbook_loose * own.textbook_settles) / (wheel.V + own.textbook_settles)
        at_nominal = eq.log_chip_wear(nominal, k.mG)
        worn = at_nominal - eq.log_chip_wear(nominal, own.textbook_q)
        scale = own.textbook_ra * (k.f0 + k.f1 * math.sqrt(DEPTH * SPEED / REFERENCE_RATE))
        scale = scale * eq.roughening(1.0, at_nominal, k.least_chips, k.log_gm, k.nr)
        early = 1.0 - own.textbook_fresh * (1.0 - exp(-wheel.V / own.textbook_fades))
        rough = scale * exp(own.textbook_e * t) * early * (1.0 + wheel.V / own.textbook_roughens)
        # divide out the package's own law by which the wheel's roughness relaxes after a dress
        relaxed = eq.wheel_roughness(wheel.Rd, eq.freshness(wheel.V, k.per_Vr), k.RaRef)
        laws = ruled(
            k,
            (
                energy * exp(-a * t) if on else k.u_ch,
                0.0 if on else k.kp,
                pressed / A if on else k.pa,
                0.0 if on else k.pb,
                0.0 if on else k.AL,
                k.beta * own.textbook_burns / own.textbook_heat if on else k.beta,
                0.0 if on else k.krw,
                0.0 if on else k.hf,
                0.0 if on else k.e_ch,
                own.textbook_heat * k.per_capacity if on else k.per_capacity,
                own.textbook_q if on else k.mG,
                own.textbook_wear * loose * k.per_G * exp(worn) if on else k.per_G,
                0.0 if on else k.kf,
                0.0 if on else k.wi,
                0.0 if on else k.per_dr,
                0.0 if on else k.kA,
                0.0 if on else k.kL,
                rough * wheel.Rd / relaxed if on else k.f0,
                0.0 if on else k.f1,
                0.0 if on else k.nr,
            ),
        )
        after, own, done = grind(wheel, own, S, Rs, Z, b, laws, seconds)
        slid = eq.grain_sliding(done.lc, done.vs, 1.0 / wheel.ds, k.turned)
        thinner = exp(-own.textbook_m * log(max(done.heq, THINNEST) / nominal))
        rate, to = (own.textbook_dulls if on else 0.0), 1.0 + own.textbook_n
        grown = to * rate * k.kA * slid * thinner / dressed
        flat = dressed * power(power(A / dressed, to) + grown, 1.0 / to)
        after = dulled(after, (min(flat, k.Amax) if grown > 0.0 else after.A,))
        share = own.textbook_heat if on else 1.0
        return after, own, heated(done, (share * done.heat, share * done.eps))

    return inner._replace(own=joined(inner.own, TextbookOwn), stroke=stroke)


TEXTBOOK = Family(
    name="textbook",
    what="energy, sliding, heat, wear, dulling and roughness follow power laws from textbooks",
    ranges=ranges_of("textbook"),
    wraps=_textbook,
)
