"""Checks that anyone can run on an environment."""
