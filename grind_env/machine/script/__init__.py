"""A program as cycle blocks whose strokes it alone settles, and its runs with other words."""
