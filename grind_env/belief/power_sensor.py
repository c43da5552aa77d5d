"""The power sensor of the machine."""

POWER_NOISE = 0.03  #: relative standard deviation of a power reading
POWER_NOISE_FLOOR = 20.0  #: absolute standard deviation of a power reading, added to the relative one, W
POWER_RANGE = 5.0  #: ratio of the range of the power sensor to the power limit of the machine
