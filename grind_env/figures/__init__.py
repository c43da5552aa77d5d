"""Figures of the quality of papers, each by one command of `grind figure`, and the same by one call in Python.

All are in vector formats (.svg, .pdf; .png, too), as wide as a column or a page, and readable in grey::

    cycle.py        strokes of a run                wheel.py        state of the wheel over a batch
    interval.py     cost over the dress interval    policy_map.py   E and D of an agent over its belief
"""
