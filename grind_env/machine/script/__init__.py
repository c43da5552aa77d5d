"""A script: a program as cycle blocks whose strokes depend on its words alone, and replays with other words."""
