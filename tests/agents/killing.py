"""Kills work at ever later steps until it comes to its end; for processes of one thread, because it forks."""

import os
import signal


def kill_until_done(work, watch, growth):
    """Run `work` again and again, each time killed some steps later than before; the number of kills.

    Args:
        work: to be done.
        watch: sees to it that a function is called before every step.
        growth: how much later each time, as a share of the steps, beside one step.
    """
    kills, step = 0, 1
    while (status := ended(work, watch, step)) != 0:
        assert status == -signal.SIGKILL, f"it failed after {kills} kills"
        kills, step = kills + 1, step + 1 + int(growth * step)
    return kills


def ended(work, watch, step):
    """Run `work` in a process that is killed before a step, counted from 1; the exit status."""
    process = os.fork()
    if process:
        return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])

    def count(*_):
        nonlocal step
        step -= 1
        if step == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    status = 1
    try:
        watch(count)
        work()
        status = 0
    finally:
        os._exit(status)
