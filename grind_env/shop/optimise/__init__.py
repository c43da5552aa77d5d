"""Optimise the words of a part program, and write the changed text."""
