"""Trained agents: their observations, their network in NumPy, and their files."""
