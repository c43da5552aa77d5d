"""The job: machine, set-up, part and limits, and its file."""

from grind_env.machine.job.job import Diamond as Diamond
from grind_env.machine.job.job import Job as Job
from grind_env.machine.job.job import JobError as JobError
from grind_env.machine.job.job import Lots as Lots
from grind_env.machine.job.job import Part as Part
from grind_env.machine.job.job import PartConditions as PartConditions
from grind_env.machine.job.job import Setup as Setup
from grind_env.machine.job.job import Stage as Stage
from grind_env.machine.job.job import Station as Station
from grind_env.machine.job.job import Times as Times
from grind_env.machine.job.job import WheelStart as WheelStart
from grind_env.machine.job.job import require_conditions as require_conditions
