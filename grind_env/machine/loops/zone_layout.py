"""The surface of a part in strips across its width, grouped into zones of equal strips."""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.control.cycles import traverse
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.machine.loops.cycle import Zone
from grind_env.machine.loops.strip_stroke import Strips
from grind_env.process.equations import INITIAL_ROUGHNESS

STRIP = 1.0  #: largest width of a strip, mm

#: number of traverses to follow. A traverse begins at one of the two ends of the crossover, at the primary or the
#: secondary reversal point; after so many all combinations that ever occur have occurred
TRAVERSES = 4


@functools.lru_cache
def strip_centres(across: float, width: float) -> Strips:
    """Return the cross coordinates of strip middles of a part that begins at `across` and is `width` wide, mm."""
    strips = math.ceil(width / STRIP)
    centres = np.asarray(across + width * (np.arange(strips) + 0.5) / strips)
    centres.flags.writeable = False
    return centres


def traverse_edges(cycle: TraverseCycle, start: float, end: float) -> list[float]:
    """Return the cross coordinates of the wheel's minus edge in a G83 from `start` to `end`, mm, for any depth."""
    followed = cycle._replace(depth=0.0, at_depth=float(TRAVERSES))
    progress, edges = traverse.begin(followed), set()
    while not traverse.finished(followed, progress):
        edges.add(traverse.cross(progress, start, end))
        progress = traverse.after_reversal(followed, progress)
    return sorted(edges)


#: functions such as `traverse_edges` for all cycles that cross, by code
EDGES: Mapping[str, Callable[[Any, float, float], Sequence[float]]] = {"G83": traverse_edges}


def zones_of(centres: Strips, edges: Iterable[float], wheel_width: float) -> Array:
    """Return a new part in zones of neighbouring strips that are under the wheel only together.

    `edges` are all places of the wheel's edge on the minus side, mm. The result has shape (zones, fields of `Zone`).
    """
    near = np.array(list(edges))[:, None]
    under = (near <= centres) & (centres < near + wheel_width)
    return _new_zones(centres, np.flatnonzero((under[:, 1:] != under[:, :-1]).any(axis=0)) + 1)


def strip_zones(centres: Strips) -> Array:
    """Return a new part with a zone a strip, shape (strips, fields of `Zone`); `centres` has shape (strips,), mm."""
    return _new_zones(centres, np.arange(1, centres.size))


def _new_zones(centres: Strips, bounds: NDArray[np.int64]) -> Array:
    firsts = np.concatenate([[0], bounds])
    counts = np.diff(np.append(firsts, centres.size))
    zone = Zone(S=0.0, Rs=INITIAL_ROUGHNESS, reached=0.0, centre=math.nan, strips=math.nan)
    return np.array([zone._replace(centre=centres[k], strips=float(n)) for k, n in zip(firsts, counts, strict=True)])
