"""Read measured files of a shop: logs, gauge files, tables of settings, readings of blocks."""
