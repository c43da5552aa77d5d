"""Rows of a table of results as files, which a stranger may have written and anyone can run again."""
