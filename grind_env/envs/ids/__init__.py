"""Ids with their own `make` and `make_vector`: each module belongs to the id of its name."""
