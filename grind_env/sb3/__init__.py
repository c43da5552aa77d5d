"""Stable-Baselines3 and this package: its VecEnv over a vector environment, its models and its files as policies."""

from grind_env.extras import needing

with needing("sb3", "grind_env.sb3 needs"):
    from grind_env.sb3.adapter import SB3VecEnv
    from grind_env.sb3.model_policy import ModelPolicy
    from grind_env.sb3.zipped import load_zip

__all__ = ["ModelPolicy", "SB3VecEnv", "load_zip"]
