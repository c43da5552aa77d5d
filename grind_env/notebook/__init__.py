"""How objects show themselves in a notebook: a module for each, with `html(object)` and its figure, if any."""
