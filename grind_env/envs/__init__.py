"""The Gymnasium environments: one id per task."""

import gymnasium as gym

from grind_env.envs.names import environment_id, task_names


def register() -> None:
    """Register every task with Gymnasium."""
    for name in task_names():
        gym.register(
            environment_id(name),
            entry_point="grind_env.envs.env:GrindEnv",
            vector_entry_point="grind_env.envs.vector_env:GrindVectorEnv",
            kwargs={"task": name},
        )
