"""The sample log of `grind init`; `python -m grind_env.shop.start.sample` rewrites it.

It is no measurement: the program of the folder is ground by a machine whose material is ploughed with a higher pressure
than the catalogue says, and a meter looks at its spindle.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from grind_env.control import Programs, read_file
from grind_env.files import write_atomically
from grind_env.machine.job import Job
from grind_env.machine.job.entries import with_entries
from grind_env.machine.job.file import load_job
from grind_env.shop.calibrate.pattern import Forward, pattern_of
from grind_env.shop.start.folder import HERE, LOG, start_folder

PARTS = 2
PRESSURE = 1.3
"""Ploughing pressure of the material over that of the catalogue, which a calibration finds again."""
STEP = 0.1
"""s between two rows."""
IDLE, DRIFT = 1480.0, 60.0
"""W of the idling spindle at the start, and how much of it goes as the spindle warms up."""
NOISE = 20.0
"""W, standard deviation of a row."""
GAUGING = 12.0
"""s that the operator takes between two runs of strokes."""


def sample_log(programs: Programs, job: Job) -> str:
    """Return a log of some parts with pauses between them: CSV, a row every `STEP`, time in s and power in W."""
    pressure = PRESSURE * job.part.material.ploughing_pressure
    truth = with_entries(job, {"material": {"ploughing_pressure": pressure}})
    pattern = pattern_of(programs, truth)
    powers = Forward(programs, truth, PARTS).run(truth).strokes["power"].reshape(PARTS, -1)
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
    """Write the log that the package has."""
    with TemporaryDirectory() as folder:
        program, job, *_ = start_folder(Path(folder))
        text = sample_log(read_file(program), load_job(job))
    write_atomically(HERE / LOG, lambda path: path.write_text(text, encoding="utf-8"))


if __name__ == "__main__":
    main()
