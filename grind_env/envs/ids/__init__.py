"""Ids with a form of their own: each module registers the id of its name by `make` and `make_vector`."""
