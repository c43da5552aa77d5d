"""Figures for papers: one command of `grind figure`, and one Python call, each.

All are in vector formats (.svg, .pdf; .png, too), as wide as a column or a page, and readable in grey::

    dress_effect.py    what a dress changes
"""
