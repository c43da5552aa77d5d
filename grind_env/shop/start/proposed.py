"""The folder of a part that has no program yet: as that of the example, with a program that is proposed."""

from pathlib import Path

from grind_env.control import read
from grind_env.files import read_text
from grind_env.shop.optimise.variation import Progress
from grind_env.shop.start.asked import Asked, job_in, texts_of
from grind_env.shop.start.folder import FILES, HERE, LOG, NOTEBOOK, PROGRAM, require_new, write_folder
from grind_env.shop.start.proposal import Proposal, proposal_of
from grind_env.shop.start.sample import sample_log

EXAMPLE_FEED = "E15000."
"""Of the example, which its notebook changes."""


def propose_folder(
    folder: Path, asked: Asked, *, seconds: float, seed: int, progress: Progress = lambda label, count: None
) -> tuple[list[Path], Proposal]:
    """Propose a program for a part, and write it with its job and all that `start_folder` writes.

    Args:
        folder: is made if need be.
        asked: of the part.
        seconds: as of `proposal_of`, like the ones after it.
        seed: of lots and search.
        progress: is told what is being done.

    Returns:
        The files, the program first, and the proposal.

    Raises:
        NotHeldError: no program that was tried keeps the limits; nothing is written.
        ExistsError: one of the files is there already, which is found out before the search.
        GrindError: as of `texts_of` and `write_folder`.
    """
    require_new(folder, FILES)
    texts = texts_of(asked)
    job = job_in(texts)
    proposal = proposal_of(job, seconds=seconds, seed=seed, progress=progress)
    program = proposal.text
    notebook = read_text(HERE / NOTEBOOK).replace(EXAMPLE_FEED, f"E{proposal.words.rough_feed:.0f}.")
    log = sample_log(read(program, PROGRAM), job)
    return write_folder(folder, {PROGRAM: program, **texts, NOTEBOOK: notebook, LOG: log}), proposal
