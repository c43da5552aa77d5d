"""Dresses: what a dress program does, how long it takes, and the wheel that is mounted."""
