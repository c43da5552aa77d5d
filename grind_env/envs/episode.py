"""The noise tape: everything random in an episode, drawn at reset.

The same seed therefore means the same stock, lots, wheel and measurement noise, whatever the policy does, and
policies can be compared on common random numbers.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.tasks import Task
from grind_env.kernel import entry, exp, inlined
from grind_env.kernel.rows import column_writer
from grind_env.machine.compiled import dressed_wheel
from grind_env.process.state import WheelState

CUT = 1.8
"""Log-normal factors are cut at this many standard deviations, so that every wheel holds the limits at some E."""


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
    """Factor on the roughness."""
    mean_noise: float
    """Noise of the mean power, standard normal times `Spread.measurement`, relative and absolute alike."""
    first_noise: float
    peak_noise: float
    size_noise: float
    """Noise of the size gauge, likewise."""
    roughness_noise: float
    """Noise of the roughness gauge, likewise."""


FACTORS = ("kA", "pm", "hf", "fc", "Gref", "ra_scale")
"""The factors of a tape row, each on the stroke parameter of the same name."""

write_row = column_writer(TapeRow)

NORMALS = 9
"""Standard normal numbers drawn for a block."""


class EpisodeGenerator:
    """Draws the episodes of a task."""

    def __init__(self, task: Task) -> None:
        spread = task.spread
        self.blocks = task.blocks
        self.kinds = np.array([task.kind_of_block(k) for k in range(task.blocks)])
        self.stocks = np.array([kind.stock for kind in task.kinds])
        self.starts = np.array([kind.starts_part for kind in task.kinds])
        self.diamond_flat = spread.diamond_flat
        self.part_spread = (spread.stock, spread.gauge, spread.measurement)
        self.lot_spread = (spread.lot_probability, spread.lot_growth, spread.lot_pressure)
        self.wheel_spread = (
            spread.wheel_growth,
            spread.wheel_roughness,
            spread.fracture_force,
            spread.g_ratio,
            spread.convection,
        )
        self.diameter, self.lead, self.depth = task.wheel.diameter, task.dress_lead, task.dress.depth
        self.start = task.start
        self.parameters = task.parameters(task.kinds[0])

    def draw(self, rng: np.random.Generator) -> tuple[NDArray[np.float64], float]:
        """The tape of one episode, shape (blocks, fields of `TapeRow`), and the diamond's first wear flat, mm.

        The count of random numbers depends on the task only, never on what they turn out to be.
        """
        normals = rng.standard_normal((self.blocks + 1, NORMALS))
        uniforms = rng.random(self.blocks + 1)
        tape = np.empty((self.blocks, len(TapeRow._fields)))
        _fill(
            tape,
            self.kinds,
            self.stocks,
            self.starts,
            normals,
            uniforms,
            self.part_spread,
            self.lot_spread,
            self.wheel_spread,
        )
        return tape, self.diamond_flat * float(uniforms[self.blocks])

    def wheel(self, diamond_flat: float) -> WheelState:
        """The wheel at the start of an episode, dressed with a diamond of that wear flat (mm)."""
        wheel = dressed_wheel(self.diameter, diamond_flat, self.lead, self.depth, self.parameters)
        area = self.start.wear_flat_area
        return wheel._replace(A=wheel.A if area is None else area, V=self.start.volume)


@inlined
def log_normal(sigma: float, z: float) -> float:
    """Cut log-normal factor for a standard normal number z."""
    return exp(sigma * min(max(z, -CUT), CUT))


@entry
def _fill(
    tape: Any,
    kinds: Any,
    stocks: Any,
    starts: Any,
    normals: Any,
    uniforms: Any,
    parts: Any,
    lots: Any,
    wheels: Any,
) -> None:
    stock_sigma, gauge_sigma, measurement = parts
    probability, lot_growth, lot_pressure = lots
    wheel_growth, roughness, fracture, g_ratio, convection = wheels
    episode = normals[tape.shape[0]]
    lot_kA, lot_pm = 1.0, 1.0
    for k in range(tape.shape[0]):
        z = normals[k]
        nominal = stocks[kinds[k]]
        new_lot = k == 0 or (starts[kinds[k]] and uniforms[k] < probability)
        if new_lot:
            lot_kA, lot_pm = log_normal(lot_growth, z[2]), log_normal(lot_pressure, z[3])
        stock = nominal * max(0.4, 1.0 + stock_sigma * z[0])
        stock = np.floor(1000.0 * stock + 0.5) / 1000.0
        row = TapeRow(
            kind=float(kinds[k]),
            stock=stock,
            gauged=max(stock + gauge_sigma * z[1], 0.3 * nominal),
            new_lot=1.0 if new_lot else 0.0,
            kA=lot_kA * log_normal(wheel_growth, episode[0]),
            pm=lot_pm,
            hf=log_normal(convection, episode[4]),
            fc=log_normal(fracture, episode[2]),
            Gref=log_normal(g_ratio, episode[3]),
            ra_scale=log_normal(roughness, episode[1]),
            mean_noise=measurement * z[4],
            first_noise=measurement * z[5],
            peak_noise=measurement * z[6],
            size_noise=measurement * z[7],
            roughness_noise=measurement * z[8],
        )
        write_row(tape, k, row)
