"""Datasets for offline reinforcement learning."""
