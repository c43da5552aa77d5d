"""One deep pass at a slow feed, by hand from the formulas of the process, and what is said where it is too much."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.machine.job import Job
from grind_env.process.stroke import dressed_wheel
from grind_env.render.reasons import reason
from tests.examples import examples
from tests.machine import harness
from tests.machine.harness import CATALOGUE, HEAD, run


def job(power: float = 500_000.0) -> Job:
    machine = replace(CATALOGUE.machine("default"), power_limit=power)
    return harness.job(stock=0.5, tolerance=20.0, roughness_limit=0.1, setup={"machine": machine})


def creep(depth: float, feed: int) -> str:
    return f"{HEAD}G01 Y-{depth:.3f} F500.\nX230. F{feed}.\nG00 Y20.\nM30\n"


@given(st.integers(100, 3000).map(lambda um: 0.001 * um), st.integers(20, 1500))
@examples(30)
def test_depth_force_power_heat_and_wear_by_hand(depth: float, feed: int) -> None:
    """The elastic loop is closed by bisection here."""
    shop = job()
    p = shop.parameters
    wheel = dressed_wheel(300.0, 0.0, 0.1, 0.02, p)  # by a medium dress
    (stroke,) = run(creep(depth, feed), shop).strokes
    vw, vs, ds, b, L = feed / 60.0, 30.0, 300.0, 20.0, 200.0

    pressure = p.pm * (p.pa + p.pb * 0.004 * vw / (ds * vs))  # under the wear flats
    grains = wheel.Cd
    ploughing = p.kp * math.sqrt(grains / p.Cref)
    per_area_t, per_area_n = ploughing + p.mu * pressure * wheel.A, p.kc * ploughing + pressure * wheel.A

    def normal(ae: float) -> float:
        return p.kc * p.u_ch * ae * vw / vs + per_area_n * math.sqrt(ds * (ae + p.a0))

    low, high = 0.0, depth
    for _ in range(200):
        ae = 0.5 * (low + high)
        low, high = (ae, high) if ae + b * normal(ae) / p.ke < depth else (low, ae)

    Q, arc = ae * vw, math.sqrt(ds * (ae + p.a0))
    tangential = p.u_ch * Q / vs + per_area_t * arc
    power = tangential * vs
    contact = math.sqrt(ds * (ae + 8.0 * p.Rr**2 / (math.pi * p.E_star) * normal(ae)))
    assert stroke["ae"] == pytest.approx(ae, rel=1e-9)
    assert stroke["Q"] == pytest.approx(Q, rel=1e-9) and stroke["heq"] == pytest.approx(Q / vs, rel=1e-9)
    assert stroke["Fn"] == pytest.approx(normal(ae), rel=1e-9)
    assert stroke["power"] == pytest.approx(b * power, rel=1e-9) and stroke["u_s"] == pytest.approx(power / Q, rel=1e-9)
    assert stroke["lc"] == pytest.approx(contact, rel=1e-9)

    # Jaeger's source of heat over the contact, cooled by a film that boils off from Tb on
    jaeger = min(max(0.0912 * (2.0 * math.pi + 0.5 * vw * contact / (4.0 * p.alpha)), 0.578), 1.124)
    to_grains = p.krw / math.sqrt((1.0 + 20.8 * wheel.A) * vs)
    to_work = p.beta * math.sqrt(vw * contact / jaeger) * (1.0 + to_grains)
    heat = 1e6 * (power - min(p.e_ch * Q, 0.45 * power))
    film = p.hf * math.sqrt(vs / 30.0) * math.sqrt(2.4 / contact) * contact  # carried by the wheel
    wet, dry = heat / (to_work + film), heat / (to_work + p.kfilm * film)
    boiled = min(max((wet - p.Tb) / 20.0 + 0.5, 0.0), 1.0)
    assert stroke["T"] == pytest.approx(wet + (dry - wet) * boiled**2 * (3.0 - 2.0 * boiled), rel=1e-9)

    over = normal(ae) / (grains * contact) / p.fc - 1.0
    breaking = 1.0 + 0.5 * p.kf * (over + math.sqrt(over**2 + 0.1))
    steady = ae * L * breaking * (max(Q / vs, 0.001) / 0.1) ** p.mG / (p.Gref * math.pi * ds)
    loosened = p.wi * (p.Cref / grains) ** 4 * (1.0 - 1.0 / (1.0 + ae * L / p.Vi) ** 2)
    worn = steady + loosened
    assert stroke["G"] == pytest.approx(ae * L / (math.pi * ds * worn), rel=1e-9)
    assert stroke["dw"] == pytest.approx(worn, rel=1e-9)
    assert stroke["V"] == pytest.approx(ae * L, rel=1e-9)
    assert stroke["ds"] == pytest.approx(ds - 2.0 * worn, rel=1e-12)


def test_what_is_too_much_is_said_of_its_F() -> None:
    shop = job(2000.0)
    record = run(creep(0.5, 600), shop)
    said = {cause: reason(cause, [1], record, shop) for cause in ("power", "rise", "roughness", "size")}
    assert said["power"].startswith("line 4: ") and said["power"].endswith("; go less deep or lower F")
    assert said["rise"].endswith("; go less deep or lower F, or dress before")
    assert said["roughness"].endswith("; dress finer, lower F, or add strokes at full depth")
    assert said["size"].endswith("; add strokes at full depth, or end with less deep ones")
