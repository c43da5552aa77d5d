"""Stable-Baselines3 and this package: its VecEnv over a vector environment, and its files as policies."""

from grind_env.sb3.adapter import SB3VecEnv
from grind_env.sb3.zipped import load_zip

__all__ = ["SB3VecEnv", "load_zip"]
