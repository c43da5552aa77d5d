"""What decides E and D, without torch: scripted rules, planners and trained agents, and how they are evaluated."""
