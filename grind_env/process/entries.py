"""Catalogue entries: work materials, wheels, dressers, fluids and machines.

Each field of an entry states its symbol in the process model and in the literature (Malkin; Rowe; Wen, Tay and Nee),
its unit and its legal range. The ranges are those in which the equations hold. They are wider than any grinding job
needs, so that a calibration has room.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from inspect import get_annotations
from numbers import Real
from typing import Annotated, Any, ClassVar

from grind_env.errors import GrindError
from grind_env.message_text import quoted

ALUMINA, CBN = "alumina", "cbn"  #: abrasives
CLOSEST = 0.99  #: largest ratio of the lesser to the greater field of a pair of `ASCENDING`


class CatalogueError(GrindError):
    """An unknown entry or key, or a value that the process model cannot use."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Legal numbers of a field: from `low` to `high`, both allowed, in `unit` ("" without one)."""

    symbol: str
    unit: str
    low: float
    high: float

    def allows(self, value: Any) -> bool:
        """Return whether a value is a number within the range."""
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        return is_number and self.low <= value <= self.high

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()


@dataclass(frozen=True, slots=True)
class Choice:
    """Legal words of a field."""

    words: tuple[str, ...]

    def allows(self, value: Any) -> bool:
        """Return whether a value is one of the words."""
        return value in self.words

    def __str__(self) -> str:
        return " or ".join(quoted(word) for word in self.words)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """Base of all entries; construction, and so `dataclasses.replace`, checks every field.

    Raises:
        CatalogueError: A field is no number within its range, or a pair of `ASCENDING` is not in order.
    """

    #: pairs of fields of which the first must be less than the second
    ASCENDING: ClassVar[tuple[tuple[str, str], ...]] = ()

    name: str
    #: other names of the entry, such as its name in a standard
    aliases: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.aliases, list | tuple) or not all(isinstance(each, str) for each in self.aliases):
            raise CatalogueError(f"{self}: aliases is {quoted(self.aliases)}, but must be a list of texts.")
        object.__setattr__(self, "aliases", tuple(self.aliases))
        for key, quantity in quantities(type(self)).items():
            value = getattr(self, key)
            if not quantity.allows(value):
                legal = f"a number from {quantity}" if isinstance(quantity, Quantity) else quantity
                raise CatalogueError(f"{self}: {key} is {quoted(value)}, but must be {legal}.")
            object.__setattr__(self, key, float(value) if isinstance(quantity, Quantity) else value)
        for lesser, greater in self.ASCENDING:
            low, high = getattr(self, lesser), getattr(self, greater)
            if not low < high:
                raise CatalogueError(f"{self}: {lesser} is {low:g}, but must be below {greater}, {high:g}.")

    def ends(self, key: str) -> tuple[float, float]:
        """Return the least and the greatest legal value of a field, given the other fields, in its unit."""
        quantity = quantities(type(self))[key]
        assert isinstance(quantity, Quantity)
        low, high = quantity.low, quantity.high
        for lesser, greater in self.ASCENDING:
            low = max(low, getattr(self, lesser) / CLOSEST) if key == greater else low
            high = min(high, getattr(self, greater) * CLOSEST) if key == lesser else high
        return low, high

    def within(self, key: str, value: float) -> float:
        """Return a value of a field, or the nearest legal value."""
        low, high = self.ends(key)
        return min(max(value, low), high)

    def __str__(self) -> str:
        return label(type(self), self.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class Material(Entry):
    """A work material; factors compare it with hardened AISI 52100."""

    chip_energy: Annotated[float, Quantity("u_ch", "J/mm3", 1, 100)]  # energy of chip formation
    chip_heat: Annotated[float, Quantity("e_ch", "J/mm3", 0, 50)]  # heat that leaves with the chips
    ploughing_pressure: Annotated[float, Quantity("kp", "N/mm2", 0.01, 20)]  # tangential, at reference grain density
    conductivity: Annotated[float, Quantity("k", "W/(m K)", 1, 500)]
    density: Annotated[float, Quantity("rho", "kg/m3", 1000, 20_000)]
    specific_heat: Annotated[float, Quantity("c", "J/(kg K)", 100, 2000)]
    youngs_modulus: Annotated[float, Quantity("Ew", "GPa", 20, 700)]
    poisson_ratio: Annotated[float, Quantity("nuw", "", 0, 0.49)]
    wear_flat_growth: Annotated[float, Quantity("kA", "1/mm", 0, 1e-4)]  # wear-flat area gained per mm of grain sliding
    loading_rate: Annotated[float, Quantity("kL", "1/(mm3/mm)", 0, 0.1)]  # loading gained per specific volume removed
    tempering_rise: Annotated[float, Quantity("T_temper", "K", 50, 2000)]  # surface rise that softens the work
    g_ratio_factor: Annotated[float, Quantity("gA", "", 0.001, 10)]  # on the G-ratio of alumina wheels
    g_ratio_factor_cbn: Annotated[float, Quantity("gC", "", 0.001, 10)]  # on the G-ratio of CBN wheels
    g_ratio_exponent: Annotated[float, Quantity("mG", "", 0, 2)]  # exponent of the wheel wear on the chip thickness
    pressure_factor: Annotated[float, Quantity("pm", "", 0.1, 10)]  # on the wear-flat pressure
    burn_energy: Annotated[float, Quantity("u0", "J/mm3", 0, 50)]  # constant term of Malkin's burn threshold
    burn_rise: Annotated[float, Quantity("T_burn", "K", 50, 3000)]  # surface rise at burn, for Malkin's contact length
    thermal_expansion: Annotated[float, Quantity("alpha_th", "1/K", 0, 1e-4)] = 12e-6
    power_factor: Annotated[float, Quantity("cF", "", 0.1, 10)] = 1.0  # on the tangential force, found by calibration
    heat_factor: Annotated[float, Quantity("cH", "", 0.02, 10)] = 1.0  # on the heat into the work, found by calibration
    power_depth_exponent: Annotated[float, Quantity("cu", "", -2, 2)] = 0.0  # exponent of force on interference
    power_speed_exponent: Annotated[float, Quantity("cv", "", -2, 2)] = 0.0  # exponent of force on table speed
    power_volume_exponent: Annotated[float, Quantity("cV", "", -2, 2)] = 0.0  # exponent of force on volume since dress

    @property
    def effusivity(self) -> float:
        """Thermal contact coefficient beta = sqrt(k rho c), J/(m2 K s^0.5)."""
        return math.sqrt(self.conductivity * self.density * self.specific_heat)

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity alpha = k/(rho c), mm2/s."""
        return 1e6 * self.conductivity / (self.density * self.specific_heat)

    @property
    def burn_factor(self) -> float:
        """Slope of Malkin's burn threshold, J/(mm2 s^0.5): the flux that heats the work by `burn_rise` [M]."""
        return 1e-6 * self.burn_rise * self.effusivity / 1.13


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel(Entry):
    """A grinding wheel; volumes are mm3 per mm of engaged width, areas fractions of the wheel face.

    Values that depend on grit size or structure hold for a 0.25 mm grit (mesh 60) and a grain volume fraction of 0.52.
    """

    ASCENDING = (
        ("minimum_diameter", "diameter"),
        ("wear_flat_floor", "wear_flat_limit"),
        ("dressed_wear_flat", "wear_flat_limit"),
    )

    abrasive: Annotated[str, Choice((ALUMINA, CBN))]  # selects the G-ratio factor of the material
    diameter: Annotated[float, Quantity("ds0", "mm", 100, 600)]  # when new
    minimum_diameter: Annotated[float, Quantity("ds_min", "mm", 50, 600)]  # below it the wheel is changed
    maximum_speed: Annotated[float, Quantity("vs_max", "m/s", 5, 300)] = 300.0  # allowed by its maker
    width: Annotated[float, Quantity("bs", "mm", 5, 300)]  # of the face
    price: Annotated[float, Quantity("cs", "$/mm3", 0, 1)]  # of the volume that is worn or dressed off
    grit_size: Annotated[float, Quantity("dg", "mm", 0.02, 1)]  # for alumina about 15.2 over the mesh number
    grain_fraction: Annotated[float, Quantity("Vg", "", 0.2, 0.65)]  # grain share of the volume: the structure
    grain_conductivity: Annotated[float, Quantity("kg", "W/(m K)", 1, 2000)]  # effective, of one grain
    youngs_modulus: Annotated[float, Quantity("Es", "GPa", 5, 500)]
    poisson_ratio: Annotated[float, Quantity("nus", "", 0, 0.49)]
    contact_roughness: Annotated[float, Quantity("Rr", "", 1, 20)]  # Rowe and Qi's roughness factor
    friction: Annotated[float, Quantity("mu", "", 0.05, 1)]  # between wear flat and work, in emulsion
    normal_force_ratio: Annotated[float, Quantity("kc", "", 1, 5)]  # normal over tangential in cutting, in emulsion
    pressure_base: Annotated[float, Quantity("pa", "N/mm2", 0, 1000)]  # wear-flat pressure at no curvature difference
    pressure_slope: Annotated[float, Quantity("pb", "N/mm", 0, 1e7)]  # slope of this pressure on that difference
    threshold_depth: Annotated[float, Quantity("a0", "mm", 1e-6, 0.01)]  # contact depth at zero depth of cut
    g_ratio: Annotated[float, Quantity("Gref", "", 0.1, 1e6)]  # steady, without fracture, at chip thickness 0.1 um
    g_ratio_fluid: Annotated[float, Quantity("xf", "", 0, 2)]  # exponent of the fluid's g_ratio_factor
    fracture_force: Annotated[float, Quantity("fc", "N", 0.01, 20)]  # per grain; stands for the wheel grade
    fracture_factor: Annotated[float, Quantity("kf", "", 0, 20)]  # extra wear above fracture_force
    renewal_depth: Annotated[float, Quantity("dr", "mm", 0.0005, 0.5)]  # wear that renews the face
    initial_wear: Annotated[float, Quantity("wi", "mm", 0, 0.1)]  # radial wear early after a medium dress
    initial_wear_volume: Annotated[float, Quantity("Vi", "mm3/mm", 1, 1000)]  # in which 3/4 of initial_wear are lost
    wear_flat_floor: Annotated[float, Quantity("Af", "", 0, 0.1)]  # wear-flat area of a face renewed by fracture
    wear_flat_rate: Annotated[float, Quantity("ka", "", 0, 10)]  # factor on the material's wear_flat_growth
    wear_flat_limit: Annotated[float, Quantity("Amax", "", 0.02, 0.5)]  # largest wear-flat area
    loading_area: Annotated[float, Quantity("AL", "", 0, 0.2)]  # rubbing area of a fully loaded face
    dressed_wear_flat: Annotated[float, Quantity("Ad", "", 1e-5, 0.1)]  # wear-flat area after a medium dress
    damage_depth: Annotated[float, Quantity("dd", "mm", 0.0005, 0.1)]  # damaged layer that a dress has to remove
    roughness: Annotated[float, Quantity("RaRef", "um", 0.02, 5)]  # roughness scale after a medium dress
    roughness_floor: Annotated[float, Quantity("f0", "", 0.05, 2)]  # Ra after full spark-out over this scale
    roughness_rate: Annotated[float, Quantity("f1", "", 0, 2)]  # Ra added at 3 mm2/s, over this scale
    settling_volume: Annotated[float, Quantity("Vr", "mm3/mm", 1, 1000)]  # volume in which the dressed texture fades
    roughness_wear_exponent: Annotated[float, Quantity("nr", "", 0, 1)]  # exponent of Ra on the wheel wear


@dataclass(frozen=True, slots=True, kw_only=True)
class Dresser(Entry):
    """A diamond dresser, standing or rotary; exponents apply to the roughness that a dress leaves on the wheel."""

    tip_radius: Annotated[float, Quantity("rd", "mm", 0.05, 5)]  # of the diamond
    cost_per_dress: Annotated[float, Quantity("cD", "$", 0, 1000)]  # of the diamond, per dress execution
    lead_exponent: Annotated[float, Quantity("nf", "", 0, 2)] = 0.5  # on the dress lead
    depth_exponent: Annotated[float, Quantity("na", "", 0, 1)] = 0.25  # on the depth of a pass
    blunting_exponent: Annotated[float, Quantity("nw", "", 0, 2)] = 0.3  # of the smoothing by a blunt diamond
    speed_ratio: Annotated[float, Quantity("qd", "", -2, 2)] = 0.0  # dresser over wheel speed; 0 if the tool stands
    speed_ratio_exponent: Annotated[float, Quantity("nq", "", 0, 2)] = 0.0  # on the speed ratio
    sharpness_exponent: Annotated[float, Quantity("ns", "", 0, 2)] = 0.0  # exponent of the severity on the speed ratio


@dataclass(frozen=True, slots=True, kw_only=True)
class Fluid(Entry):
    """A grinding fluid and the way it is delivered; factors compare it with emulsion."""

    convection: Annotated[float, Quantity("hf", "W/(m2 K)", 10, 1e6)]  # in a contact of 2.4 mm at 30 m/s, not boiling
    boiling_rise: Annotated[float, Quantity("Tb", "K", 20, 1e5)]  # surface rise at which the film boils
    film_share: Annotated[float, Quantity("kfilm", "", 0, 1)] = 0.1  # of the convection after the film has boiled off
    friction_factor: Annotated[float, Quantity("fm", "", 0.1, 5)] = 1.0  # on the friction of wear flats
    force_ratio_factor: Annotated[float, Quantity("fk", "", 0.3, 3)] = 1.0  # on the ratio of tangential to normal force
    ploughing_factor: Annotated[float, Quantity("Fp", "", 0.1, 5)] = 1.0  # on the ploughing pressure
    loading_factor: Annotated[float, Quantity("fL", "", 0, 20)] = 1.0  # on the loading rate
    wear_flat_factor: Annotated[float, Quantity("fA", "", 0, 20)] = 1.0  # on the wear-flat growth
    g_ratio_factor: Annotated[float, Quantity("fG", "", 0.01, 20)] = 1.0  # on the G-ratio
    part_cooling: Annotated[float, Quantity("hp", "W/(m2 K)", 0, 1e5)] = 3000.0  # convection on the part under flood


@dataclass(frozen=True, slots=True, kw_only=True)
class Machine(Entry):
    """A surface grinder; the power limit less the idle power is available for grinding."""

    ASCENDING = (("idle_power", "power_limit"),)

    stiffness: Annotated[float, Quantity("ke", "N/mm", 1000, 500_000)]  # normal, of the loop from wheel to work
    power_limit: Annotated[float, Quantity("Pmax", "W", 100, 500_000)]  # of the spindle, idle power included
    idle_power: Annotated[float, Quantity("P_idle", "W", 0, 100_000)]  # of the spindle; not available for grinding
    stall_speed: Annotated[float, Quantity("rs", "", 0.2, 0.98)] = 0.6  # wheel speed at a stall over the set speed
    meter_scale: Annotated[float, Quantity("cP", "", 0.1, 10)] = 1.0  # reading of the power meter over true power
    stall_time: Annotated[float, Quantity("t_stall", "s", 0, 86_400)] = 600.0  # lost by a stall
    acceleration: Annotated[float, Quantity("acc", "mm/s2", 10, 100_000)]  # of the table
    reversal_dwell: Annotated[float, Quantity("t_rev", "s", 0, 10)]  # rest of the table at each reversal
    rapid_feed: Annotated[float, Quantity("G00", "mm/min", 100, 200_000)]  # of G00
    hourly_rate: Annotated[float, Quantity("Cm", "$/h", 0, 10_000)]  # of machine and labour
    chuck_conductance: Annotated[float, Quantity("hc", "W/(m2 K)", 0, 1e5)] = 2000.0  # for heat from part to chuck
    maximum_table_speed: Annotated[float, Quantity("E_max", "mm/min", 100, 200_000)] = 200_000.0
    maximum_plunge_feed: Annotated[float, Quantity("F_plunge", "mm/min", 1, 200_000)] = 200_000.0
    maximum_cross_feed: Annotated[float, Quantity("F_cross", "mm/min", 1, 200_000)] = 200_000.0
    maximum_spindle_speed: Annotated[float, Quantity("n_max", "1/min", 100, 200_000)] = 200_000.0


def quantities(kind: type[Entry]) -> Mapping[str, Quantity | Choice]:
    """Return the legal values of the fields that an entry class adds to `Entry`, by field name."""
    # Entry classes are one level deep, so that the class's own annotations are all of them.
    return {key: hint.__metadata__[0] for key, hint in get_annotations(kind).items()}


def label(kind: type[Entry], name: object) -> str:
    """Return the name of an entry in messages: `wheel 'a60j'`."""
    return f"{kind.__name__.lower()} {quoted(name)}"
