"""`grind/WidePlates-v0`: plates wider than the wheel, ground in G83 cross picks."""
