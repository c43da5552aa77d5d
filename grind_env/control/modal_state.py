"""Modal state of the control (10-23)."""

from typing import NamedTuple


class Modes(NamedTuple):
    """Modal state left by a block for the next; the defaults are the state at power-up."""

    motion: str = "G00"  #: G00, G01, G02 or G03
    plane: str = "G18"  #: G17, G18 or G19
    incremental: bool = False  #: G91 rather than G90
    per_revolution: bool = False  #: G95 rather than G94
    inch: bool = False  #: G70 rather than G71
    diameter: bool = False  #: G08 rather than G07: X words are diameters
    compensation: str = "G40"  #: G40, G41 or G42
    corner: str = "G39"  #: G39 or G39.1
    work_system: str = "G54"  #: G54 to G59.3
    surface_speed: bool = False  #: G96 rather than G97
    feed: float | None = None  #: F, mm per minute or mm per revolution; None before the first F
    #: S, revolutions per minute, under G96 metres (G70: feet) per minute; None before the first S
    spindle: float | None = None
