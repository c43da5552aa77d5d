"""Random programs that grind, run in all ways.

`machine.grind` grinds a program that `check` accepts, or refuses it with one sentence. Stroke by stroke, the record is
equal to the bit. Block by block, compiled or not, wheels are equal to the bit and sums over a run to 1e-9.
"""

import time
from collections import Counter

from grind_env.machine.job.job_writer import job_text
from tests.soak.examine import examine
from tests.soak.part import Part, Tried
from tests.soak.writer import case

WARM = 60  #: number of programs after which all code is compiled


def warm_up() -> None:
    """Run programs without a time limit, so that numba compiles the code."""
    for seed in range(WARM):
        examine(case(seed), seconds=600.0)


def attempt(seed: int) -> Tried:
    """Grind the program of a seed in all ways."""
    began = time.process_time()
    drawn = case(seed)
    examined = examine(drawn)
    most = {"slowest program, s": time.process_time() - began}
    sums: Counter[str] = Counter(examined.happened)
    sums[f"end: {examined.end or 'fell'}"] += 1
    sums[f"replay: {examined.replay or 'none'}"] += 1
    sums["strokes ground"] += examined.strokes
    sums["wheels to the bit"], sums["wheels compared"] = examined.exact
    if examined.findings:
        kinds = sorted({finding.kind for finding in examined.findings})
        details = [finding.details for finding in examined.findings]
        return Tried("fallen", kinds[0], "\n".join([*kinds, *details, drawn.text, job_text(drawn.job)]), sums, most)
    return Tried("accepted" if examined.end == "ground" else "refused", sums=sums, most=most)


PART = Part(name="programs", attempt=attempt, prepare=warm_up, share=14.0, seconds=600.0)
