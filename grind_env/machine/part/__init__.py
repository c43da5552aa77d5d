"""One part on the machine: its surface, what has been ground of it, and what it has become."""
