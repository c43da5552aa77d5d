"""The benchmark: tasks x policies x training seeds, on the same episodes, and the tables and figures made of it."""
