"""HTML views of objects in notebooks: a module for each, with `html(object)` and its figure, if any."""
