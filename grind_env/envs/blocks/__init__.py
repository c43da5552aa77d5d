"""Tasks of cycle blocks: their job, part program, script, simulation and writer."""
