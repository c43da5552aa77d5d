"""The colours of the pictures.

Blue against orange and brick red can be told apart with every common colour blindness; nothing is said by
colour alone.
"""

Colour = tuple[int, int, int]


def _colour(text: str) -> Colour:
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


PAPER, PANEL, EDGE = _colour("#f4f4f0"), _colour("#ffffff"), _colour("#dddcd5")
INK, GREY = _colour("#2a2e35"), _colour("#585e67")
BLUE, ORANGE, BRICK, TEAL = _colour("#2a659a"), _colour("#d9822b"), _colour("#b8402a"), _colour("#4a9a97")
ORANGE_TEXT, TEAL_TEXT = _colour("#9c530a"), _colour("#276b69")  #: orange and teal that are dark enough for text
STRIP = _colour("#e9e8e2")  #: background of the block text
DRESSED = _colour("#f7e4cc")  #: background of the charts where the wheel was dressed

WHEEL, FLANGE, GUARD = _colour("#e0dbcf"), _colour("#8b929c"), _colour("#e4e5e3")
GRAIN = _colour("#a9a49a")
TABLE, BED, STEEL, STOCK, BRIGHT = map(_colour, ("#59626e", "#3f4650", "#b4bdc8", "#8d99a8", "#eef2f6"))
COOLANT, SPARK, DIAMOND = _colour("#bcd9ea"), _colour("#f0a63c"), _colour("#7fc4dd")

WEAR = (_colour("#3a78b5"), _colour("#a27ba4"), _colour("#cf4a2b"))  #: colours of a sharp, a used and a dull wheel
#: wear-flat area at which the wheel has the middle colour; rules dress at about 0.02, a burning wheel has 0.04
HALF_DULL = 0.025

#: temper colours of steel: straw, brown, purple, blue
TEMPER = (_colour("#d9b65c"), _colour("#9a5a33"), _colour("#6b4173"), _colour("#38508f"))
BLUE_RATIO = 1.5  #: ratio of temperature rise to its limit at which a burn is blue


def mix(first: Colour, second: Colour, share: float) -> Colour:
    """Return a mixture of two colours; `share` is the share of the second, 0 to 1."""
    red, green, blue = (round((1.0 - share) * a + share * b) for a, b in zip(first, second, strict=True))
    return red, green, blue


def ramp(colours: tuple[Colour, ...], share: float) -> Colour:
    """Return the colour at `share`, 0 to 1, between the first and the last of evenly spaced colours."""
    k = min(int(share * (len(colours) - 1)), len(colours) - 2)
    return mix(colours[k], colours[k + 1], share * (len(colours) - 1) - k)


def dullness(area: float) -> float:
    """Return the dullness of a wheel with this wear-flat area (a fraction), from sharp, 0, to dull, 1."""
    return area * area / (area * area + HALF_DULL * HALF_DULL)


def wear_colour(area: float) -> Colour:
    """Return the colour of a wheel of that wear-flat area, a fraction of its surface."""
    return ramp(WEAR, dullness(area))


def burn_colour(ratio: float) -> Colour:
    """Return the temper colour of a burn by the ratio of rise to limit: straw at 1, blue from `BLUE_RATIO`."""
    return ramp(TEMPER, min((ratio - 1.0) / (BLUE_RATIO - 1.0), 1.0))
