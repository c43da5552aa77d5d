"""The process: materials, wheels and machines, and the equations of one stroke and one dress. No G-code."""
