"""The Gymnasium environments: one id per task."""

import gymnasium as gym

from grind_env.envs.names import ANY_TASK, OTHERS, WEN, environment_id, task_names


def register() -> None:
    """Register every task with Gymnasium, those of users together, and the environments that are no such task."""
    for name in task_names():
        _register(environment_id(name), "ids:task", task=name)
    _register(ANY_TASK, "ids:task")
    for name in OTHERS:
        _register(environment_id(name), f"ids:{name}")
    _register(environment_id(WEN), "wen.env:WenEnv", "wen.vector_env:WenVectorEnv")


def _register(env_id: str, single: str, vector: str = "", **fixed: str) -> None:
    single, vector = (f"grind_env.envs.{each}" for each in (single, vector or f"{single}_vector"))
    gym.register(env_id, entry_point=single, vector_entry_point=vector, kwargs=fixed)
