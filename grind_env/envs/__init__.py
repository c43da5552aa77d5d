"""The Gymnasium environments: one id per task."""

import gymnasium as gym

from grind_env.envs.names import ANY_TASK, OTHERS, camel, environment_id, task_names


def register() -> None:
    """Register every task with Gymnasium, those of users together, and the environments that are no such task."""
    for name in task_names():
        gym.register(
            environment_id(name),
            entry_point="grind_env.envs.env:GrindEnv",
            vector_entry_point="grind_env.envs.vector_env:GrindVectorEnv",
            kwargs={"task": name},
        )
    gym.register(
        ANY_TASK,
        entry_point="grind_env.envs.env:GrindEnv",
        vector_entry_point="grind_env.envs.vector_env:GrindVectorEnv",
    )
    for name in OTHERS:
        gym.register(
            environment_id(name),
            entry_point=f"grind_env.envs.{name}.env:{camel(name)}Env",
            vector_entry_point=f"grind_env.envs.{name}.vector_env:{camel(name)}VectorEnv",
        )
