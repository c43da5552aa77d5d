"""HTML views of objects in notebooks: one module for each class, with `html(object)` and sometimes `figure(object)`."""
