"""Learned agents: what they see, how they are trained, and what is kept of them."""
