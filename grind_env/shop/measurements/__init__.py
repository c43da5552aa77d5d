"""Measured files of a shop as numbers, times and words: logs, gauge files, tables of settings, readings of blocks."""
