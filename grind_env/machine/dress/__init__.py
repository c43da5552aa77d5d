"""Dresses: the effect and time of a dress program, and the mounted wheel."""
