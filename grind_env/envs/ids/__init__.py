"""The ids of a form of their own: a module registers the one of its name, of which it has `make` and `make_vector`."""
