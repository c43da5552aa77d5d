"""Policies, planners, training, tuning and the benchmark; run from a checkout with `python -m agents`."""
