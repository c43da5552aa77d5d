"""The operator's requests for a dress, in programs of blocks that have no auto-dress."""

from dataclasses import replace

from grind_env.control import Motion, Programs, Source, execute
from grind_env.machine.job import Job
from grind_env.machine.run import GrindingRun

REQUEST = "OPERATOR ASKS FOR A DRESS"
"""Comment on the dwell in which the operator's request is served."""


def request_times(programs: Programs, job: Job) -> tuple[float, ...]:
    """Times of the control, s, at which the operator asks for a dress; for `Control.operator_dress_at`.

    A request is made when the last motion or dwell before the dwell that says so has ended.
    """
    ahead, before = set(), 0
    for source in programs.main.blocks:
        if REQUEST in source.text:
            ahead.add(before)
        if source.text.startswith("G04") or " Y" in source.text:
            before = source.line
    if not ahead:
        return ()
    control, times = replace(job.control), []
    execution = execute(programs, control)
    run = None if job.process.before is None else GrindingRun(programs, job, control, job.parts)
    for event in execution:
        if run is not None:  # the table has a speed of its own
            run.take(event)
            run.tell(execution)
        if isinstance(event, Motion) and event.source is Source.PROGRAM and event.line in ahead:
            control.request_dress()
            # just after it, not in the same moment, in which the table may turn
            times.append(event.finish + 1e-6)
    return tuple(times)
