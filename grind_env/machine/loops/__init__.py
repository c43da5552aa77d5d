"""Compiled loops over strokes: places, tallies, and surfaces in strips and zones."""
