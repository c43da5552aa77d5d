"""The tasks, one declarative TOML file each, read into frozen dataclasses."""

from grind_env.envs.task_names import FOLDER, task_names
from grind_env.envs.tasks.definition import CROSS_FEED, DRESS_CLEARANCE, PICK_FEED, Task
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
    "TaskSetup",
    "WheelChange",
    "load_task",
    "read_task",
    "task_names",
]
