"""The adviser at the machine: E and D of the next cycle block from what was measured of those before."""
