"""Machines whose physics shares nothing with the package, and what the tools of a shop make of them."""
