"""The job: machine, set-up, part and limits, and its file."""

from grind_env.machine.job.errors import JobError as JobError
from grind_env.machine.job.job import Job as Job
from grind_env.machine.job.machine_setup import Diamond as Diamond
from grind_env.machine.job.machine_setup import Setup as Setup
from grind_env.machine.job.machine_setup import Times as Times
from grind_env.machine.job.machine_setup import WheelStart as WheelStart
from grind_env.machine.job.parts import Lots as Lots
from grind_env.machine.job.parts import Part as Part
from grind_env.machine.job.parts import PartConditions as PartConditions
from grind_env.machine.job.parts import Stage as Stage
from grind_env.machine.job.parts import Station as Station
from grind_env.machine.job.parts import require_conditions as require_conditions
