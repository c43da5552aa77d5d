"""The machine set-up of a job: wheel, dresser, fluid and machine, times, and the wheel at the start."""

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from grind_env.machine.job.errors import JobError
from grind_env.process.entries import Dresser, Fluid, Machine, Quantity, Wheel
from grind_env.process.toml_tables import check

#: by program: its words act. Always on: the operator does the work, and the words have no effect
ByHand: TypeAlias = Literal["by program", "always on"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Wheel, dresser, fluid and machine.

    Attributes:
        wheel: grinding wheel.
        dresser: diamond.
        fluid: coolant.
        machine: machine tool.
        wheel_speed: surface speed of the new wheel.
        constant_surface_speed: whether the control holds `wheel_speed` as the wheel shrinks (12-41).
        spindle: "by program": S, G96 and M03 to M05 start the wheel and set its speed; "always on": the operator sets
            `wheel_speed`, and these words have no effect.
        coolant: "by program": M07 and M08 turn the fluid on and M09 off, and without it the wheel grinds dry; "always
            on": the fluid flows regardless.
        dresser_infeed: infeed of the dresser before each pass, if the dress program has none. Without either, 0.02 mm
            is assumed, with a warning.
        grooving_wheel: whether this wheel grinds the grooves of G76 and G77; otherwise a turning tool cuts them, and
            only the time counts.
    """

    wheel: Wheel
    dresser: Dresser
    fluid: Fluid
    machine: Machine
    wheel_speed: Annotated[float, Quantity("vs", "m/s", 5, 150)] = 30.0
    constant_surface_speed: bool = False
    spindle: ByHand = "by program"
    coolant: ByHand = "by program"
    dresser_infeed: Annotated[float | None, Quantity("ad", "mm", 0.0005, 0.1)] = None
    grooving_wheel: bool = False

    def __post_init__(self) -> None:
        check(self, "setup", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Times:
    """Times that the program does not state.

    Attributes:
        load: time from the end of a part to the first cycle of the next part, travel included.
        gauge: time from an M01, at which the part is gauged, to the next cycle, travel included; none if the table
            keeps moving.
        dress_setup: time of a dress execution in addition to the motions of its program.
        wheel_change: time to replace a wheel that is below its least diameter; the operator does this when the part is
            taken off or gauged. Left out if the worn wheel stays.
    """

    load: Annotated[float, Quantity("t_load", "s", 0, 86_400)] = 20.0
    gauge: Annotated[float, Quantity("t_gauge", "s", 0, 86_400)] = 0.0
    dress_setup: Annotated[float, Quantity("t_d0", "s", 0, 86_400)] = 8.0
    wheel_change: Annotated[float | None, Quantity("", "s", 0, 86_400)] = None

    def __post_init__(self) -> None:
        check(self, "times", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelStart:
    """State of the wheel at the start; None for the value of a new, freshly dressed wheel.

    Attributes:
        diameter: diameter of the wheel.
        wear_flat_area: wear-flat area A, share of the wheel face.
        volume_since_dress: volume V ground since the last dress, per mm of width.
        diamond_flat: width of the wear flat on the dressing diamond.
    """

    diameter: Annotated[float | None, Quantity("ds", "mm", 50, 600)] = None
    wear_flat_area: Annotated[float | None, Quantity("A", "", 1e-4, 0.5)] = None
    volume_since_dress: Annotated[float | None, Quantity("V", "mm3/mm", 0, 1e6)] = None
    diamond_flat: Annotated[float, Quantity("wd", "mm", 0, 2)] = 0.0

    def __post_init__(self) -> None:
        check(self, "wheel", JobError)


@dataclass(frozen=True, slots=True, kw_only=True)
class Diamond:
    """Position of the tip of the dressing diamond on the table, as axis coordinates of the wheel there.

    Its height counts for the touched-off wheel: wheel wear from dresses is compensated as on the part. The wheel comes
    down on the diamond; leave the table out for a diamond above the wheel.

    Attributes:
        x: coordinate of the X axis.
        y: coordinate of the Y axis.
        z: coordinate of the Z axis.
    """

    x: Annotated[float, Quantity("", "mm", -10_000, 10_000)]
    y: Annotated[float, Quantity("", "mm", -10_000, 10_000)]
    z: Annotated[float, Quantity("", "mm", -10_000, 10_000)]

    def __post_init__(self) -> None:
        check(self, "diamond", JobError)

    @property
    def tip(self) -> tuple[float, float, float]:
        """Return the coordinates X, Y and Z of the tip, mm."""
        return self.x, self.y, self.z
