"""Reference scores of the tasks, and their comparison with published scores."""
