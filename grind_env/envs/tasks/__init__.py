"""The tasks, one declarative TOML file each, read into frozen dataclasses."""

from grind_env.envs.task_names import FOLDER as FOLDER
from grind_env.envs.task_names import task_names as task_names
from grind_env.envs.tasks.definition import CROSS_FEED as CROSS_FEED
from grind_env.envs.tasks.definition import DRESS_CLEARANCE as DRESS_CLEARANCE
from grind_env.envs.tasks.definition import PICK_FEED as PICK_FEED
from grind_env.envs.tasks.definition import Task as Task
from grind_env.envs.tasks.reading import load_task as load_task
from grind_env.envs.tasks.reading import read_task as read_task
from grind_env.envs.tasks.tables import ActionRange as ActionRange
from grind_env.envs.tasks.tables import Dress as Dress
from grind_env.envs.tasks.tables import Due as Due
from grind_env.envs.tasks.tables import Kind as Kind
from grind_env.envs.tasks.tables import Orders as Orders
from grind_env.envs.tasks.tables import Spread as Spread
from grind_env.envs.tasks.tables import Start as Start
from grind_env.envs.tasks.tables import TaskError as TaskError
from grind_env.envs.tasks.tables import TaskSetup as TaskSetup
from grind_env.envs.tasks.tables import WheelChange as WheelChange
