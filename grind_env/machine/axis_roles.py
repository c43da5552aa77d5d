"""Roles of the axes of a surface grinder, in the order of table 16.A: X-Y-Z in plane G19.

An axis is 0 = X, 1 = Y, 2 = Z. In each plane the reciprocating axis is the one across it, its first axis
plunges and its second one crosses (PD-2), so that the roles are cyclic.
"""


def plunge_axis(reciprocating: int) -> int:
    """Return the axis that plunges, for the reciprocating axis."""
    return (reciprocating + 1) % 3


def cross_axis(reciprocating: int) -> int:
    """Return the axis that crosses, for the reciprocating axis."""
    return (reciprocating + 2) % 3
