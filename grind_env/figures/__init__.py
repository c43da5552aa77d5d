"""Figures for papers in vector formats, as wide as a column or a page, and readable in grey."""
