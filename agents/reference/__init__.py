"""Reference scores of the tasks and their comparison with the published ones."""
