"""The machine: control and process together, for one part program and for the cycles of many machines at once."""
