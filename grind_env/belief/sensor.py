"""The power sensor of the machine (scenarios, section 3)."""

POWER_NOISE = 0.03
"""Relative standard deviation of a power reading."""
POWER_NOISE_FLOOR = 20.0
"""W; added to it."""
POWER_RANGE = 5.0
"""Range of the power sensor over the power limit of the machine."""
