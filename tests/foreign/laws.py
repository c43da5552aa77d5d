"""Textbook laws of grinding for out-of-model machines, with NumPy and no line of `grind_env`.

A law gives the power of a stroke (W per mm of width), the dulling of the wheel per mm3/mm, its G ratio, and Ra (um).
Depths are in mm, table speeds in mm/s, volumes in mm3 per mm of width. A law also has the stiffness of machine and
wheel (N/mm), the ratio of normal to tangential force, and the share of the heat into the part.
"""

from dataclasses import dataclass, field

import numpy as np

WHEEL_SPEED, DIAMETER = 30.0, 300.0  #: wheel speed (m/s) and wheel diameter (mm)
EFFUSIVITY = 11.6  #: effusivity of hardened bearing steel, kJ/(m2 K s^1/2)


def thickness(depth: float, speed: float) -> float:
    """Return the equivalent chip thickness, um."""
    return max(depth * speed / WHEEL_SPEED, 2e-3)


def contact(depth: float) -> float:
    """Return the length of contact, mm."""
    return float(np.sqrt(max(depth, 1e-6) * DIAMETER))


@dataclass
class Werner:
    """Forces as powers of the equivalent chip thickness, which grow with the root of the ground volume.

    G. Werner, Kinematik und Mechanik des Schleifprozesses (1971); Snoeys, Peters and Decneut, Annals of the CIRP 23
    (1974) 227, for roughness and G ratio over the equivalent chip thickness.
    """

    stiffness: float = 18_000.0
    normal_force_ratio: float = 2.6
    share: float = 0.22

    def power(self, depth: float, speed: float, dull: float) -> float:
        """Return the power of a stroke by a power law of the chip thickness."""
        return 25.0 * (thickness(depth, speed) / 0.1) ** -0.4 * depth * speed * (1.0 + dull)

    def dulls(self, depth: float, speed: float, dull: float) -> float:
        """Return the dulling: the wheel is twice as dull after four times the volume."""
        return 0.5 * 0.11**2 / max(dull, 0.05)

    def wears(self, depth: float, speed: float, volume: float) -> float:
        """Return the G ratio by a power law of the chip thickness."""
        return 45.0 * (thickness(depth, speed) / 0.1) ** -0.5

    def roughness(self, depth: float, speed: float, volume: float, dull: float) -> float:
        """Return Ra by a power law of the chip thickness, larger on a worn wheel."""
        return 0.62 * (thickness(depth, speed) / 0.1) ** 0.32 * (1.0 + volume / 600.0)


@dataclass
class Flats:
    """Chips at a constant energy, and sliding wear flats, which grow until grains break out.

    S. Malkin and C. Guo, Grinding Technology (2008), chapters 5 and 9.
    """

    stiffness: float = 40_000.0
    normal_force_ratio: float = 2.0
    share: float = 0.8
    breaks: float = 0.055  #: share of wear flats at which grains break out as fast as they dull

    def power(self, depth: float, speed: float, dull: float) -> float:
        """Return the power of the chips and of the friction of flats in contact."""
        flats = 0.008 + dull
        return 12.5 * depth * speed + 0.35 * 85.0 * flats * contact(depth) * WHEEL_SPEED

    def dulls(self, depth: float, speed: float, dull: float) -> float:
        """Return the dulling: slower near the share at which grains break out, faster on slow tables (more sliding)."""
        return 4.5e-4 * (200.0 / max(speed, 50.0)) ** 0.5 * max(1.0 - dull / self.breaks, 0.0)

    def wears(self, depth: float, speed: float, volume: float) -> float:
        """Return the G ratio, low at first: a fast early loss."""
        return 60.0 * (volume + 2.0) / (volume + 15.0)

    def roughness(self, depth: float, speed: float, volume: float, dull: float) -> float:
        """Return Ra by the speed of the table (Malkin), smoother as flats grow."""
        return 0.24 * (speed / 150.0) ** 0.45 / (1.0 + 4.0 * dull)


@dataclass
class Loading:
    """Size effect by the depth of the grains' chips, and a wheel that loads with chips until it is full.

    M. C. Shaw, Principles of Abrasive Processing (1996), chapter 6, for the size effect; for loading Lauer-Schmaltz and
    Koenig, Annals of the CIRP 29 (1980) 201.
    """

    stiffness: float = 25_000.0
    normal_force_ratio: float = 3.0
    share: float = 0.45
    full: float = 1.1  #: additional share of power of a full wheel

    def power(self, depth: float, speed: float, dull: float) -> float:
        """Return the power by the depth of a chip: root of the table speed times fourth root of the depth of cut."""
        chip = (speed / 200.0) ** 0.5 * (depth / 0.01) ** 0.25
        return 22.0 * max(chip, 0.05) ** -0.7 * depth * speed * (1.0 + dull)

    def dulls(self, depth: float, speed: float, dull: float) -> float:
        """Return the dulling: slower the fuller the pores are."""
        return max(self.full - dull, 0.0) / 90.0

    def wears(self, depth: float, speed: float, volume: float) -> float:
        """Return a constant G ratio."""
        return 55.0

    def roughness(self, depth: float, speed: float, volume: float, dull: float) -> float:
        """Return Ra by the table speed; loaded wheels smear."""
        return 0.3 * (speed / 150.0) ** 0.3 * (1.0 + 0.35 * dull)


@dataclass
class Threshold:
    """Removal in proportion to the force above a threshold; below it grains only rub, and heavy cuts break them out.

    R. S. Hahn and R. P. Lindsay, Principles of grinding, Machinery 77 (1971), parts 1 to 5.
    """

    stiffness: float = 30_000.0
    normal_force_ratio: float = 2.4
    share: float = 0.35
    breaks: float = 230.0  #: power, W per mm of width, at which grains break out as fast as they dull

    def power(self, depth: float, speed: float, dull: float) -> float:
        """Return the power, a straight line over the removal rate; dull grains rub more and remove less."""
        return 18.0 * (1.0 + 2.5 * dull) + 32.0 * depth * speed * (1.0 + 0.6 * dull)

    def dulls(self, depth: float, speed: float, dull: float) -> float:
        """Return the dulling: in proportion to the volume, slower in heavy cuts."""
        return 0.0045 * max(1.0 - (self.power(depth, speed, dull) / self.breaks) ** 2, 0.0)

    def wears(self, depth: float, speed: float, volume: float) -> float:
        """Return the G ratio, lower in heavy cuts."""
        return 70.0 / (1.0 + (self.power(depth, speed, 0.0) / self.breaks) ** 2)

    def roughness(self, depth: float, speed: float, volume: float, dull: float) -> float:
        """Return Ra by a power law of the removal rate."""
        return 0.8 * max(depth * speed, 0.02) ** 0.3


Laws = Werner | Flats | Loading | Threshold


@dataclass(kw_only=True)
class Machine:
    """Machine at work: wheel, part and the errors of its operator.

    Args:
        laws: laws of the process.
        width: width of the part, mm.
        seed: seed of the random numbers.
    """

    laws: Laws
    width: float
    seed: int
    volume: float = 0.0  #: ground volume since the dress, mm3/mm
    dull: float = 0.0
    wear: float = 0.0  #: radial wear since the last gauge or dress, mm
    pace: float = 1.0  #: factor of the part's material on the dulling, 1 for a usual one
    rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        """Load a first part."""
        self.rng = np.random.default_rng(self.seed)
        self.load()

    def load(self) -> None:
        """Put a new part on the table and touch it off."""
        self.pace = float(np.exp(0.1 * self.rng.standard_normal()))
        self.touch, self.ground, self.lag, self.hottest = 0.0012 * self.rng.standard_normal(), 0.0, 0.0, 0.0
        self.last = [0.0]
        self.speed = 1.0

    def dress(self) -> None:
        """Make the wheel sharp; the control compensates the smaller radius."""
        self.volume, self.wear = 0.0, 0.0
        self.dull = 0.0

    def gauge(self) -> None:
        """Gauge the part at an M01, and offset the wear of the wheel."""
        self.wear, self.touch = 0.0, 0.0006 * self.rng.standard_normal()

    def stroke(self, reached: float, E: float, length: float) -> float:
        """Grind one stroke at a depth below the raw surface, mm, and a table speed, mm/min; return its power, W."""
        laws, speed = self.laws, E / 60.0
        left = reached + self.touch - self.wear - self.ground
        low, high = 0.0, max(left, 0.0)
        for _ in range(30):  # bisection: depth of cut and deflection make up the infeed
            depth = 0.5 * (low + high)
            normal = laws.power(depth, speed, self.dull) * self.width / WHEEL_SPEED * laws.normal_force_ratio
            low, high = (depth, high) if depth + normal / laws.stiffness < left else (low, depth)
        depth = 0.5 * (low + high)
        if depth < 2e-5:
            self.last.append(0.0)
            return 0.0
        power = laws.power(depth, speed, self.dull)
        flux = laws.share * power / contact(depth)  # W/mm2
        self.hottest = max(self.hottest, 1.06 * flux * np.sqrt(contact(depth) / speed) / (1e-3 * EFFUSIVITY))
        ground = depth * length
        self.dull += self.pace * laws.dulls(depth, speed, self.dull) * ground
        self.volume += ground
        self.wear += ground / (laws.wears(depth, speed, self.volume) * np.pi * DIAMETER)
        self.ground += depth
        self.last.append(depth)
        self.speed = speed
        return power * self.width

    def roughness(self) -> float:
        """Return Ra of the part as it is, um."""
        usual = self.laws.roughness(float(np.mean(self.last[-3:])), self.speed, self.volume, self.dull)
        return usual * float(np.exp(0.06 * self.rng.standard_normal()))
