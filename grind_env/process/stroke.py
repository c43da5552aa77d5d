"""One stroke and one dress execution: wheel and surface forward by one event.

`grind_stroke` and `dress_wheel` are the whole dynamics; `dressed_wheel` is the state of a wheel at the start.
The run of a program calls them stroke by stroke, the compiled loops in SIMD lanes; they hold conditional expressions
only, so that they vectorise.
"""

import math

from grind_env.kernel import inlined
from grind_env.process import equations as eq
from grind_env.process.state import StrokeParameters, StrokeResult, WheelState


@inlined
def grind_stroke(
    wheel: WheelState, S: float, Rs: float, Z: float, vw: float, b: float, Lw: float, p: StrokeParameters
) -> tuple[WheelState, StrokeResult]:
    """One pass of the wheel over the part.

    Args:
        wheel: state before the stroke.
        S: stock removed so far under the wheel, mm.
        Rs: roughness of the surface before the stroke, um.
        Z: downfeed position of the wheel, mm; u = Z - W - S is the interference.
        vw: table speed, mm/s.
        b: engaged width, mm.
        Lw: ground length, mm.
        p: parameters.

    Returns:
        The wheel after the stroke, and the stroke. The surface is then at S + ae with roughness Ra.
    """
    de = wheel.ds
    vs = eq.wheel_speed(wheel.ds, p.n, p.vs_set)
    u = Z - wheel.W - S

    C = eq.grain_density(wheel.Cd, wheel.V, p.Cref, p.Vr)
    pressure = eq.wear_flat_pressure(eq.curvature_difference(vw, vs, de), p.pm, p.pa, p.pb)
    Ae = eq.flat_area(wheel.A, wheel.lam, p.AL)
    Fpl = eq.ploughing_force(C, wheel.lam, p.Fpl0, p.Cref)
    ae = eq.depth_of_cut(u, b, pressure, Ae, Fpl, de, vw, vs, p.u_ch, p.kc, p.ke)

    Ft_c = eq.chip_force(ae, vw, vs, p.u_ch)
    Fn_sl = eq.sliding_force(ae, de, pressure, Ae)
    Fn = eq.normal_force(Ft_c, Fpl, Fn_sl, u, b, p.kc, p.ke)
    Ft = eq.tangential_force(Ft_c, Fpl, Fn_sl, Fn, p.mu, p.kc)
    Q = ae * vw
    heq = Q / vs
    u_s = eq.specific_energy(Ft, vs, Q)
    lc = eq.contact_length(ae, de, Fn, p.Rr, p.E_star)
    fg = eq.force_per_grain(Fn, C, lc)

    Rws = eq.work_partition(wheel.A, vs, p.kg, p.beta)
    hw = eq.work_conductance(lc, vw, p.beta, eq.jaeger_factor(lc, vw, p.alpha))
    P_width = Ft * vs
    T = eq.temperature(P_width, Q, lc, hw, Rws, wheel.lam, p.hf, p.Tb)
    Br = u_s / eq.burn_threshold(ae, de, vw, Rws, p.u0, p.Bm)
    eps = T * hw * lc / (1e6 * P_width) if P_width > 0.0 else 0.0

    dV = ae * Lw
    G = eq.g_ratio(heq, fg, wheel.V, p.Gref, p.gm, p.mG, p.href, p.fc, p.kf, p.kt, p.Vt)
    dw = dV / (math.pi * wheel.ds * G)
    renewal = min(dw / p.dr, 1.0)
    sliding = eq.grain_sliding(ae, de, vs, vw, Lw, wheel.ds)
    growth = eq.wear_flat_growth(sliding, T, wheel.A, p.kA, p.ka, p.Amax)
    Kn = eq.grinding_stiffness(ae, de, b, pressure, Ae, vw, vs, p.u_ch, p.kc)
    alw = eq.waviness(wheel.alw, dV, Kn, p.ke, p.Vchi, p.ks, p.kr, p.alw0)

    Rt = eq.wheel_roughness(wheel.Rd, wheel.V, p.RaRef, p.Vr)
    Rg = eq.generated_roughness(Rt, heq, wheel.lam, wheel.alw, p.x, p.cw, p.ra_scale)
    Ra = eq.surface_roughness(Rs, Rg, ae)

    after = WheelState(
        ds=eq.worn_diameter(wheel.ds, dw),
        A=eq.worn_flat_area(wheel.A, growth, renewal, p.Af, p.Amax),
        lam=wheel.lam + p.kL * dV * (1.0 - wheel.lam) - wheel.lam * renewal,
        V=wheel.V + dV,
        Rd=wheel.Rd,
        Cd=wheel.Cd,
        alw=alw,
        W=wheel.W + dw,
        wd=wheel.wd,
    )
    worn = math.pi * wheel.ds * dw * b
    return after, StrokeResult(
        ae=ae,
        Q=Q,
        heq=heq,
        Ft=Ft,
        Fn=Fn,
        power=b * P_width,
        u_s=u_s,
        lc=lc,
        fg=fg,
        T=T,
        eps=eps,
        Br=Br,
        G=G,
        dw=dw,
        worn=worn,
        Rg=Rg,
        Ra=Ra,
    )


@inlined
def dress_wheel(
    wheel: WheelState, passes: float, lead: float, depth: float, p: StrokeParameters
) -> tuple[WheelState, float]:
    """One dress execution.

    Args:
        wheel: state before the dress.
        passes: diamond passes across the wheel.
        lead: dress lead fd, mm per wheel revolution.
        depth: dress depth ad of each pass, mm.
        p: parameters.

    Returns:
        The wheel after the dress, its face measured anew (W = 0), and the wheel volume dressed off, mm3.
    """
    Ud = eq.overlap_ratio(eq.dress_width(depth, p.rd, wheel.wd), lead)
    phi = eq.restored_fraction(passes, depth, wheel.lam, wheel.A, p.dd)
    keep = 1.0 - phi
    Ad = eq.dressed_flat_area(Ud, p.Ad0, p.kU)
    removed = eq.dressed_volume(passes, depth, wheel.ds, p.bs)
    after = WheelState(
        ds=eq.worn_diameter(wheel.ds, passes * depth),
        A=Ad + keep * (wheel.A - Ad),
        lam=keep * wheel.lam,
        V=keep * wheel.V,
        Rd=phi * eq.dressed_roughness(lead, depth, Ud, p.RaRef) + keep * wheel.Rd,
        Cd=phi * eq.dressed_density(Ud, p.Cref) + keep * wheel.Cd,
        alw=p.alw0 + keep * (wheel.alw - p.alw0),
        W=0.0,
        wd=wheel.wd + p.kd * removed,
    )
    return after, removed


@inlined
def dressed_wheel(ds: float, wd: float, lead: float, depth: float, p: StrokeParameters) -> WheelState:
    """A wheel of diameter `ds`, fully dressed with a diamond of wear flat `wd` (lead and depth in mm)."""
    Ud = eq.overlap_ratio(eq.dress_width(depth, p.rd, wd), lead)
    return WheelState(
        ds=ds,
        A=eq.dressed_flat_area(Ud, p.Ad0, p.kU),
        lam=0.0,
        V=0.0,
        Rd=eq.dressed_roughness(lead, depth, Ud, p.RaRef),
        Cd=eq.dressed_density(Ud, p.Cref),
        alw=p.alw0,
        W=0.0,
        wd=wd,
    )
