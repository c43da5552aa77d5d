"""`grind/Stroke-v0`: every stroke of a block is a step."""
