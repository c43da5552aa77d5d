"""Figures of the quality of papers, each by one command of `grind figure`, and the same by one call in Python.

All are in vector formats (.svg, .pdf; .png, too), as wide as a column or a page, and readable in grey::

    dress.py    what a dress changes
"""
