"""The sample log of `grind init`; `python -m grind_env.shop.start.sample_log` rewrites it.

The log is no measurement. A simulated machine grinds the program of the folder; its material has a higher ploughing
pressure than in the catalogue. A simulated meter records the power of the spindle.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from grind_env.control import Programs, read_file
from grind_env.files import write_atomically
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.shop.calibrate.stroke_schedule import RepeatedProgram, pattern_of
from grind_env.shop.start.starter_folder import HERE, LOG, start_folder

PARTS = 2
PRESSURE = 1.3  #: ploughing pressure of the material over the catalogue's; a calibration finds this ratio again
STEP = 0.1  #: time between two rows, s
IDLE, DRIFT = 1480.0, 60.0  #: idle power of the spindle at the start, and its decrease as the spindle warms up, W
NOISE = 20.0  #: standard deviation of the power in a row, W
GAUGING = 12.0  #: time that the operator takes between two runs of strokes, s


def sample_log(programs: Programs, job: Job) -> str:
    """Return a log of some parts with pauses between them: CSV, a row every `STEP`, time in s and power in W."""
    pressure = PRESSURE * job.part.material.ploughing_pressure
    truth = with_entries(job, {"material": {"ploughing_pressure": pressure}})
    pattern = pattern_of(programs, truth)
    powers = RepeatedProgram(programs, truth, PARTS).run(truth).strokes["power"].reshape(PARTS, -1)
    ground: list[tuple[float, float, float]] = []
    clock = 0.0
    for part in range(PARTS):
        clock += job.times.load
        for run in range(pattern.runs):
            clock += pattern.pause[run] + (GAUGING if run else 0.0)
            on, off, seconds = pattern.times(run)
            of_run = powers[part, pattern.run == run]
            ground += list(zip(clock + on, clock + off, of_run.tolist(), strict=True))
            clock += seconds
    times = np.arange(0.0, clock + job.times.load, STEP)
    shown = IDLE - DRIFT * times / times[-1] + np.random.default_rng(1).normal(0.0, NOISE, times.size)
    for on_part, off_part, power in ground:
        shown[(times >= on_part) & (times < off_part)] += power
    rows = [f"{time:.1f},{power:.0f}" for time, power in zip(times.tolist(), shown.tolist(), strict=True)]
    return "\n".join(["time [s],spindle power [W]", *rows]) + "\n"


def main() -> None:
    """Rewrite the sample log of the package."""
    with TemporaryDirectory() as folder:
        program, job, *_ = start_folder(Path(folder))
        text = sample_log(read_file(program), load_job(job))
    write_atomically(HERE / LOG, lambda path: path.write_text(text, encoding="utf-8"))


if __name__ == "__main__":
    main()
