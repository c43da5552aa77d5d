"""Planners: references with privileged information, and a planner on the belief."""
