"""Tuning of scripted policies and of learned agents."""
