"""The benchmark: tasks x policies x training seeds on the same episodes, with tables and figures of the results."""
