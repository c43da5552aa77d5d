"""Scripted policies, each with the shop practice that it stands for."""
