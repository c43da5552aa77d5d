"""Planners: strong references that know more than a machine measures, and one on what can be believed of it."""
