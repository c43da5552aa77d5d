"""The example for several parts on the table: its program once for each station, and where these lie."""

from typing import Any

from grind_env.errors import GrindError

OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59")
NAMES = "ABCDEF"
APART = 300.0
"""mm, from the zero of one station to that of the next; the parts are 200 mm long, with 30 mm of overtravel."""

HEAD = """\
%
O2001 ({count} PLATES 200 X 20 MM, HARDENED 52100, STOCK 0.2 MM)
(X RECIPROCATES, Y PLUNGES TOWARDS MINUS, Z CROSSES)
(Y0 IS THE TOUCHED-OFF SURFACE OF EACH STATION, X0 AND Z0 ITS NEAR CORNER)
N10 G71 G94 G90 G19 S1910 M03
N20 M08
"""
STATION = """\
(STATION {number})
N{number}10 {offset} G00 Y20.
N{number}20 G00 X-30. Z-2.5
N{number}30 G00 Y2.
N{number}40 G01 Y0 F500.
N{number}50 G82 X230. I-30. Y-.17 J-.01 L0 F60. E15000. P9100 D1
N{number}60 M01                    (GAUGE: WHEEL WEAR IS COMPENSATED)
N{number}70 G82 Y-.2 J-.005 L4 F60. E9000.
N{number}80 G80
N{number}90 G00 Y20.
"""
END = """\
N990 M09 M05
N999 M30
"""
SUBPROGRAM, MODES = "\nO9100", "N1 G71 G90 G94"
"""Where the dress program of the example begins, and its first block."""


class StationsError(GrindError):
    """A number of stations for which there is no example."""


def stations_of(count: int) -> list[dict[str, Any]]:
    """The tables of some stations, one behind the other along the table."""
    return [
        {"name": NAMES[number - 1], "offset": OFFSETS[number - 1], "origin": [APART * (number - 1), 0.0, 0.0]}
        for number in range(1, count + 1)
    ]


def on_stations(example: str, count: int) -> str:
    """A program for some stations, one after the other, with the dress program of the example in the first offset.

    Raises:
        StationsError: there are no or too many of them.
    """
    if not 1 <= count <= len(OFFSETS):
        raise StationsError(f"--stations is {count}; choose 1 to {len(OFFSETS)}, one for each of G54 to G59")
    _, begin, dress = example.partition(SUBPROGRAM)
    parts = [STATION.format(number=number, offset=OFFSETS[number - 1]) for number in range(1, count + 1)]
    text = "".join([HEAD.format(count=count), *parts, END])
    return text + begin + dress.replace(MODES, f"{MODES} {OFFSETS[0]}")
