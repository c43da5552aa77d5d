"""The two ways to store the surfaces of parts: as a whole under a wheel that covers them, or in zones."""

from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.envs.noise_tape import KEY_0, KEY_1, NOISE_FACTOR, read_sigmas
from grind_env.envs.random_numbers import TAPER, spread, words_of
from grind_env.envs.task_gauges import TAPER_NOISE
from grind_env.kernel import inlined
from grind_env.kernel.random import normal, uniform
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.row_io import read_part, read_zone, write_part, write_zone
from grind_env.machine.part.gauging import gauge_zones
from grind_env.machine.script.replay import covered_blocks_of, zoned_blocks_of
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.process_interface import Process

NEW_PART = PartState(Z=0.0, S=0.0, Rs=INITIAL_ROUGHNESS)


class SurfaceStore(NamedTuple):
    """Functions for one way to store the surfaces of parts."""

    surfaces: str  #: field of `EpisodeArrays` with the surfaces
    #: function of `machine.script.replay` that returns the compiled grinding of blocks
    blocks_of: Callable[[Process], Callable[..., None]]
    lay: Callable[..., None]  #: `lay(surfaces, i, zones)`: puts a new part on machine i
    #: `gauge(surfaces, i, stock)`: returns the part on machine i, with its size where it is farthest from `stock`, mm,
    #: and its taper, um
    gauge: Callable[..., tuple[PartState, float]]
    #: `error(episodes, i, spreads)`: returns the gauging error of the taper after the coming block of episode i, um
    error: Callable[..., float]


@inlined
def _lay_covered(surfaces: Any, i: int, zones: Any) -> None:
    write_part(surfaces, i, NEW_PART)


@inlined
def _gauge_covered(surfaces: Any, i: int, stock: float) -> tuple[PartState, float]:
    return read_part(surfaces, i), 0.0


@inlined
def _none(episodes: Any, i: int, spreads: Any) -> float:
    return 0.0


@inlined
def _lay_zones(surfaces: Any, i: int, zones: Any) -> None:
    for number in range(zones.shape[0]):
        write_zone(surfaces[i], number, read_zone(zones, number))


@inlined
def _gauge_zones(surfaces: Any, i: int, stock: float) -> tuple[PartState, float]:
    found = gauge_zones(surfaces[i], stock)
    # if no stroke has reached one zone, the whole part counts as not reached
    reached = read_zone(surfaces[i], 0).reached
    for number in range(surfaces.shape[1]):
        reached = min(reached, read_zone(surfaces[i], number).reached)
    S = stock - 0.001 * found.worst_error
    return PartState(Z=reached, S=S, Rs=found.Ra, S_step=0.0, Rs_step=0.0), found.taper


@inlined
def _taper_error(episodes: Any, i: int, spreads: Any) -> float:
    sigma = episodes.source[i, NOISE_FACTOR] * read_sigmas(spreads, 0).measurement * TAPER_NOISE
    word, _, _, _ = words_of(episodes.source[i, KEY_0], episodes.source[i, KEY_1], TAPER, episodes.block[i])
    return spread(sigma, normal(uniform(word)))


COVERED = SurfaceStore("parts", covered_blocks_of, _lay_covered, _gauge_covered, _none)
IN_ZONES = SurfaceStore("surfaces", zoned_blocks_of, _lay_zones, _gauge_zones, _taper_error)
