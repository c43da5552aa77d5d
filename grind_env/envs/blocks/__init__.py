"""Tasks of cycle blocks: their numbers, tapes, compiled step, observations and programs."""
