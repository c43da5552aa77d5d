"""One part on the machine: its surface, its ground volume and its result."""
