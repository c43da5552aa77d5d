"""The ids of the environments: importing this module registers them with Gymnasium."""

import gymnasium as gym

from grind_env.envs.task_names import ANY_TASK, MODULE_NAMES, environment_id, task_names


def _register(env_id: str, module: str, **fixed: str) -> None:
    make = f"grind_env.envs.{module}:make"
    gym.register(env_id, entry_point=make, vector_entry_point=f"{make}_vector", kwargs=fixed)


for name in task_names():
    _register(environment_id(name), "task_env_factory", task=name)
_register(ANY_TASK, "task_env_factory")
for name in MODULE_NAMES:
    _register(environment_id(name), f"ids.{name}")
