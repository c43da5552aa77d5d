"""The job: machine, set-up, part and limits, and the file that says them."""

from grind_env.machine.job.job import (
    Diamond,
    Job,
    JobError,
    Lots,
    Part,
    PartConditions,
    Setup,
    Stage,
    Station,
    Times,
    WheelStart,
    require_conditions,
)

__all__ = [
    "Diamond",
    "Job",
    "JobError",
    "Lots",
    "Part",
    "PartConditions",
    "Setup",
    "Stage",
    "Station",
    "Times",
    "WheelStart",
    "require_conditions",
]
