"""Machines that share no physics with the package, and tests of the shop commands on them."""
