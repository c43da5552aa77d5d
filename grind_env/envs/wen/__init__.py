"""`grind/Wen-v0`: a published one-step problem."""
