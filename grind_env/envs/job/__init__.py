"""`grind/Job-v0`: every cycle block of a user's own program is a step."""
