"""The adviser at the machine: E and D of the next cycle block from the readings of earlier blocks."""
