"""The commands of `python -m agents`, one module per group."""
