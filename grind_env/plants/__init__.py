"""Plants: families of out-of-model machines, and each machine by its name.

What is simulated, trained and planned with is one model; what a shop has is another machine. A `Plant` is one: a
process with hooks, a gauge, and its numbers, drawn by a seed from ranges that stand with their sources.
"""

from grind_env.plants.family import Family, Range
from grind_env.plants.names import FAMILIES, Plants, find_plant, find_plants
from grind_env.plants.plant import Plant, PlantError

__all__ = ["FAMILIES", "Family", "Plant", "PlantError", "Plants", "Range", "find_plant", "find_plants"]
