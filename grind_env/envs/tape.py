"""The rows of the noise tape, and the compiled loops that write them from random numbers."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.hidden import CUT
from grind_env.envs.contexts import Fixed
from grind_env.kernel import entry, exp, inlined
from grind_env.kernel.columns import column_reader, column_writer


class TapeRow(NamedTuple):
    """What the tape holds for one block."""

    kind: float
    """Index of the block kind."""
    stock: float
    """True stock, mm, on the resolution of the control (1 um)."""
    gauged: float
    """Pre-gauged stock, mm."""
    new_lot: float
    """1 if the part begins a new lot."""
    kA: float
    """Factor on the wear-flat growth."""
    pm: float
    """Factor on the wear-flat pressure."""
    hf: float
    """Factor on the convection."""
    fc: float
    """Factor on the fracture force."""
    Gref: float
    """Factor on the G-ratio."""
    ra_scale: float
    """Factor on the roughness, of wheel and part."""
    part_ra: float
    """Factor on the roughness, of the part alone."""
    mean_noise: float
    """Noise of the mean power, standard normal times `Spread.measurement`, relative and absolute alike; no unit."""
    first_noise: float
    """Of the first power, likewise; no unit."""
    peak_noise: float
    """Of the peak power, likewise; no unit."""
    size_noise: float
    """Noise of the size gauge, likewise; no unit."""
    roughness_noise: float
    """Noise of the roughness gauge, likewise; no unit."""
    wheel_noise: float
    """Noise of the gauged wheel diameter, likewise; no unit."""
    material: float
    """Index of the material among `catalogue.materials`."""
    spare_kA: float
    """The factor `kA` after a wheel change; every wheel after the first has the factors of the spare wheel."""
    spare_ra_scale: float
    """The factor `ra_scale` after a wheel change."""
    due: float
    """Next due date, s after the start of the episode; 0 in a task without."""
    work: float
    """Nominal time of this block and of those after it up to that date, s."""
    is_due: float
    """1 for the last block before the date."""


SPARE_FACTORS = ("spare_kA", "pm", "hf", "fc", "Gref", "spare_ra_scale")
"""Where the factors stand after a wheel change."""

read_row, write_row = column_reader(TapeRow), column_writer(TapeRow)
DUE, WORK, IS_DUE = (TapeRow._fields.index(name) for name in ("due", "work", "is_due"))


class Sigmas(NamedTuple):
    """`tasks.Spread`, and the drift that one of its numbers is relative to.

    `gauge` and `diamond_flat` are mm, `lot_probability` is a probability. `stock`, `measurement`, `lot_growth`,
    `lot_pressure`, `wheel_growth`, `wheel_roughness`, `part_roughness`, `fracture_force`, `g_ratio`, `convection` and
    `coolant_ageing` have no unit.
    """

    stock: float
    gauge: float
    measurement: float
    lot_probability: float
    lot_growth: float
    lot_pressure: float
    wheel_growth: float
    wheel_roughness: float
    part_roughness: float
    fracture_force: float
    g_ratio: float
    convection: float
    coolant_ageing: float
    diamond_flat: float
    ageing: float
    """Log convection lost with every part, no unit."""


@inlined
def log_normal(sigma: float, z: float) -> float:
    """Log-normal factor for a standard normal number z, which is cut at `CUT`."""
    return exp(sigma * min(max(z, -CUT), CUT))


@inlined
def unless(fixed: float, drawn: float) -> float:
    """The fixed number, or the drawn one where none is fixed (NaN)."""
    return drawn if np.isnan(fixed) else fixed


@entry
def deal_orders(kinds: Any, begins: Any, uniforms: Any, count: int, most: int) -> None:
    """Write the kind of every block: orders of a random kind with 1 to `most` parts."""
    left, kind = 0, 0
    for k in range(kinds.size):
        begins[k] = left == 0
        if left == 0:
            kind = min(int(uniforms[k, 0] * count), count - 1)
            left = 1 + min(int(uniforms[k, 1] * most), most - 1)
        kinds[k] = kind
        left -= 1


@entry
def fill(
    tape: Any,
    kinds: Any,
    begins: Any,
    stocks: Any,
    least: Any,
    starts: Any,
    materials: Any,
    normals: Any,
    wheel_normals: Any,
    uniforms: Any,
    ageing: float,
    spare: Any,
    sigmas: Sigmas,
    fixed: Fixed,
) -> None:
    """Write all rows but their due dates.

    Args:
        tape: shape (blocks, fields of `TapeRow`); written.
        kinds: kind of every block.
        begins: whether a block begins an order; without orders, only the first does.
        stocks: nominal stock of each kind, mm, like the next three by kind.
        least: least stock over nominal.
        starts: whether it starts a part.
        materials: index of its material.
        normals: standard normal numbers, shape (blocks + 1, NORMALS of `episode`).
        wheel_normals: of the gauged diameter, shape (blocks,).
        uniforms: shape (blocks + 1,).
        ageing: uniform number of the ageing rate of the coolant.
        spare: normal numbers of the spare wheel, shape (2,).
        sigmas: spreads of the task.
        fixed: what a context fixes.
    """
    episode = normals[tape.shape[0]]
    wheel_kA = unless(fixed.wheel_kA, log_normal(sigmas.wheel_growth, episode[0]))
    spare_kA = unless(fixed.wheel_kA, log_normal(sigmas.wheel_growth, spare[0]))
    wheel_ra, spare_ra = log_normal(sigmas.wheel_roughness, episode[1]), log_normal(sigmas.wheel_roughness, spare[1])
    hf = unless(fixed.hf, log_normal(sigmas.convection, episode[4]))
    rate = sigmas.ageing * unless(fixed.coolant_ageing, 1.0 + sigmas.coolant_ageing * (2.0 * ageing - 1.0))
    fc = unless(fixed.fc, log_normal(sigmas.fracture_force, episode[2]))
    Gref = unless(fixed.Gref, log_normal(sigmas.g_ratio, episode[3]))
    noise = unless(fixed.noise, 1.0)
    gauge, measurement = noise * sigmas.gauge, noise * sigmas.measurement
    # a lot that differs from the last one in nothing is no new lot
    lots = np.isnan(fixed.kA) | np.isnan(fixed.pm)
    lot_kA, lot_pm, part_ra, parts = 1.0, 1.0, 1.0, 0.0
    for k in range(tape.shape[0]):
        z = normals[k]
        starts_part = starts[kinds[k]]
        nominal = stocks[kinds[k]]
        new_lot = begins[k] or (lots and starts_part and uniforms[k] < sigmas.lot_probability)
        if new_lot:
            lot_kA = unless(fixed.kA, log_normal(sigmas.lot_growth, z[2]))
            lot_pm = unless(fixed.pm, log_normal(sigmas.lot_pressure, z[3]))
        stock, gauged = nominal, nominal
        if starts_part:
            parts += 0.0 if k == 0 else 1.0
            part_ra = log_normal(sigmas.part_roughness, z[9]) if np.isnan(fixed.ra_scale) else 1.0
            stock = nominal * unless(fixed.stock, max(least[kinds[k]], 1.0 + sigmas.stock * z[0]))
            stock = np.floor(1000.0 * stock + 0.5) / 1000.0
            gauged = max(stock + gauge * z[1], 0.3 * nominal)
        shown = 1.0 if new_lot else 0.0  # numba takes no condition among so many keywords
        row = TapeRow(
            kind=float(kinds[k]),
            stock=stock,
            gauged=gauged,
            new_lot=shown,
            kA=lot_kA * wheel_kA,
            pm=lot_pm,
            hf=hf * exp(-rate * parts),
            fc=fc,
            Gref=Gref,
            ra_scale=unless(fixed.ra_scale, wheel_ra * part_ra),
            part_ra=part_ra,
            mean_noise=measurement * z[4],
            first_noise=measurement * z[5],
            peak_noise=measurement * z[6],
            size_noise=measurement * z[7],
            roughness_noise=measurement * z[8],
            wheel_noise=measurement * wheel_normals[k],
            material=unless(fixed.material, materials[kinds[k]]),
            spare_kA=lot_kA * spare_kA,
            spare_ra_scale=unless(fixed.ra_scale, spare_ra * part_ra),
            due=0.0,
            work=0.0,
            is_due=0.0,
        )
        write_row(tape, k, row)


@entry
def fill_dates(tape: Any, kinds: Any, nominal: Any, factors: Any) -> None:
    """Write the due dates; `factors` has one entry a date, `nominal` the seconds of each kind."""
    size = tape.shape[0] // factors.size
    due = 0.0
    for date in range(factors.size):
        last = (date + 1) * size - 1
        work = 0.0
        for k in range(last, last - size, -1):
            work += nominal[kinds[k]]
            tape[k, WORK] = work
            tape[k, IS_DUE] = 1.0 if k == last else 0.0
        due += factors[date] * work
        for k in range(last - size + 1, last + 1):
            tape[k, DUE] = due
