"""Trained agents: how they see a task, their network in NumPy, and the files that hold them."""
