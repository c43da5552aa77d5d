"""The Gymnasium environments: one id per task."""

import gymnasium as gym

from grind_env.envs.names import ANY_TASK, OTHERS, WEN, environment_id, task_names


def register() -> None:
    """Register every task with Gymnasium, those of users together, and the environments that are no such task."""
    for name in task_names():
        _register(environment_id(name), "any_task", task=name)
    _register(ANY_TASK, "any_task")
    for name in OTHERS:
        _register(environment_id(name), f"ids.{name}")
    gym.register(
        environment_id(WEN),
        entry_point="grind_env.envs.wen.env:WenEnv",
        vector_entry_point="grind_env.envs.wen.vector_env:WenVectorEnv",
    )


def _register(env_id: str, module: str, **fixed: str) -> None:
    make = f"grind_env.envs.{module}:make"
    gym.register(env_id, entry_point=make, vector_entry_point=f"{make}_vector", kwargs=fixed)
