"""Starting points: a job with every key explained, and a folder with a program that runs."""
