"""The machine: control and process joined, for one part program and for the cycles of many machines at once."""
