"""The tasks, one declarative TOML file each (scenarios, section 4), read into frozen dataclasses."""

from grind_env.envs.names import FOLDER, task_names
from grind_env.envs.tasks.checks import CROSS_FEED, PICK_FEED
from grind_env.envs.tasks.definition import Task
from grind_env.envs.tasks.numbers import DRESS_CLEARANCE, TaskNumbers
from grind_env.envs.tasks.reading import load_task, read_task
from grind_env.envs.tasks.tables import (
    ActionRange,
    Dress,
    Due,
    Kind,
    Orders,
    Spread,
    Start,
    TaskError,
    TaskSetup,
    WheelChange,
)

__all__ = [
    "CROSS_FEED",
    "DRESS_CLEARANCE",
    "FOLDER",
    "PICK_FEED",
    "ActionRange",
    "Dress",
    "Due",
    "Kind",
    "Orders",
    "Spread",
    "Start",
    "Task",
    "TaskError",
    "TaskNumbers",
    "TaskSetup",
    "WheelChange",
    "load_task",
    "read_task",
    "task_names",
]
