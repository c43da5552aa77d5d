"""Stable-Baselines3: its VecEnv around a vector environment, and its models and files as policies."""

from grind_env.optional_libraries import needing

with needing("sb3", "grind_env.sb3 needs"):
    from grind_env.sb3.model_file import load_zip
    from grind_env.sb3.model_policy import ModelPolicy
    from grind_env.sb3.vec_env import SB3VecEnv

__all__ = ["ModelPolicy", "SB3VecEnv", "load_zip"]
