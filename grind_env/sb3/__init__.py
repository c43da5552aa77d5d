"""Stable-Baselines3: its VecEnv around a vector environment, and its models and files as policies."""

from grind_env.extras import needing

with needing("sb3", "grind_env.sb3 needs"):
    from grind_env.sb3.adapter import SB3VecEnv
    from grind_env.sb3.model_policy import ModelPolicy
    from grind_env.sb3.zipped import load_zip

__all__ = ["ModelPolicy", "SB3VecEnv", "load_zip"]
