"""The rule of a shop that watches the burning line."""

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.kernel import entry
from grind_env.kernel.columns import column_reader
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.instruments import Instruments
from grind_env.policies.scripted.rules import REFERENCE_AREA
from grind_env.process.equations import burn_power, burn_ratio, conductances, wheel_speed
from grind_env.process.state import StrokeParameters


class Ground(NamedTuple):
    """The last block as the machine saw it."""

    power: Any
    """Mean power, W; 0 for none."""
    speed: Any
    """E, m/min."""
    pick: Any
    width: Any
    diameter: Any


read_ground, read_parameters = column_reader(Ground), column_reader(StrokeParameters)


@dataclass
class BurnLine:
    """Dress and slow down as the measured specific energy comes near the burning line (Malkin 1978).

    The work burns where the specific energy u = P / (b a v_w) reaches u* = u0 + B d_e^(1/4) a^(-3/4) v_w^(-1/2). A
    shop draws this line once for its material and watches the power: the ratio u / u* tells of a dull wheel whatever
    depth and table speed it ground with. One execution a block is made as long as the last ratio is above
    `margin`; E is lowered where it is above `near`, which spares the spindle.

    Attributes:
        E: m/min, by kind of block.
        margin: u / u* above which a block of each kind is dressed.
        near: u / u* from which E falls.
        slowing: exponent of the fall, E (near / ratio)^slowing.
    """

    E: tuple[float, ...]
    margin: tuple[float, ...]
    near: float
    slowing: float
    name: ClassVar[str] = "burn_line"
    sees: ClassVar[Sees] = "measurements"
    task: Task = field(init=False, repr=False)
    instruments: Instruments = field(init=False, repr=False)
    parameters: Array = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Nothing has been ground."""
        self.task, self.instruments = simulation.task, Instruments(simulation, episodes)
        self.parameters = simulation.branches.nominal

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Compare."""
        seen = self.instruments.read(observation)
        ground = Ground(*(seen[each] for each in ("mean_power", "last_speed", "last_pick", "last_width", "diameter")))
        ratios = np.zeros(len(observation))
        _ratios(self.parameters, self.instruments.last_kind, np.stack(ground, axis=1), ratios)
        dress = ratios > self.instruments.of_kind(self.margin)
        slower = (self.near / np.maximum(ratios, self.near)) ** self.slowing
        speeds = 1000.0 * self.instruments.of_kind(self.E) * slower
        return Decision(nearest_speed(self.task, speeds), dress.astype(np.float64))


@entry
def _ratios(parameters: Any, kinds: Any, blocks: Any, ratios: Any) -> None:
    """Write u / u* of every block; 0 where no power was measured.

    The line is drawn for the programmed depth and a wheel of middling sharpness: a shop knows no other.
    """
    for i in range(blocks.shape[0]):
        seen = read_ground(blocks, i)
        if seen.power > 0.0:
            p = read_parameters(parameters, kinds[i])
            vw = 1000.0 * seen.speed / 60.0
            vs = wheel_speed(seen.diameter, p.n, p.vs_set)
            contact = math.sqrt(seen.diameter * seen.pick)
            _, sink = conductances(contact, vw, p.beta, 1.0, REFERENCE_AREA, vs, p.krw)
            line = burn_power(seen.pick * vw, contact, vw, sink, p.u0, p.Bm)
            ratios[i] = burn_ratio(seen.power / seen.width, line)
