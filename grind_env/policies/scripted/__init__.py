"""Scripted policies, each with its counterpart in shop practice."""
