"""`grind/Reciprocation-v0`: G81 with a continuous infeed."""
