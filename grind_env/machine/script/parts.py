"""Of which part each block of a script is: what M00 divides, and of a job with stations where the parts lie."""

from collections.abc import Iterator, Sequence

from grind_env.control import Programs
from grind_env.machine.job import Job, Station
from grind_env.machine.script.block import ScriptBlock, script_error


def jobs_of(job: Job, blocks: Sequence[ScriptBlock]) -> Iterator[Job]:
    """The job of the part of each block, of a job with the stations that are met."""
    number = 1
    for block in blocks:
        yield job.of_part(number)
        number += block.ends_part


def met_by(programs: Programs, job: Job, blocks: Sequence[ScriptBlock]) -> tuple[Station, ...]:
    """The stations that parts lie at, one after the other; the blocks learn where one ends and the next one begins."""
    if not job.stations:
        return ()
    found = list[Station]()
    for loading in _loadings(blocks):
        here = next((block.station for block in loading if block.station is not None), 0)
        seen, before = list[int](), None
        for block in loading:
            here = here if block.station is None else block.station
            lying = job.lying(block.plan.axis)[here]
            if before is None or here != seen[-1]:
                if here in seen:
                    raise script_error(programs, block.plan.line, f"its strokes come back to station {lying.name}")
                if before is not None:
                    before.ends_part, before.gauged, block.loads = True, True, False
                seen.append(here)
                found.append(lying)
            before = block
    return tuple(found)


def _loadings(blocks: Sequence[ScriptBlock]) -> list[list[ScriptBlock]]:
    found: list[list[ScriptBlock]] = [[]]
    for block in blocks:
        found[-1].append(block)
        if block.ends_part:
            found.append([])
    return [each for each in found if each]
