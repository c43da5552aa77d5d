"""Plants: families of out-of-model machines, and each machine by its name.

The package simulates, trains and plans with one model; a shop has another machine. A `Plant` is such a machine: a
process with hooks, a gauge, and numbers drawn by a seed from ranges with sources.
"""

from grind_env.plants.family import Family, Range
from grind_env.plants.plant import Plant, PlantError
from grind_env.plants.plant_names import FAMILIES, Plants, find_plant, find_plants

__all__ = ["FAMILIES", "Family", "Plant", "PlantError", "Plants", "Range", "find_plant", "find_plants"]
