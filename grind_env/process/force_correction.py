"""The process of the package with extra exponents on its forces, found by a calibration.

The tangential force at given depth, and with it normal force, power, heat and deflection, is that of the model times

    (u/10 um)^depth (vw/200 mm/s)^speed ((V' + 10)/310)^volume

with the interference u of the stroke, the table speed vw and the volume V' since the dress, mm3/mm. A constant factor
on the force, `power_factor`, belongs to the parameters of any process.
"""

from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined, log
from grind_env.kernel.row_accessors import replacer
from grind_env.process.entries import Material
from grind_env.process.process_interface import PROCESS, Process, joined
from grind_env.process.stroke_types import FORCES, StrokeConstants, StrokeResult, WheelState

#: interference, mm, table speed, mm/s, and volume, mm3/mm, with factor 1; volume that is added to V', mm3/mm
DEPTH, SPEED, VOLUME, EARLY = 0.010, 200.0, 300.0, 10.0
#: range of the interference, mm, that logs cover; the factor is constant outside, and the force follows the model
THINNEST, DEEPEST = 0.0005, 0.1


class CorrectedOwn(NamedTuple):
    """Memory of the process: exponents of the job."""

    corrected_depth: float = 0.0
    corrected_speed: float = 0.0
    corrected_volume: float = 0.0


ground = PROCESS.stroke
scaled = replacer(StrokeConstants, *FORCES)


@inlined
def _stroke(
    wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
) -> tuple[WheelState, Any, StrokeResult]:
    u = min(max(Z - wheel.W - S, THINNEST), DEEPEST)
    factor = exp(
        own.corrected_depth * log(u / DEPTH)
        + own.corrected_speed * log(k.vw / SPEED)
        + own.corrected_volume * log((wheel.V + EARLY) / (VOLUME + EARLY))
    )
    more = scaled(k, (factor * k.u_ch, factor * k.kp, factor * k.pa, factor * k.pb))
    done: tuple[WheelState, Any, StrokeResult] = ground(wheel, own, S, Rs, Z, b, more, seconds)
    return done


CORRECTED = PROCESS._replace(own=joined(PROCESS.own, CorrectedOwn), stroke=_stroke)


#: fields of a material, in the order of `CorrectedOwn`
EXPONENTS = ("power_depth_exponent", "power_speed_exponent", "power_volume_exponent")


def exponents_of(material: Material) -> tuple[float, ...]:
    """Return the exponents of a material, in the order of `CorrectedOwn`."""
    return tuple(float(getattr(material, name)) for name in EXPONENTS)


def corrected_by(
    material: Material, process: Process, own: tuple[float, ...], *, open_: bool = False
) -> tuple[Process, tuple[float, ...]]:
    """Return the process of a material and its memory at the start of a shift; without exponents `PROCESS`.

    A process of another kind is not changed. `open_`: the uncertainty of the job includes exponents.
    """
    if process not in (PROCESS, CORRECTED):
        return process, own
    own, exponents = own[: len(PROCESS.own._fields)], exponents_of(material)
    if not (open_ or any(exponents)):
        return PROCESS, own
    return CORRECTED, (*(own or PROCESS.own()), *exponents)
