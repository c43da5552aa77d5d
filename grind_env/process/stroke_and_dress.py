"""One stroke and one dress: the change of wheel and surface in one event.

`grind_stroke` and `dress_wheel` are the whole dynamics; `dressed_wheel` returns the state of a wheel at the start.
The run of a program calls these functions stroke by stroke, the compiled loops in SIMD lanes. The functions hold
conditional expressions only, so that they vectorise. `stroke_constants` computes the constants of a cycle once.
"""

import math

from grind_env.kernel import inlined, log
from grind_env.process import equations as eq
from grind_env.process.stroke_types import StrokeConstants, StrokeParameters, StrokeResult, WheelState


@inlined
def stroke_constants(p: StrokeParameters, vw: float, Lw: float) -> StrokeConstants:
    """Return the constants of all strokes at table speed `vw`, mm/s, over the length `Lw`, mm."""
    return StrokeConstants(
        n=p.n,
        vs_set=p.vs_set,
        vw=vw,
        Lw=Lw,
        pa=p.pm * p.pa,
        pb=p.pm * p.pb * eq.curvature_difference(vw),
        AL=p.AL,
        kp=p.kp,
        mu=p.mu,
        kc=p.kc,
        u_ch=p.u_ch,
        sa=math.sqrt(p.a0),
        per_ke=1.0 / p.ke,
        Cref=p.Cref,
        per_Cref=1.0 / p.Cref,
        per_Vr=1.0 / p.Vr,
        power=p.power,
        rs=p.rs,
        stall=p.rs / p.power,
        stall_time=p.stall_time,
        flattening=8.0 * p.Rr * p.Rr / (math.pi * p.E_star),
        krw=p.krw,
        beta=p.beta,
        peclet=vw / (4.0 * p.alpha),
        e_ch=p.e_ch,
        hf=eq.CARRYING * p.hf,
        kfilm=p.kfilm,
        Tb=p.Tb,
        u0=p.u0,
        Bm=p.Bm,
        per_G=1.0 / p.Gref,
        mG=p.mG,
        per_fc=1.0 / p.fc,
        kf=p.kf,
        wi=p.wi,
        per_Vi=1.0 / p.Vi,
        per_dr=1.0 / p.dr,
        turned=eq.turning(Lw, vw),
        kA=p.kA,
        kL=p.kL,
        Af=p.Af,
        Amax=p.Amax,
        per_Amax=1.0 / p.Amax,
        RaRef=p.RaRef,
        f0=p.f0,
        f1=p.f1,
        log_gm=log(p.gm),
        nr=p.nr,
        least_chips=eq.log_chip_wear(eq.PLOUGHING_CHIP, p.mG),
        ra_scale=p.ra_scale,
        per_vw=1.0 / vw,
        per_capacity=p.per_capacity,
        w_1=p.w_1,
        w_2=p.w_2,
        w_3=p.w_3,
        w_4=p.w_4,
        r_1=p.r_1,
        r_2=p.r_2,
        r_3=p.r_3,
        r_4=p.r_4,
        swell=p.swell,
    )


@inlined
def grind_stroke(
    wheel: WheelState, S: float, Rs: float, Z: float, b: float, k: StrokeConstants
) -> tuple[WheelState, StrokeResult]:
    """Return the wheel after one pass over the part, and the results of the stroke.

    Depth of cut and normal force balance the elastic loop at the set wheel speed. Where the spindle slows, the result
    has the force of the slower wheel. The further deflection by this force is neglected, here and in all later strokes,
    which begin from the depth that was cut.

    Args:
        wheel: state before the stroke.
        S: stock removed so far under the wheel, mm.
        Rs: roughness of the surface before the stroke, um.
        Z: downfeed position of the wheel, mm; u = Z - W - S is the interference.
        b: engaged width, mm.
        k: constants of the cycle.

    Returns:
        The wheel after the stroke, and the stroke. The surface is then at S + ae with roughness Ra.
    """
    speed = eq.wheel_speed(wheel.ds, k.n, k.vs_set)
    per_speed = 1.0 / (wheel.ds * speed)
    per_ds, sd = per_speed * speed, math.sqrt(wheel.ds)
    u = Z - wheel.W - S

    fresh = eq.freshness(wheel.V, k.per_Vr)
    C = eq.grain_density(wheel.Cd, fresh, k.Cref)
    Kp = eq.ploughing_pressure(C, wheel.lam, k.kp, k.per_Cref)
    flats = eq.wear_flat_pressure(per_speed, k.pa, k.pb) * eq.flat_area(wheel.A, wheel.lam, k.AL)
    Kt, Kn = Kp + k.mu * flats, k.kc * Kp + flats

    per_speed_set = per_speed * wheel.ds
    give = b * k.per_ke
    F0 = eq.threshold_force(Kn, sd, k.sa)
    chip = eq.chip_force(k.vw, per_speed_set, k.u_ch)
    x = eq.cut_root(u, give, F0, Kn, sd, k.sa, chip, k.kc)
    ae = eq.depth_of_cut(x, k.sa)
    rubbing = eq.rubbing_length(x, eq.pressed_share(u, give, F0), sd, k.sa)
    Q = ae * k.vw

    kept, over = eq.slowing(k.power - b * k.u_ch * Q, b * Kt * rubbing * speed, k.rs)
    vs, per_vs = speed * kept, per_speed_set * over
    Ft_c = eq.chip_force(Q, per_vs, k.u_ch)
    Ft = Ft_c + Kt * rubbing
    Fn = k.kc * Ft_c + Kn * rubbing
    P_width = Ft * vs
    load = b * Ft * speed
    heq = Q * per_vs
    lc = eq.contact_length(ae, sd, Fn, k.flattening)
    fg = eq.force_per_grain(Fn, C, lc)

    work, sink = eq.conductances(lc, k.vw, k.beta, eq.jaeger_factor(lc, k.peclet), wheel.A, vs, k.krw)
    film = eq.film_conductance(lc, vs, wheel.lam, k.hf)
    T = eq.temperature(eq.retained_heat(P_width, Q, k.e_ch), work * (1.0 + sink), film, k.kfilm, k.Tb)
    flow = eq.heat_flow(T, work)
    burns = eq.burn_power(Q, rubbing, k.vw, sink, k.u0, k.Bm)

    dV = ae * k.Lw
    breaking, chips = eq.fracture(fg, k.per_fc, k.kf), eq.log_chip_wear(heq, k.mG)
    steady = eq.steady_wear(dV, breaking, chips, k.per_G, per_ds)
    renewal = min(steady * k.per_dr, 1.0)
    dw = steady + eq.early_wear(eq.early_loss(wheel.Cd, k.Cref, k.wi), wheel.V, dV, k.per_Vi)
    sliding = eq.grain_sliding(rubbing, vs, per_ds, k.turned)
    growth = eq.wear_flat_growth(sliding, T, wheel.A, k.kA, k.per_Amax)

    Rt = eq.wheel_roughness(wheel.Rd, fresh, k.RaRef)
    roughened = eq.roughening(breaking, chips, k.least_chips, k.log_gm, k.nr)
    Rg = eq.generated_roughness(Rt, Q, per_vs, wheel.lam, k.f0, k.f1, roughened, k.ra_scale)
    Ra = eq.surface_roughness(Rs, Rg, ae, u)

    after = WheelState(
        ds=eq.worn_diameter(wheel.ds, dw),
        A=eq.worn_flat_area(wheel.A, growth, renewal, k.Af, k.Amax),
        lam=min(wheel.lam + k.kL * dV * (1.0 - wheel.lam), 1.0) - wheel.lam * renewal,
        V=wheel.V + dV,
        Rd=wheel.Rd,
        Cd=wheel.Cd,
        W=wheel.W + dw,
        wd=wheel.wd,
    )
    return after, StrokeResult(
        ae=ae,
        Q=Q,
        heq=heq,
        Ft=Ft,
        Fn=Fn,
        power=min(b * P_width, k.power),
        u_s=eq.specific_energy(P_width, Q),
        lc=lc,
        fg=fg,
        vs=vs,
        load=load,
        mean_load=load,
        torque=load * k.stall,
        T=T,
        heat=b * flow,
        eps=eq.energy_partition(flow, P_width),
        burn_ratio=eq.burn_ratio(P_width, burns),
        G=eq.g_ratio(dV, dw, wheel.ds),
        dw=dw,
        worn=math.pi * wheel.ds * dw * b,
        Rg=Rg,
        Ra=Ra,
    )


@inlined
def dress_wheel(
    wheel: WheelState, passes: float, lead: float, depth: float, p: StrokeParameters
) -> tuple[WheelState, float]:
    """Return the wheel after one dress execution, and the wheel volume dressed off.

    Args:
        wheel: state before the dress.
        passes: diamond passes across the wheel.
        lead: dress lead fd, mm per wheel revolution.
        depth: dress depth ad of each pass, mm.
        p: parameters.

    Returns:
        The wheel after the dress, its face measured anew (W = 0), and the wheel volume dressed off, mm3.
    """
    phi = eq.restored_fraction(passes, depth, wheel.lam, wheel.A, p.dd)
    keep = 1.0 - phi
    new = dressed_wheel(wheel.ds, wheel.wd, lead, depth, p)
    removed = eq.dressed_volume(passes, depth, wheel.ds, p.bs)
    after = WheelState(
        ds=eq.worn_diameter(wheel.ds, passes * depth),
        A=new.A + keep * (wheel.A - new.A),
        lam=keep * wheel.lam,
        V=keep * wheel.V,
        Rd=phi * new.Rd + keep * wheel.Rd,
        Cd=phi * new.Cd + keep * wheel.Cd,
        W=0.0,
        wd=wheel.wd,
    )
    return after, removed


@inlined
def dressed_wheel(ds: float, wd: float, lead: float, depth: float, p: StrokeParameters) -> WheelState:
    """Return a wheel of diameter `ds`, fully dressed by a diamond of wear flat `wd`; all lengths are mm."""
    blunt = eq.blunting(wd, p.b0)
    s = eq.severity(depth, lead, blunt, p.qs)
    return WheelState(
        ds=ds,
        A=eq.dressed_flat_area(s, p.Ad, p.Amax),
        lam=0.0,
        V=0.0,
        Rd=eq.dressed_roughness(lead, depth, blunt, p.RaRef, p.nf, p.na, p.nw, p.qr),
        Cd=eq.dressed_density(s, p.Cref),
        W=0.0,
        wd=wd,
    )
