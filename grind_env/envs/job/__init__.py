"""`grind/Job-v0`: every cycle block of the user's part program is a step."""
